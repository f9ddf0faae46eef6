"""People who walk both ways along a corridor: a run at its start and at its end, and all runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from agents.observables.lanes import lane_order
from app.studies.charts.boxes import draw_key
from app.studies.charts.colour_table import COLOURS
from app.studies.charts.mean_line import INTERVAL_WORDS, draw_mean_bars
from app.studies.experiment import Experiment, flock_of
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# Runs in which people walk both ways along a corridor: Helbing and Molnar 1995, figure 2.

WAY = "way_x"
"""The signal that tells where an agent wants to go along the corridor, +1 or -1."""
DEALS = 40
"""How often the ways are dealt out anew to tell what a mixed crowd would have."""


class LaneSettings(Settings):
    """How long people walk before they are looked at, how often, and how wide a strip is."""

    kind: ClassVar[str] = "lanes"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("order", "order", "Lane order", "1"),
        Measure("mixed", "mixed", "Lane order of the same places, the ways dealt by chance", "1"),
        Measure("gain", "gain", "Lane order above that of ways dealt by chance", "1"),
        Measure("start", "start", "Lane order at the start", "1"),
        Measure("progress", "progress", "Mean speed along the own way, of the mean desired", "%"),
    )

    settle: int = Field(ge=1)
    """Ticks before people are looked at."""
    looks: int = Field(ge=1)
    """How often they are looked at; the measures are means over the looks."""
    every: int = Field(ge=1)
    """Ticks between two looks."""
    width: float = Field(gt=0.0)
    """Of the strips in which ways are counted, m."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let people walk, then look at them."""
        between()
        initial_order = self.order(flock, walking_directions(flock))
        flock.run(self.settle)
        samples = []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            ways = walking_directions(flock)
            dealt = [self.order(flock, flock.rng.permutation(ways)) for _ in range(DEALS)]
            progress = flock.speed * (flock.heading[:, 0] * ways)
            samples.append((self.order(flock, ways), np.mean(dealt), progress.mean()))
        order, mixed, progress = (float(mean) for mean in np.mean(samples, axis=0))
        return {
            "order": order,
            "mixed": mixed,
            "gain": order - mixed,
            "start": initial_order,
            "progress": 100.0 * progress / flock.parameters.v0,  # type: ignore[attr-defined]
        }

    def order(self, flock: Flock, ways: np.ndarray) -> float:
        """The lane order of people who want to go these ways (N,), +1 or -1."""
        aims = np.column_stack([ways, np.zeros(len(ways))])
        size = np.array(flock.world.size)
        return lane_order(flock.position, aims, size, flock.world.images, self.width)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.settle + self.looks * self.every


def walking_directions(flock: Flock) -> np.ndarray:
    """Where each of the flock wants to go along the corridor, +1 or -1, (N,)."""
    return flock.signal(WAY)


EAST, WEST = "#2166ac", "#c0392b"
LINE_COLOURS = COLOURS[2:]
"""Those of people, red and blue, are no lines."""
DART = np.array([[0.6, 0.0], [-0.4, 0.32], [-0.2, 0.0], [-0.4, -0.32]])
"""Outline of a walker of length 1 that goes along +x."""


def draw_lanes(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """Draw the run of that seed of the first row twice above, the lane order of all rows below."""
    settings = experiment.settings
    assert isinstance(settings, LaneSettings)
    figure.set_size_inches(11.0, 9.2)
    above, below = figure.subfigures(2, 1, height_ratios=[1.25, 1.0])
    case = experiment.cases[0]
    flock = flock_of(case, seed)
    first, last = above.subplots(2, 1)
    draw_people(first, flock, f"{case.label}, N = {case.agents}, at the start")
    flock.run(settings.settle + settings.looks * settings.every)
    draw_people(last, flock, f"after {flock.elapsed:g} s")
    axes, speed = below.subplots(1, 2, width_ratios=[1.6, 1.0])
    draw_rows(axes, verdicts, "order")
    draw_rows(speed, verdicts, "progress")
    axes.set_ylim(0.0, 1.03)
    axes.set_ylabel("lane order")
    speed.set_ylabel("speed along the own way / % of desired")
    dots = verdicts_on(verdicts, "mixed")
    sizes = sorted({dot.case.agents for dot in dots})
    means = [np.mean([dot.summary.mean for dot in dots if dot.case.agents == n]) for n in sizes]
    axes.plot(sizes, means, ":", color="#3c434b", linewidth=1.3, label="ways dealt by chance")
    draw_key(
        figure,
        axes.get_legend_handles_labels()[0],
        f"above: seed {seed}, those who want to go to the right blue; below: mean of all runs, "
        f"{INTERVAL_WORDS}",
    )


def draw_people(axes: Any, flock: Any, title: str) -> None:
    """Draw everybody by where they want to go, heading where they are going."""
    from matplotlib.collections import PolyCollection

    ux, uy = flock.heading.T
    turn = np.array([[ux, -uy], [uy, ux]]).transpose(2, 0, 1)
    darts = flock.position[:, None] + 0.9 * np.einsum("nij,kj->nki", turn, DART)
    colours = np.where(walking_directions(flock) > 0.0, EAST, WEST)
    axes.add_collection(PolyCollection(darts, facecolors=colours, edgecolors="none"))
    width, height = flock.world.size
    axes.set(xlim=(0.0, width), ylim=(0.0, height), aspect="equal", xticks=[], yticks=[])
    for side in ("top", "bottom"):
        axes.spines[side].set(visible=True, linewidth=2.0, color="#3c434b")
    for side in ("left", "right"):
        axes.spines[side].set_visible(False)
    axes.grid(visible=False)
    axes.set_title(title, loc="left")


def draw_rows(axes: Any, verdicts: list[Verdict], measure: str) -> None:
    """Draw a measure over the number of people, a line for each label."""
    rows = verdicts_on(verdicts, measure)
    for k, label in enumerate(dict.fromkeys(row.case.label for row in rows)):
        line = [row for row in rows if row.case.label == label]
        line.sort(key=lambda verdict: verdict.case.agents)
        draw_mean_bars(
            axes,
            [verdict.case.agents for verdict in line],
            [verdict.summary for verdict in line],
            LINE_COLOURS[k % len(LINE_COLOURS)],
            label,
        )
    axes.set_xlabel("people")


PICTURES = {"lanes": draw_lanes}
