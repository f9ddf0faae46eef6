"""A map over two axes: the mean of each cell as a colour; cells without a value are marked."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.strict_table import Value
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.pictures.cell_runs import CellRuns, is_number, values_of
from app.studies.sweeps.pictures.map_snapshots import draw_snapshots, stands
from app.studies.sweeps.pictures.mean_lines import CENSORED, FAILED


def draw_map(
    figure: Any, name: str, groups: list[CellRuns], x: str, y: str, kept: StoreReader | None = None
) -> None:
    """Draw the map; every cell is as wide as another, whatever its values.

    With `kept`, the store, the flock of each cell is drawn into it. Raises InputError.
    """
    from matplotlib.lines import Line2D

    across, up = values_of(groups, x), values_of(groups, y)
    wide = 0.9 if kept is not None else 0.42
    high = max(5.2, 1.4 + wide * len(up)) if kept is not None else 5.2
    figure.set_size_inches(1.8 + min(14.0, max(4.0, wide * len(across))), min(14.0, high))
    axes = figure.subplots()
    means = np.full((len(up), len(across)), np.nan)
    marks: dict[str, list[tuple[int, int]]] = {"v": [], "x": []}
    for group in groups:
        if x not in group.axes or y not in group.axes:
            continue
        at = across.index(group.axes[x]), up.index(group.axes[y])
        means[at[1], at[0]] = group.mean
        if group.gave_up:
            marks["v"].append(at)
        if group.broken:
            marks["x"].append(at)
    shown = axes.imshow(np.ma.masked_invalid(means), origin="lower", aspect="auto", cmap="viridis")
    if kept is not None:
        draw_snapshots(axes, kept, stands(groups, across, up, x, y))
    axes.set_facecolor("#e8e8e8")
    axes.grid(False)
    figure.colorbar(shown, ax=axes, label=f"{name}, mean")
    legend = []
    for sign, colour, words in (("v", CENSORED, "some runs gave up"), ("x", FAILED, "some failed")):
        if marks[sign]:
            axes.plot(
                *zip(*marks[sign], strict=True),
                sign,
                color=colour,
                markeredgecolor="white" if sign == "v" else colour,
                markersize=7,
            )
            legend.append(Line2D([], [], marker=sign, color=colour, linestyle="", label=words))
    if legend:
        figure.legend(handles=legend, loc="outside lower right", ncols=2, fontsize=9)
    ticks(axes.set_xticks, across)
    ticks(axes.set_yticks, up)
    axes.set_xlabel(x)
    axes.set_ylabel(y)


def ticks(put: Any, values: list[Value]) -> None:
    """Name some of the values along an axis, the first and the last among them."""
    step = max(1, -(-len(values) // 10))
    places = list(range(0, len(values), step))
    words = [f"{v:.4g}" if is_number(v) else str(v) for v in (values[k] for k in places)]
    put(places, words)
