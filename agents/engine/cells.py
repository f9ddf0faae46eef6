"""Cells: which agents may be near which, found once per tick.

Space is divided into cells at least as wide as the rule's range, agents are sorted by cell
(counting sort, stable, so the order never depends on the number of threads).
`agents.engine.cell_neighbourhood` says which of them a rule is shown.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from worlds.compilation import compiled

MARGIN = 1.0 + 1e-9
"""Cells are wider than the range by this factor, so that rounding never hides a neighbour."""


FAR = 1.0 + 1e-9
"""Times the square of the reach: who is farther is so after any rounding."""


class Space(NamedTuple):
    """The world as the engine needs it; arrays have one entry per axis (3)."""

    size: np.ndarray
    """Length of each side of the box, float64."""
    wraps: np.ndarray
    """1 where positions wrap."""
    images: np.ndarray
    """1 where neighbours are seen across the seam (minimum image)."""
    floor: float
    """Height on which crashed agents come to rest, length; of no account in two dimensions."""


class CellGrid(NamedTuple):
    """The cells of one tick; `plan` fills it in place."""

    origin: np.ndarray
    """Lower corner, float64 (3,)."""
    extent: np.ndarray
    """Length of each side, float64 (3,)."""
    inverse: np.ndarray
    """Cells per unit of length, float64 (3,)."""
    shape: np.ndarray
    """Cells along each axis, int64 (3,)."""
    start: np.ndarray
    """First slot of each cell, int32 (cells + 2 or more,). Crashed agents are in the last."""
    tally: np.ndarray
    """Agents of each part and cell while sorting, int32 (parts, cells + 2 or more)."""


class Slots(NamedTuple):
    """The agents sorted by cell: a frozen copy of the flock at the start of the tick."""

    cell: np.ndarray
    """Cell of each row, int32 (N,)."""
    row: np.ndarray
    """Row of each slot, int32 (N,)."""
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    """Empty in 2-D, as is uz."""
    ux: np.ndarray
    uy: np.ndarray
    uz: np.ndarray
    speed: np.ndarray
    """Empty for rules and bodies that do not ask for it."""
    signal: np.ndarray
    """Shape (K, N)."""
    queue: np.ndarray
    """Space for a list of slots, int32 (N,); empty for rules without signals."""


@compiled
def plan(grid, space, reach, position):
    """Lay cells of at least `reach` over the box, or over the flock along open axes."""
    n, dim = position.shape
    capacity = grid.start.shape[0] - 2
    side = reach * MARGIN
    for axis in range(dim):
        if space.wraps[axis]:
            grid.origin[axis] = 0.0
            grid.extent[axis] = space.size[axis]
        else:
            low = math.inf
            high = -math.inf
            for i in range(n):
                low = min(low, position[i, axis])
                high = max(high, position[i, axis])
            grid.origin[axis] = low
            grid.extent[axis] = high - low
    while True:
        cells = 1.0
        for axis in range(3):
            number = max(1.0, math.floor(grid.extent[axis] / side)) if axis < dim else 1.0
            if space.images[axis] and number < 3.0:
                number = 1.0
            cells *= number
            grid.shape[axis] = int(min(number, 2.0**30))
            grid.inverse[axis] = number / grid.extent[axis] if number > 1.0 else 0.0
        if cells <= capacity:
            return
        side *= max(1.01, (cells / capacity) ** (1.0 / dim))


@compiled
def into_box(x, length):
    """x brought into [0, length) by whole lengths."""
    if 0.0 <= x < length:
        return x
    x -= length * math.floor(x / length)
    return 0.0 if x >= length else x


@compiled
def cell_of(grid, space, position, i):
    """The cell of row i (int), its position brought into the box; -1 if that is no number."""
    cell = 0
    for axis in range(position.shape[1] - 1, -1, -1):
        x = position[i, axis]
        if not (abs(x) < math.inf):
            return -1
        if space.wraps[axis]:
            x = into_box(x, space.size[axis])
            position[i, axis] = x
        n = grid.shape[axis]
        at = int((x - grid.origin[axis]) * grid.inverse[axis])
        cell = cell * n + min(max(at, 0), n - 1)
    return cell


@compiled
def number_of(grid):
    """How many cells there are; the cell of that number is that of crashed agents, near nobody."""
    return grid.shape[0] * grid.shape[1] * grid.shape[2]


@compiled
def count_rows(grid, space, slots, flock, part, low, high):
    """First pass of the sort: note the cell of rows low to high, count them for this part.

    Returns the first row whose position is not finite, or -1.
    """
    cells = number_of(grid)
    mortal = flock.crash_record.shape[0] > 0
    count = grid.tally[part]
    for cell in range(cells + 1):
        count[cell] = 0
    bad = -1
    for i in range(low, high):
        cell = cell_of(grid, space, flock.position, i)
        if cell < 0:
            bad = i if bad < 0 else bad
            cell = 0
        if mortal and flock.crash_record[i, 0] >= 0.0:
            cell = cells
        slots.cell[i] = cell
        count[cell] += 1
    return bad


@compiled
def share_slots(grid, parts):
    """Second pass: turn counts into the first slot of each cell, and of each part in it.

    Returns the number of agents in the fullest cell, crashed agents left out.
    """
    cells = number_of(grid)
    slot = 0
    fullest = 0
    for cell in range(cells + 1):
        grid.start[cell] = slot
        for part in range(parts):
            here = grid.tally[part, cell]
            grid.tally[part, cell] = slot
            slot += here
        if cell < cells:
            fullest = max(fullest, slot - grid.start[cell])
    grid.start[cells + 1] = slot
    return fullest


@compiled
def place_rows(grid, slots, part, low, high):
    """Third pass: give rows low to high their slots."""
    count = grid.tally[part]
    for i in range(low, high):
        cell = slots.cell[i]
        slot = count[cell]
        count[cell] = slot + 1
        slots.row[slot] = i


@compiled
def fill_slots(slots, position, heading, speed, memory, low, high):
    """Fourth pass: copy the rows of slots low to high, so that a cell's agents lie together."""
    dim = position.shape[1]
    for slot in range(low, high):
        i = slots.row[slot]
        slots.x[slot] = position[i, 0]
        slots.y[slot] = position[i, 1]
        slots.ux[slot] = heading[i, 0]
        slots.uy[slot] = heading[i, 1]
        if dim == 3:
            slots.z[slot] = position[i, 2]
            slots.uz[slot] = heading[i, 2]
        if slots.speed.shape[0] > 0:
            slots.speed[slot] = speed[i]
        for k in range(slots.signal.shape[0]):
            slots.signal[k, slot] = memory[k, i]
