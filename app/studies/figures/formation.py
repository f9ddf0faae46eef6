"""What flocks save over time and over many runs, and a flock from above at the end."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import box, draw_key
from app.studies.experiment import Experiment, flock_of
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import PERCENT, RARE, SHARE, Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# Runs in which it is measured what birds save by each other's upwash; thesis, section 2.3.


class FormationSettings(Settings):
    """How long a flock is left alone and looked at, and what a share of induced drag is worth."""

    kind: ClassVar[str] = "formation"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("saved", "saved", "Induced drag saved", "%", "all have crashed"),
        Measure("power", "power", "Power saved", "%", "all have crashed"),
        Measure("joules", "per metre", "Energy that a bird saves per metre", "mJ/m", "not known"),
        Measure(
            "best",
            "best",
            "Birds that save more than half",
            "%",
            "all have crashed",
            bounds=PERCENT,
        ),
        Measure("p", "p", "Polarisation", "1", "all have crashed", bounds=SHARE),
        Measure("groups", "groups", "Groups at the end", "groups", whole=True),
        Measure("largest", "largest", "Birds in the largest group at the end", "%", bounds=PERCENT),
        Measure("crashes", "crashes", "Crashes", "agents", whole=True, bounds=RARE),
    )

    settle: int = Field(ge=0)
    """Ticks before a flock is looked at."""
    looks: int = Field(ge=1)
    """How often it is looked at; savings and polarisation are means over the looks."""
    every: int = Field(ge=1)
    """Ticks between two looks."""
    induced: float = Field(0.35, ge=0.0, le=1.0)
    """Share of the power that is induced: assumed."""
    energy: float | None = Field(None, gt=0.0)
    """What a bird alone needs for a metre, J/m; None where lengths are no metres."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let the flock settle, then look at it."""
        between()
        flock.run(self.settle)
        shares, polarised = [], []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            shares.append(flock.signal("saved")[flock.active])
            polarised.append(flock.observe("polarisation"))
        every = np.concatenate(shares)
        saved = float(every.mean()) if len(every) else None
        power = None if saved is None else self.induced * saved
        joules = None if power is None or self.energy is None else 1000.0 * power * self.energy
        return {
            "saved": None if saved is None else 100.0 * saved,
            "power": None if power is None else 100.0 * power,
            "joules": joules,
            "best": None if saved is None else 100.0 * float((every > 0.5).mean()),
            "p": None if saved is None else float(np.mean(polarised)),
            "groups": int(flock.observe("groups")),
            "largest": 100.0 * flock.observe("largest-group") / len(flock.ids),
            "crashes": len(flock.crashes),
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.settle + self.looks * self.every


def follow_savings(flock: Flock, ticks: int, every: int) -> tuple[np.ndarray, np.ndarray]:
    """Times (K,), s, and the mean share (K,) of induced drag that those that fly save then."""
    time, saved = [], []
    while flock.tick < ticks:
        flock.run(every)
        time.append(flock.elapsed)
        saved.append(flock.signal("saved")[flock.active].mean())
    return np.array(time), np.array(saved)


COLOURS = ("#1f9d63", "#c0392b", "#2166ac", "#b07d12", "#8e44ad")
INK = "#3c434b"
SHADES = "BrBG"
LOOKS = 160
"""Points of a curve over time."""


def draw_formation(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """Draw the run of that seed in the rows of the first size over time, all runs, one flock."""
    settings = experiment.settings
    assert isinstance(settings, FormationSettings)
    figure.set_size_inches(13.0, 5.2)
    over_time, runs, above = figure.subplots(1, 3, width_ratios=(1.2, 1.0, 1.3))
    labels = list(dict.fromkeys(case.label for case in experiment.cases))
    colour = {label: COLOURS[k % len(COLOURS)] for k, label in enumerate(labels)}
    first = [case for case in experiment.cases if case.agents == experiment.cases[0].agents]
    ticks = int(settings.ticks(None, 1.0))
    drawn_flock = None
    for case in first:
        flock = flock_of(case, seed)
        time, saved = follow_savings(flock, ticks, max(1, ticks // LOOKS))
        over_time.plot(
            time, 100.0 * settings.induced * saved, color=colour[case.label], linewidth=1.7
        )
        drawn_flock = drawn_flock or flock
    over_time.axhline(0.0, color=INK, linewidth=0.8)
    over_time.set_xlabel("time / s")
    over_time.set_ylabel("power saved / %")
    over_time.set_title(f"{first[0].agents} birds, seed {seed}", loc="left")
    draw_runs(runs, verdicts_on(verdicts, "power"), labels, colour)
    draw_from_above(above, drawn_flock)
    above.set_title(f"{first[0].label}, at the end, from above", loc="left")
    from matplotlib.lines import Line2D

    signs = [Line2D([], [], color=colour[label], linewidth=2.5, label=label) for label in labels]
    draw_key(
        figure,
        signs,
        f"{100.0 * settings.induced:g} % of the power taken as induced; colours of birds: share of "
        "induced drag saved",
    )


def draw_runs(axes: Any, points: list[Verdict], labels: list[str], colour: dict[str, str]) -> None:
    """Boxes of all runs, by size of flock and row."""
    sizes = sorted({point.case.agents for point in points})
    width = 0.8 / max(1, len(labels))
    for point in points:
        x = sizes.index(point.case.agents) + width * (
            labels.index(point.case.label) - (len(labels) - 1) / 2
        )
        box(axes, x, point.values, colour[point.case.label], 0.8 * width)
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.set_xticks(range(len(sizes)), [str(n) for n in sizes])
    axes.set_xlabel("birds")
    axes.set_ylabel("power saved / %")
    axes.set_title("all runs", loc="left")


def draw_from_above(axes: Any, flock: Any) -> None:
    """The largest group from above, its mean heading up the page, coloured by what birds save."""
    from matplotlib.collections import LineCollection

    up = flock.active
    x, y = level(flock, up)
    share = flock.signal("saved")[up]
    half = 0.5 * flock.parameters.b
    wings = LineCollection(
        [
            [(a - half, b - 0.25 * half), (a, b), (a + half, b - 0.25 * half)]
            for a, b in zip(x, y, strict=True)
        ],
        cmap=SHADES,
        linewidths=3.0,
        capstyle="round",
        path_effects=outline_effect(),
    )
    wings.set_array(share)
    wings.set_clim(-1.0, 1.0)
    axes.add_collection(wings)
    reach = max(np.ptp(x), np.ptp(y), 10.0 * half) / 2 + 2.0 * half
    axes.set_xlim((x.min() + x.max()) / 2 - reach, (x.min() + x.max()) / 2 + reach)
    axes.set_ylim((y.min() + y.max()) / 2 - reach, (y.min() + y.max()) / 2 + reach)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xlabel("aside / m")
    axes.set_ylabel("ahead / m")
    axes.figure.colorbar(wings, ax=axes, shrink=0.7, label="share of induced drag saved")


def outline_effect() -> list[Any]:
    """A thin dark line round what is drawn, so that pale birds are seen."""
    from matplotlib.patheffects import Normal, Stroke

    return [Stroke(linewidth=4.2, foreground=INK), Normal()]


def level(flock: Any, up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places of the birds aside of and along their mean heading, (M,) each, about their middle."""
    position, heading = flock.position[up], flock.heading[up]
    size, images = np.asarray(flock.world.size), np.asarray(flock.world.images)
    apart = position - position[0]
    apart = apart - np.where(images, size * np.round(apart / size), 0.0)
    way = heading[:, :2].mean(axis=0)
    way = way / max(np.hypot(*way), 1e-12)
    return apart[:, :2] @ np.array([way[1], -way[0]]), apart[:, :2] @ way


PICTURES = {"formation": draw_formation}
