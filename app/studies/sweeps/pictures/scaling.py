"""Finite-size scaling: an observable, Binder's cumulant and the collapse, a line for each size.

Near a continuous transition at x_c, y(x, L) = L^(-beta / nu) f((x - x_c) L^(1 / nu)): lines of all
sizes L fall on one, and those of Binder's cumulant cross at x_c (Binder 1981; for the Vicsek model
Baglietto and Albano 2008).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.pictures.cell_runs import CellRuns, groups_of, is_number, varied
from app.studies.sweeps.pictures.mean_lines import COLOURS, mark
from app.studies.sweeps.sweep_table import measured
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
    figure: Any,
    kept: StoreReader,
    name: str,
    groups: list[CellRuns],
    x: str,
    where: str,
    by: Scaling | None,
) -> None:
    """Draw the panels that the sweep has: `by` for the collapse. Raises InputError."""
    lines = by_size(kept, groups, x)
    has_cumulant = CUMULANT in measured(kept) and name != CUMULANT
    cumulants = by_size(kept, groups_of(kept, CUMULANT, where)[1], x) if has_cumulant else {}
    across = 1 + has_cumulant + (by is not None)
    figure.set_size_inches(1.6 + 4.0 * across, 4.4)
    panels = list(figure.subplots(1, across, squeeze=False)[0])
    plain(panels[0], lines, x)
    panels[0].set_ylabel(f"{name}, mean and 95 % interval")
    mark(panels[0], groups, x)
    crossing = None
    if cumulants:
        crossing = crossing_of(cumulants, x)
        plain(panels[1], cumulants, x)
        panels[1].set_ylabel("Binder's cumulant U")
        if crossing is not None:
            panels[1].axvline(
                crossing, color="#555555", linestyle=":", label=f"crossing at {crossing:.4g}"
            )
    if by is not None:
        critical = crossing if by.critical is None else by.critical
        if critical is None:
            raise InputError(
                "it is not known where the transition is: give --critical, or measure 'binder' "
                "over a range in which the lines of the two largest sizes cross once"
            )
        collapse(panels[-1], lines, x, by, critical)
        panels[-1].set_ylabel(rf"{name} $L^{{\beta / \nu}}$")
    for panel in panels:
        panel.legend(fontsize=8)


def by_size(kept: StoreReader, groups: list[CellRuns], x: str) -> Lines:
    """The cells by the number of agents. Raises InputError if something else varies too."""
    axes = varied(groups)
    if SIZE not in axes or x == SIZE:
        raise InputError(
            f"scaling needs the axis {SIZE!r} with two sizes or more, and another axis"
        )
    rest = [axis for axis in axes if axis not in (x, SIZE)]
    if rest:
        raise InputError(
            f"{', '.join(rest)} varies too: say at which value, such as --where '{rest[0]} == ...'"
        )
    cells = kept.cells
    found: Lines = {}
    for group in groups:
        if group.values and is_number(group.axes.get(x)):
            side = max(cells[group.number]["identity"]["spec"]["size"])
            found.setdefault(int(group.axes[SIZE]), (float(side), []))[1].append(group)
    for _, line in found.values():
        line.sort(key=lambda group: float(group.axes[x]))
    if len(found) > len(COLOURS):
        raise InputError(f"{len(found)} sizes cannot be told apart: leave some out with --where")
    return dict(sorted(found.items()))


def plain(panel: Any, lines: Lines, x: str) -> None:
    """Means along the axis, with bands."""
    for (agents, (_, line)), colour in zip(lines.items(), COLOURS, strict=False):
        places, means, half = of(line, x)
        panel.plot(places, means, color=colour, marker="o", markersize=4, label=f"N = {agents}")
        panel.fill_between(
            places, means - half, means + half, color=colour, alpha=0.18, linewidth=0
        )
    panel.set_xlabel(x)


def collapse(panel: Any, lines: Lines, x: str, by: Scaling, critical: float) -> None:
    """The lines in scaled units, in which they fall on one where the exponents are right."""
    for (agents, (side, line)), colour in zip(lines.items(), COLOURS, strict=False):
        places, means, half = of(line, x)
        along, up = (places - critical) * side ** (1.0 / by.nu), side ** (by.beta / by.nu)
        style = {"color": colour, "marker": "o", "markersize": 4, "capsize": 2}
        panel.errorbar(along, up * means, up * half, label=f"N = {agents}", **style)
    panel.set_xlabel(rf"({x} - {critical:.4g}) $L^{{1 / \nu}}$")
    panel.set_title(rf"$\beta$ = {by.beta:g}, $\nu$ = {by.nu:g}", fontsize=9)


def of(line: list[CellRuns], x: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places, means and half intervals of the cells of a line."""
    return (
        np.array([float(group.axes[x]) for group in line]),
        np.array([group.mean for group in line]),
        np.array([group.half for group in line]),
    )


def crossing_of(cumulants: Lines, x: str) -> float | None:
    """Where the lines of the two largest sizes cross; None unless they do so exactly once."""
    (_, smaller), (_, larger) = list(cumulants.values())[-2:]
    (first, u, _), (second, w, _) = of(smaller, x), of(larger, x)
    places = np.intersect1d(first, second)
    gap = w[np.isin(second, places)] - u[np.isin(first, places)]
    turns = np.flatnonzero(gap[:-1] * gap[1:] < 0.0)
    if len(turns) != 1:
        return None
    k = int(turns[0])
    return float(places[k] + (places[k + 1] - places[k]) * gap[k] / (gap[k] - gap[k + 1]))
