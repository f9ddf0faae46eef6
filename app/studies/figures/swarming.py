"""How measures go with the number of agents, on logarithmic scales: a line for each label."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from agents.observables.neighbours import nearest_neighbour
from app.studies.charts.boxes import draw_key, runs_with_value
from app.studies.experiment import Experiment, flock_of
from app.studies.figures.phases import map_points
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import SHARE, Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# Runs in which driven particles that attract and repel each other take a shape, or come apart.

SHAPES = ("disperses", "flock", "ring", "mill", "double mill", "disordered")
"""What a swarm becomes."""


class SwarmingSettings(Settings):
    """How long a swarm is left alone and followed, and from what on it has which shape.

    In the plane. The measures are means over the looks.
    """

    kind: ClassVar[str] = "swarming"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("p", "p", "Polarisation", "1", bounds=SHARE),
        Measure("m", "m", "Angular momentum: how far all mill one way round", "1"),
        Measure(
            "either",
            "|m|",
            "The same, either way round: 0.64 where nobody mills",
            "1",
            bounds=SHARE,
        ),
        Measure("radius", "R", "Gyration radius", "length"),
        Measure("spacing", "d", "Distance to the nearest other, median", "length"),
        Measure("hole", "hole", "Distance of the innermost from the centre, of R", "1"),
        Measure("side", "side", "1 where it stays together if and only if C l^2 < 1", "1"),
        Measure("phase", "phase", "Shape by these measures", "1", whole=True, words=SHAPES),
    )

    lasts: int = Field(ge=0)
    """Ticks before it is looked at."""
    looks: int = Field(ge=1)
    """How often it is looked at."""
    every: int = Field(ge=1)
    """Ticks between two looks."""
    wide: float = Field(gt=0.0)
    """R from which on it has come apart, length."""
    polarised: float = Field(0.5, gt=0.0, lt=1.0)
    """p from which on it is a flock."""
    mills: float = Field(0.8, gt=0.65, lt=1.0)
    """|m| from which on it mills; one way round if m is as much."""
    hollow: float = Field(0.8, gt=0.0, lt=1.0)
    """Distance of the innermost from which on what mills is a ring, of R."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Leave the swarm alone, then look at it."""
        between()
        flock.run(self.lasts)
        samples = []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            samples.append(shape_of(flock))
        p, m, either, radius, spacing, hole = (float(mean) for mean in np.mean(samples, axis=0))
        together = radius < self.wide
        return {
            "p": p,
            "m": m,
            "either": either,
            "radius": radius,
            "spacing": spacing,
            "hole": hole,
            "side": float(together == (room(flock) < 1.0)),
            "phase": SHAPES.index(self.phase_of(p, m, either, radius, hole)),
        }

    def phase_of(self, p: float, m: float, either: float, radius: float, hole: float) -> str:
        """The shape of a swarm with these measures, one of `SHAPES`.

        >>> settings = SwarmingSettings(world="open", lasts=0, looks=1, every=1, wide=10.0)
        >>> settings.phase_of(0.05, 0.1, 0.98, 1.5, 0.93), settings.phase_of(0, 0.9, 0.9, 1.5, 0.1)
        ('ring', 'mill')
        """
        if radius >= self.wide:
            return "disperses"
        if p >= self.polarised:
            return "flock"
        if either < self.mills:
            return "disordered"
        if hole >= self.hollow:
            return "ring"
        return "mill" if m >= self.mills else "double mill"

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.lasts + self.looks * self.every


def room(flock: Flock) -> float:
    """C l^2: above 1 the Morse potential is H-stable in the plane, below it is catastrophic."""
    p = flock.parameters
    strength = p.C_r / p.C_a  # type: ignore[attr-defined]
    return float(strength * (p.l_r / p.l_a) ** 2)  # type: ignore[attr-defined]


def shape_of(flock: Flock) -> tuple[float, ...]:
    """Polarisation, angular momentum, the same either way round, radius, spacing and hole."""
    out = flock.position - flock.position.mean(axis=0)
    far = np.linalg.norm(out, axis=1)
    turning = (out[:, 0] * flock.heading[:, 1] - out[:, 1] * flock.heading[:, 0]) / far
    radius = flock.observe("gyration-radius")
    near = nearest_neighbour(flock.position, flock.world.size, flock.world.images)
    return (
        flock.observe("polarisation"),
        flock.observe("angular-momentum"),
        float(np.abs(turning).mean()),
        radius,
        float(np.median(near)),
        float(far.min()) / radius,
    )


# What swarms look like over the two parameters of a sweep, at the end of the run of a seed.

STABLE, CATASTROPHIC = "#eef3fb", "#fbf1ec"
LEAST, AROUND = 0.3, 2.4
"""What is shown at least, length, and how many radii around the centre."""
LENGTH = 0.16
"""Of an arrow, as a share of what is shown."""


def draw_gallery(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """A panel for each place of the map, the first parameter to the right, the second upwards."""
    from matplotlib.colors import hsv_to_rgb

    settings = experiment.settings
    assert isinstance(settings, SwarmingSettings)
    points = map_points(verdicts)
    xs, ys = sorted({spot.x for spot in points}), sorted({spot.y for spot in points})
    figure.set_size_inches(2.5 * len(xs) + 0.6, 2.75 * len(ys) + 0.8)
    grid = figure.subplots(len(ys), len(xs), squeeze=False)
    for spot in points:
        axes = grid[len(ys) - 1 - ys.index(spot.y), xs.index(spot.x)]
        flock = flock_of(spot.case, seed)
        flock.run(settings.lasts)
        where = flock.position - flock.position.mean(axis=0)
        half = max(LEAST, AROUND * float(np.sqrt((where**2).sum(axis=1).mean())))
        hue = np.arctan2(flock.heading[:, 1], flock.heading[:, 0]) / (2.0 * np.pi) % 1.0
        colours = hsv_to_rgb(
            np.column_stack([hue, np.full_like(hue, 0.8), np.full_like(hue, 0.75)])
        )
        axes.quiver(
            *where.T, *(LENGTH * half * flock.heading).T, color=colours, angles="xy",
            scale_units="xy", scale=1.0, width=0.011, headwidth=4.0, headlength=4.5,
            headaxislength=4.0, pivot="mid",
        )  # fmt: skip
        stable = room(flock) > 1.0
        axes.set_facecolor(STABLE if stable else CATASTROPHIC)
        axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal", xticks=[], yticks=[])
        axes.grid(visible=False)
        for spine in axes.spines.values():
            spine.set_visible(False)
        name = f"{spot.phase} ({spot.share:.0%})"
        axes.set_title(f"{name}\n$C l^2$ = {room(flock):.2g}, {2.0 * half:.2g} m", fontsize=9)
        if spot.x == xs[0]:
            axes.set_ylabel(f"$C$ = {spot.y:g}")
        if spot.y == ys[0]:
            axes.set_xlabel(f"$l$ = {spot.x:g}")
    draw_key(
        figure,
        [],
        "blue: H-stable (C l^2 > 1), red: catastrophic; above each the shape of most runs with "
        f"their share, and the side of what is shown of the run of seed {seed}",
    )


COLOURS = ("#2166ac", "#c0392b", "#1b7837", "#e08214")


def draw_growth(figure: Any, verdicts: list[Verdict]) -> None:
    """A panel for each measure, with the slope of each line."""
    names = list(
        dict.fromkeys(verdict.measure.name for verdict in verdicts if not verdict.measure.words)
    )
    labels = list(dict.fromkeys(verdict.case.label for verdict in verdicts))
    figure.set_size_inches(4.6 * len(names) + 0.4, 4.4)
    for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
        for label, colour in zip(labels, COLOURS * len(labels), strict=False):
            rows = [
                verdict for verdict in verdicts_on(verdicts, name) if verdict.case.label == label
            ]
            n = np.array([row.case.agents for row in rows])
            mean = np.array([row.summary.mean for row in rows])
            slope = np.polyfit(np.log(n), np.log(mean), 1)[0]
            words = f"{label}: $N^{{{slope:.2f}}}$"
            axes.plot(n, mean, "o-", color=colour, linewidth=1.8, markersize=5, label=words)
            for row in rows:
                present = runs_with_value(row.values)
                axes.plot(
                    np.full(present.size, row.case.agents), present, ".", color=colour, alpha=0.3
                )
        first = verdicts_on(verdicts, name)[0]
        unit = "" if first.unit == "1" else f" / {first.unit}"
        axes.set_xscale("log")
        axes.set_yscale("log")
        sizes = sorted({verdict.case.agents for verdict in verdicts})
        axes.set_xticks(sizes, [str(n) for n in sizes])
        axes.minorticks_off()
        axes.set_xlabel("N")
        axes.set_ylabel(f"{first.measure.symbol}{unit}")
        axes.set_title(first.measure.title, loc="left")
        axes.legend()
    draw_key(figure, [], "circles: means, dots: runs; the power is that of the line of best fit")


PICTURES = {"growth": draw_growth, "gallery": draw_gallery}
