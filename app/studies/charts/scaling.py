"""Finite-size scaling: an observable, Binder's cumulant and the collapse, a line for each size.

Near a continuous transition at x_c, y(x, L) = L^(-beta / nu) f((x - x_c) L^(1 / nu)): lines of all
sizes L fall on one, and those of Binder's cumulant cross at x_c (Binder 1981; for the Vicsek model
Baglietto and Albano 2008).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from app.studies.charts.axis_limits import column_bounds
from app.studies.charts.colour_table import COLOURS, RULER
from app.studies.charts.mean_line import (
    draw_mean_bars,
    draw_mean_line,
    fit_axes,
)
from app.studies.charts.run_group import CellRuns, is_number, varied_axes
from app.studies.judge.statistics import MeasureSummary
from app.studies.measure import UNBOUNDED, MeasureBounds
from app.studies.runs.store_reader import StoreReader
from worlds.input_error import InputError

SIZE, CUMULANT = "agents", "binder"


@dataclass(frozen=True)
class Scaling:
    """The exponents of a collapse, and where it is; None: where the cumulants cross."""

    beta: float
    nu: float
    critical: float | None = None

    def __post_init__(self) -> None:
        for name, value in (("beta", self.beta), ("nu", self.nu)):
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"{name} = {value:g} is not above 0")
        if self.critical is not None and not math.isfinite(self.critical):
            raise InputError(f"critical = {self.critical:g} is no finite number")


Lines = dict[int, tuple[float, list[CellRuns]]]
"""Number of agents -> longest side of the world, and the cells along the axis."""


def draw_scaling(
    panels: Sequence[Any],
    name: str,
    lines: Lines,
    cumulants: Lines,
    x: str,
    by: Scaling | None,
    along: MeasureBounds = UNBOUNDED,
) -> None:
    """Draw the lines, the cumulants if there are any, and with `by` the collapse, a panel each.

    Raises InputError.
    """
    draw_sizes(panels[0], lines, x, along, column_bounds(name))
    panels[0].set_ylabel(f"{plain_text(name)}, mean and 95 % interval")
    crossing = None
    if cumulants:
        crossing = crossing_of(cumulants, x)
        draw_sizes(panels[1], cumulants, x, along, column_bounds(CUMULANT))
        panels[1].set_ylabel("Binder's cumulant U")
        if crossing is not None:
            panels[1].axvline(
                crossing, color=RULER, linestyle=":", label=f"crossing at {crossing:.4g}"
            )
    if by is not None:
        critical = crossing if by.critical is None else by.critical
        if critical is None:
            raise InputError(
                "it is not known where the transition is: give --critical, or measure 'binder' "
                "over a range in which the lines of the two largest sizes cross once"
            )
        draw_collapse(panels[-1], lines, x, by, critical)
        panels[-1].set_ylabel(rf"{plain_text(name)} $L^{{\beta / \nu}}$")
    for panel in panels:
        panel.legend(fontsize=8)


def group_by_size(reader: StoreReader, groups: list[CellRuns], x: str) -> Lines:
    """The cells by the number of agents. Raises InputError if something else varies too."""
    axes = varied_axes(groups)
    if SIZE not in axes or x == SIZE:
        raise InputError(
            f"scaling needs the axis {SIZE!r} with two sizes or more, and another axis"
        )
    rest = [axis for axis in axes if axis not in (x, SIZE)]
    if rest:
        raise InputError(
            f"{', '.join(rest)} varies too: say at which value, such as --where '{rest[0]} == ...'"
        )
    cells = reader.cells
    lines: Lines = {}
    for group in groups:
        if group.values and is_number(group.axes.get(x)):
            side = max(cells[group.number]["identity"]["spec"]["size"])
            lines.setdefault(int(group.axes[SIZE]), (float(side), []))[1].append(group)
    for _, line in lines.values():
        line.sort(key=lambda group: float(group.axes[x]))
    if len(lines) > len(COLOURS):
        raise InputError(f"{len(lines)} sizes cannot be told apart: leave some out with --where")
    return dict(sorted(lines.items()))


def draw_sizes(panel: Any, lines: Lines, x: str, along: MeasureBounds, up: MeasureBounds) -> None:
    """Draw means along the axis, with bands, a line for each size."""
    for (agents, (_, line)), colour in zip(lines.items(), COLOURS, strict=False):
        draw_mean_line(panel, places_of(line, x), summaries_of(line), colour, f"N = {agents}")
    groups = [group for _, line in lines.values() for group in line]
    fit_axes(panel, places_of(groups, x), groups, along, up)
    panel.set_xlabel(plain_text(x))


def draw_collapse(panel: Any, lines: Lines, x: str, by: Scaling, critical: float) -> None:
    """Draw the lines in scaled units, in which they fall on one where the exponents are right."""
    for (agents, (side, line)), colour in zip(lines.items(), COLOURS, strict=False):
        along = (np.array(places_of(line, x)) - critical) * side ** (1.0 / by.nu)
        up = side ** (by.beta / by.nu)
        rescaled = [
            replace(
                summary,
                mean=up * summary.mean,
                interval=(up * summary.interval[0], up * summary.interval[1]),
            )
            for summary in summaries_of(line)
        ]
        draw_mean_bars(panel, along.tolist(), rescaled, colour, f"N = {agents}", markersize=4)
    panel.set_xlabel(rf"({plain_text(x)} - {critical:.4g}) $L^{{1 / \nu}}$")
    panel.set_title(rf"$\beta$ = {by.beta:g}, $\nu$ = {by.nu:g}", fontsize=9)


def places_of(line: Sequence[CellRuns], x: str) -> list[float]:
    """Where the cells of a line are."""
    return [float(group.axes[x]) for group in line]


def summaries_of(line: Sequence[CellRuns]) -> list[MeasureSummary]:
    """Of the cells of a line."""
    return [group.summary for group in line]


def plain_text(words: str) -> str:
    """Words of which nothing is taken for mathematics."""
    return words.replace("$", r"\$")


def crossing_of(cumulants: Lines, x: str) -> float | None:
    """Where the lines of the two largest sizes cross; None unless they do so exactly once."""
    (_, smaller), (_, larger) = list(cumulants.values())[-2:]
    first, second = places_of(smaller, x), places_of(larger, x)
    u, w = (
        np.array([summary.mean for summary in summaries_of(line)]) for line in (smaller, larger)
    )
    places = np.intersect1d(first, second)
    gap = w[np.isin(second, places)] - u[np.isin(first, places)]
    turns = np.flatnonzero(gap[:-1] * gap[1:] < 0.0)
    if len(turns) != 1:
        return None
    k = int(turns[0])
    return float(places[k] + (places[k + 1] - places[k]) * gap[k] / (gap[k] - gap[k + 1]))
