"""Draws a tick: eight agents of a flock, the cells that they are in, and whom they meet.

uv run python docs/speed_picture.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from agents import Flock
from agents.engine.vector_lanes import WIDTH
from app.worlds.world_picture import INK, LOOK, PALE

HERE = Path(__file__).parent / "pictures"
LANE, CELL, MET = "#d1495b", "#dbe7f3", "#2f6f9f"
SIDE, AGENTS, ROW = 9.0, 180, 4
"""Length of the box, agents in it, and the row of cells in which eight of them are looked at."""


def eight(flock: Flock) -> tuple[np.ndarray, tuple[int, int]]:
    """The rows of eight agents side by side in one row of cells, and the first and last cell."""
    grid, slots = flock.engine.grid, flock.engine.slots
    nx = int(grid.shape[0])
    first = int(grid.start[ROW * nx + 2])
    cells = np.searchsorted(grid.start[: nx * nx + 1], np.arange(first, first + WIDTH), "right") - 1
    return slots.row[first : first + WIDTH], (int(cells[0] % nx), int(cells[-1] % nx))


def draw(flock: Flock) -> Figure:
    """The picture."""
    rows, (low, high) = eight(flock)
    grid = flock.engine.grid
    nx = int(grid.shape[0])
    side = SIDE / nx
    figure = Figure(figsize=(7.2, 5.2), layout="constrained")
    axes = figure.subplots()
    box = (low - 1) * side, (ROW - 1) * side
    axes.add_patch(Rectangle(box, (high - low + 3) * side, 3 * side, color=CELL, zorder=0))
    for k in range(nx + 1):
        axes.plot([0, SIDE], [k * side, k * side], color=PALE, lw=0.8, zorder=1)
        axes.plot([k * side, k * side], [0, SIDE], color=PALE, lw=0.8, zorder=1)
    x, y = flock.position.T
    met = (x >= box[0]) & (x < (high + 2) * side) & (y >= box[1]) & (y < (ROW + 2) * side)
    axes.quiver(x, y, *flock.heading.T, np.where(met, 1.0, 0.0), cmap=two(), scale=42, width=0.004)
    for lane, row in enumerate(rows):
        place = flock.position[row]
        axes.add_patch(Circle(place, 0.16, color=LANE, zorder=3))
        axes.text(*place, str(lane), color="white", ha="center", va="center", fontsize=7, zorder=4)
    axes.add_patch(Circle(flock.position[rows[0]], 1.0, fill=False, color=LANE, lw=1, ls="--"))
    axes.set(xlim=(0, SIDE), ylim=(ROW * side - 3.2, ROW * side + 4.2), aspect="equal")
    axes.set_xticks([])
    axes.set_yticks([])
    note = "0 to 7: eight agents, side by side in memory    blue: met by all eight, one by one"
    axes.set_xlabel(f"{note}    dashed: r of agent 0", color=INK, fontsize=8)
    return figure


def two() -> matplotlib.colors.ListedColormap:
    """Colours of those that are left out and of those that are met."""
    return matplotlib.colors.ListedColormap(["#b9c0c8", MET])


def main() -> None:
    """Write the picture."""
    flock = Flock("vem", agents=AGENTS, size=SIDE, rng=4)
    flock.run(3)
    flock.engine.open(flock.context, flock.tick)
    with matplotlib.rc_context(LOOK):
        draw(flock).savefig(HERE / "tick.png", dpi=110)


if __name__ == "__main__":
    main()
