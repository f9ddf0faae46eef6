"""A map over two axes: the mean of each cell as a colour; cells without a value are marked."""

from __future__ import annotations

from typing import Any

import numpy as np

from agents.flock import Flock
from app.strict_table import Value
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.pictures.cell_runs import CellRuns, is_number, values_of
from app.studies.sweeps.pictures.mean_lines import CENSORED, FAILED
from app.studies.sweeps.sweep_table import places_of, spec_at
from worlds.input_error import InputError

# How a flock of each cell looks at its end, drawn small into the cell of a map.

MOST = 150
"""Cells whose flocks are drawn."""
MOST_STEPS = 50_000_000
"""Steps of agents that are run again for it."""
PART = 0.84
"""Of a cell's width, the rest is its colour."""


def draw_snapshots(axes: Any, kept: StoreReader, at: dict[int, tuple[int, int]]) -> None:
    """Draw the flock of each cell's first run at its end; `at` is where a cell stands on the map.

    It is run again for that. Raises InputError if there are too many, or too long runs.
    """
    first: dict[int, tuple[int, int]] = {}
    for cell, seed, status, _, _, ticks, _ in kept.runs([]):
        if status in ("ok", "gave-up") and cell in at:
            first.setdefault(cell, (seed, ticks))
    steps = sum(
        ticks * kept.cells[cell]["identity"]["spec"]["agents"] for cell, (_, ticks) in first.items()
    )
    if len(first) > MOST or steps > MOST_STEPS:
        raise InputError(
            f"the flocks of {len(first)} cells, {steps:.2g} steps of agents, are too much to draw: "
            f"leave cells out with --where, {MOST} and {MOST_STEPS:.2g} are allowed"
        )
    places = places_of(kept)
    for cell, (seed, ticks) in first.items():
        flock = Flock(spec_at(kept, places[cell], seed))
        flock.run(ticks)
        column, row = at[cell]
        corner = column - 0.5 * PART, row - 0.5 * PART
        draw_flock(axes.inset_axes([*corner, PART, PART], transform=axes.transData), flock)


def draw_flock(inset: Any, flock: Flock) -> None:
    """Draw a flock from above: arrows along its headings, as large as its world or itself."""
    low, size = flock.world.low, flock.world.size
    position, heading = flock.position, flock.heading
    inset.quiver(
        *position.T[:2], *heading.T[:2],
        angles="xy", pivot="mid", scale=14.0, width=0.02, headwidth=5, color="black",
    )  # fmt: skip
    if all(flock.world.wraps[:2]):
        inset.set_xlim(low[0], low[0] + size[0])
        inset.set_ylim(low[1], low[1] + size[1])
    else:
        inset.margins(0.1)
    inset.set_aspect("equal", adjustable="box" if all(flock.world.wraps[:2]) else "datalim")
    inset.set_xticks([])
    inset.set_yticks([])
    inset.grid(False)
    inset.patch.set_alpha(0.75)


def stands(groups: list[CellRuns], across: list[Any], up: list[Any], x: str, y: str) -> dict:
    """Where the cells of groups stand on a map, by their numbers."""
    return {
        group.number: (across.index(group.axes[x]), up.index(group.axes[y]))
        for group in groups
        if x in group.axes and y in group.axes
    }


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
