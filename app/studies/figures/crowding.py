"""How fast crowded particles get on over their packing, beside a straight line."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key, runs_with_value
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# Runs in which active particles are in each other's way: how fast they get on along their heading.
#
# In the plane, among edges that wrap. The packing is the share of the area that the discs would
# cover if they did not overlap.


class CrowdingSettings(Settings):
    """How long particles mix, and how often they are looked at."""

    kind: ClassVar[str] = "crowding"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("packing", "packing", "Share of the area that the discs cover", "1"),
        Measure("speed", "v/v0", "Velocity along the heading, of that of a free one", "1"),
        Measure("slope", "slope", "What of it is lost, over the packing", "1"),
    )

    lasts: int = Field(ge=0)
    """Ticks before they are looked at."""
    looks: int = Field(ge=1)
    """How often they are looked at, each time for a tick."""
    every: int = Field(ge=1)
    """Ticks between two looks."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let them mix, then look at them."""
        p: Any = flock.parameters
        between()
        flock.run(self.lasts)
        samples = []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            samples.append(velocity_along_heading(flock))
        area = float(np.prod(flock.world.size))
        packing = len(flock.ids) * math.pi * p.d**2 / (4.0 * area)
        speed = float(np.mean(samples)) / p.v0
        return {"packing": packing, "speed": speed, "slope": (1.0 - speed) / packing}

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.lasts + self.looks * (self.every + 1)


def velocity_along_heading(flock: Flock) -> float:
    """The mean velocity along the heading in the next tick, length/s."""
    before, heading = flock.position.copy(), flock.heading.copy()
    flock.run(1)
    step = flock.position - before
    size = np.array(flock.world.size)
    step = step - np.where(flock.world.images, size * np.round(step / size), 0.0)
    return float((step * heading).sum(axis=1).mean()) / flock.dt


DOTS, LINE = "#2166ac", "#c0392b"


def draw_crowding(figure: Any, verdicts: list[Verdict]) -> None:
    """A dot for each run, and the line of best fit that is 1 where there is room."""
    figure.set_size_inches(7.4, 5.0)
    axes = figure.subplots()
    x = np.concatenate(
        [runs_with_value(verdict.values) for verdict in verdicts_on(verdicts, "packing")]
    )
    y = np.concatenate(
        [runs_with_value(verdict.values) for verdict in verdicts_on(verdicts, "speed")]
    )
    slope = float((x * (1.0 - y)).sum() / (x * x).sum())
    line = np.array([0.0, 1.15 * float(x.max())])
    axes.plot(
        line, 1.0 - slope * line, color=LINE, linewidth=1.4, label=f"1 - packing / {1 / slope:.2f}"
    )
    axes.plot(x, y, "o", color=DOTS, markersize=4.5, alpha=0.6, label="runs")
    axes.set_xlim(0.0, line[1])
    axes.set_ylim(0.0, 1.05)
    axes.set_xlabel("packing")
    axes.set_ylabel("velocity along the heading, $v / v_0$")
    axes.legend()
    draw_key(figure, [], "line: least squares through 1 at no packing")


PICTURES = {"crowding": draw_crowding}
