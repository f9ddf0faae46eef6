"""A map over two axes: the mean of each cell as a colour; cells without a value are marked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from app.strict_table import Value
from app.studies.charts.axis_limits import round_limits
from app.studies.charts.colour_table import CENSORED, EMPTY, FAILED
from app.studies.charts.run_group import CellRuns, is_number
from app.studies.measure import UNBOUNDED, MeasureBounds

COLOUR_MAP = "viridis"
"""Rises evenly in lightness, also for who cannot tell colours apart and in both themes."""
LABELS = 10
"""Along an axis, at most."""


class MapCell(NamedTuple):
    """Where runs stand on a map."""

    column: int
    row: int
    group: CellRuns


def place_cells(
    groups: Iterable[CellRuns], across: Sequence[Any], up: Sequence[Any], x: str, y: str
) -> list[MapCell]:
    """The cells that have both axes of a map, at their values on these."""
    return [
        MapCell(across.index(group.axes[x]), up.index(group.axes[y]), group)
        for group in groups
        if x in group.axes and y in group.axes
    ]


def draw_map(
    axes: Any,
    cells: Sequence[MapCell],
    across: Sequence[Any],
    up: Sequence[Any],
    bounds: MeasureBounds = UNBOUNDED,
    labels: int = LABELS,
) -> Any:
    """Draw the map; every cell is as wide as another, whatever its values. Returns the colours.

    The colours span what the means span, within `bounds`: unlike a length along an axis a colour
    shows no ratio, and small differences would not be seen on the whole range.
    """
    means = np.full((len(up), len(across)), np.nan)
    for cell in cells:
        means[cell.row, cell.column] = cell.group.mean
    low, high = round_limits(means[np.isfinite(means)].tolist())
    mesh = axes.pcolormesh(
        np.ma.masked_invalid(means), cmap=COLOUR_MAP, vmin=max(low, bounds.low),
        vmax=min(high, bounds.high), edgecolors="face", linewidth=0.4, gid="fs-cell",
    )  # fmt: skip
    axes.set_facecolor(EMPTY)
    axes.grid(False)
    mark_cells(axes, cells)
    name_ticks(axes.set_xticks, across, labels)
    name_ticks(axes.set_yticks, up, labels)
    return mesh


def mark_cells(axes: Any, cells: Sequence[MapCell]) -> None:
    """Mark cells with runs that gave up or failed, for a legend to name."""
    for name, sign, colour, words in (
        ("gave_up", "v", CENSORED, "some runs gave up"),
        ("broken", "x", FAILED, "some failed"),
    ):
        marked = [cell for cell in cells if getattr(cell.group, name)]
        if marked:
            axes.plot(
                [cell.column + 0.5 for cell in marked], [cell.row + 0.5 for cell in marked], sign,
                color=colour, markeredgecolor="white" if sign == "v" else colour, markersize=7,
                label=words, gid=f"fs-{name.replace('_', '-')}",
            )  # fmt: skip


def name_ticks(
    put: Any, values: Sequence[Value], labels: int = LABELS, middle: float = 0.5
) -> None:
    """Name some of the values along an axis of equal cells, at their middles."""
    step = max(1, -(-len(values) // labels))
    places = list(range(0, len(values), step))
    words = [f"{v:.4g}" if is_number(v) else str(v) for v in (values[k] for k in places)]
    put([place + middle for place in places], words)
