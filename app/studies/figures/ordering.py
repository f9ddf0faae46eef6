"""Order over noise, a line for each model and size, and what else was measured beside it.

Rows beside the sweeps are drawn over their density; where all have one density, as boxes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from agents.observables.neighbours import nearest_neighbour
from app.studies.charts.boxes import WORDS, box, draw_key
from app.studies.charts.colour_table import COLOURS, MARKERS, RULER
from app.studies.charts.mean_line import INTERVAL_WORDS, draw_mean_bars
from app.studies.judge.verdict import Verdict, group_by_sweep, verdicts_on
from app.studies.measure import SHARE, Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# Runs in which a flock is left alone until its order is steady: Vicsek et al. 1995, figure 2.


class OrderingSettings(Settings):
    """How long a flock is left alone, and how often it is looked at then."""

    kind: ClassVar[str] = "ordering"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("order", "order", "Polarisation, mean over time", "1", bounds=SHARE),
        Measure("binder", "G", "Binder cumulant of the polarisation over time", "1"),
        Measure("chi", "chi", "N times the variance of the polarisation over time", "1"),
        Measure("d_pair", "d_pair", "Least distance of two agents", "length", "one agent"),
    )

    settle: int = Field(ge=0)
    """Ticks before a flock is looked at, from its start."""
    looks: int = Field(ge=2)
    """How often it is looked at; the measures are over the looks."""
    every: int = Field(ge=1)
    """Ticks between two looks."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let the flock settle, then look at it."""
        between()
        flock.run(self.settle)
        orders, least = np.empty(self.looks), math.inf
        for k in range(self.looks):
            between()
            flock.run(self.every)
            orders[k] = flock.observe("polarisation")
            near = nearest_neighbour(flock.position, flock.world.size, flock.world.images)
            least = min(least, near.min(initial=math.inf))
        return {
            "order": float(orders.mean()),
            "binder": binder(orders),
            "chi": len(flock.ids) * float(orders.var()),
            "d_pair": least if math.isfinite(least) else None,
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.settle + self.looks * self.every


def binder(order: np.ndarray) -> float:
    """Binder's cumulant 1 - <phi^4> / (3 <phi^2>^2) of orders (T,), Grégoire and Chaté 2004.

    2/3 for an order that does not change, 1/3 for the length of a mean of many independent vectors
    of the plane, and below both, even below 0, where the flock is now ordered and now not.

    >>> round(binder(np.full(5, 0.8)), 3)
    0.667
    """
    second = float((order**2).mean())
    return 1.0 - float((order**4).mean()) / (3.0 * second * second) if second > 0.0 else 0.0


WIDTH = 0.4
SYMBOLS = {"eta": "$\\eta$", "order": "order", "binder": "Binder cumulant $G$"}


def draw_ordering(figure: Any, verdicts: list[Verdict]) -> None:
    """A panel for each measure and model of the sweeps, and one for the rows."""
    measures = list(dict.fromkeys(verdict.measure.name for verdict in verdicts))
    swept = [
        (sweep.model, name)
        for name in measures
        for sweep, _, _ in group_by_sweep(verdicts_on(verdicts, name))
    ]
    curves = list(dict.fromkeys(swept))
    rows = [
        verdict
        for verdict in verdicts_on(verdicts, measures[0])
        if verdict.case.row and verdict.case.spec.size
    ]
    number = len(curves) + bool(rows)
    lines = 1 if number < 4 else 2
    figure.set_size_inches(5.4 * (number / lines), 4.4 * lines + 0.4)
    panels = list(figure.subplots(lines, -(-number // lines), squeeze=False).ravel())
    for axes, (model, name) in zip(panels, curves, strict=False):
        draw_sweeps(
            axes,
            [
                verdict
                for verdict in verdicts_on(verdicts, name)
                if verdict.case.spec.model == model
            ],
        )
        axes.set_ylabel(SYMBOLS.get(name, name))
        if len({curve for curve, _ in curves}) > 1:
            axes.set_title(model, loc="left")
    if curves:
        draw_key(figure, panels[0].get_legend_handles_labels()[0], INTERVAL_WORDS)
    if rows and len({round(density(row), 6) for row in rows}) > 1:
        draw_densities(panels[-1], rows)
    elif rows:
        draw_boxes(panels[-1], rows)
        draw_key(figure, [], WORDS)


def draw_sweeps(axes: Any, verdicts: list[Verdict]) -> None:
    """A line for each size of flock."""
    for k, (sweep, agents, points) in enumerate(group_by_sweep(verdicts)):
        draw_line(axes, k, [float(p.case.value or 0.0) for p in points], points, f"N = {agents}")
        axes.set_xlabel(SYMBOLS.get(sweep.parameter, sweep.parameter))
    if min(verdict.summary.mean for verdict in verdicts) < 0.0:
        axes.axhline(0.0, color=RULER, linewidth=1.0)


def draw_densities(axes: Any, rows: list[Verdict]) -> None:
    """The rows over their density, a line for each model."""
    models = list(dict.fromkeys(row.case.spec.model for row in rows))
    for k, model in enumerate(models):
        points = sorted((row for row in rows if row.case.spec.model == model), key=density)
        draw_line(axes, k, [density(row) for row in points], points, model)
    if len(models) > 1:
        axes.legend()
        axes.set_xscale("log")
    axes.set_xlabel("density")
    axes.set_ylabel("order")


def draw_boxes(axes: Any, rows: list[Verdict]) -> None:
    """The runs of each row."""
    for x, row in enumerate(rows):
        box(axes, x, row.values, COLOURS[x % len(COLOURS)], WIDTH)
    axes.set_xticks(range(len(rows)), [row.case.label for row in rows])
    axes.set_ylabel("order")


def density(row: Verdict) -> float:
    """Agents per unit of area or volume."""
    spec = row.case.spec
    sides = spec.size if isinstance(spec.size, tuple) else (spec.size or 1.0,) * (spec.dim or 2)
    volume = 1.0
    for side in sides:
        volume *= side
    return spec.count / volume


def draw_line(axes: Any, k: int, x: list[float], points: list[Verdict], label: str) -> None:
    """Draw means with their intervals."""
    draw_mean_bars(
        axes,
        x,
        [p.summary for p in points],
        COLOURS[k % len(COLOURS)],
        label,
        marker=MARKERS[k % len(MARKERS)],
        linewidth=1.3,
    )


PICTURES = {"ordering": draw_ordering}
