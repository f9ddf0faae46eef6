"""Sort agents into cells once per tick: only those of neighbouring cells can be within reach.

Space is divided into cells at least as wide as the rule's range, agents are sorted by cell
(counting sort, stable, so the order never depends on the number of threads).
`agents.engine.cells` says which of them a rule is shown.
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
    """First slot of each cell, (cells + 2 or more,), of `agents.engine.arrays.index_type`. Crashed
    agents are in the last."""
    tally: np.ndarray
    """Agents of each part and cell while sorting, `index_type` (parts, cells + 2 or more)."""
    corners: np.ndarray
    """What the cells span at least along open axes, float64 (2, 3): of a strip, the whole flock."""


class Slots(NamedTuple):
    """The agents sorted by cell: a frozen copy of the flock at the start of the tick."""

    cell: np.ndarray
    """Cell of each row, `index_type` (N,)."""
    row: np.ndarray
    """Row of each slot, `index_type` (N,)."""
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
    """Space for a list of slots, `index_type` (N,); empty for rules without signals."""
    kind: np.ndarray
    """Empty where there are no kinds."""
    heeds: np.ndarray
    """Whether agents of a kind are neighbours of those of another, 1.0 or 0.0, (K, K)."""


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
            low = grid.corners[0, axis]
            high = grid.corners[1, axis]
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
def wrap_into_box(x, length):
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
            x = wrap_into_box(x, space.size[axis])
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
    bad_row = -1
    for i in range(low, high):
        cell = cell_of(grid, space, flock.position, i)
        if cell < 0:
            bad_row = i if bad_row < 0 else bad_row
            cell = 0
        if mortal and flock.crash_record[i, 0] >= 0.0:
            cell = cells
        slots.cell[i] = cell
        count[cell] += 1
    return bad_row


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
            in_cell = grid.tally[part, cell]
            grid.tally[part, cell] = slot
            slot += in_cell
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
def fill_slots(slots, position, heading, speed, memory, kind, low, high):
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
        if slots.kind.shape[0] > 0:
            slots.kind[slot] = kind[i]
        for k in range(slots.signal.shape[0]):
            slots.signal[k, slot] = memory[k, i]


# Around a cell: the agents of the 3 x 3 (3 x 3 x 3) cells, copied into one contiguous block.

FEW = 6
"""Agents that are copied faster one by one than column by column."""


@compiled
def axis_cells(grid, space, axis, at, rings):
    """The cells around `at` along an axis, as a first offset and a number of them.

    There are so many `rings` of cells around, or fewer where the world ends. Across a seam the axis
    needs 2 rings + 1 cells.
    """
    if grid.shape[axis] == 1:
        return 0, 1
    if space.images[axis]:
        return -rings, 2 * rings + 1
    first = max(-rings, -at)
    last = min(rings, grid.shape[axis] - 1 - at)
    return first, last - first + 1


@compiled
def wrap_cell(grid, space, axis, at):
    """Cell index along a wrapping axis and the shift (length) to its nearest image."""
    n = grid.shape[axis]
    if at < 0:
        return at + n, -space.size[axis]
    if at >= n:
        return at - n, space.size[axis]
    return at, 0.0


@compiled
def cell_around(grid, space, cell, k):
    """The k-th of the up to 27 cells around a cell, itself among them: (cell or -1, shifts x y z).

    The shifts bring its agents to their nearest image.
    """
    nx, ny, nz = grid.shape[0], grid.shape[1], grid.shape[2]
    x = cell % nx + k % 3 - 1
    y = cell // nx % ny + k // 3 % 3 - 1
    z = cell // (nx * ny) + k // 9 - 1
    ax, sx = wrap_cell(grid, space, 0, x)
    ay, sy = wrap_cell(grid, space, 1, y)
    az, sz = wrap_cell(grid, space, 2, z)
    seen = (
        (x == ax or (space.images[0] and nx > 1))
        and (y == ay or (space.images[1] and ny > 1))
        and (z == az or (space.images[2] and nz > 1))
    )
    inside = 0 <= ax < nx and 0 <= ay < ny and 0 <= az < nz
    return (az * ny + ay) * nx + ax if seen and inside else -1, sx, sy, sz


@compiled
def copy_column(target, m, source, first, n, shift):
    """target[m : m + n] = source[first : first + n] + shift; unsigned, to be vector code."""
    to, of = np.uintp(m), np.uintp(first)
    for k in range(np.uintp(n)):
        target[to + k] = source[of + k] + shift


@compiled
def copy_run(slots, block, signals, m, first, last, sx, sy, sz):
    """Copy slots first to last behind the m agents already in the block, shifted."""
    n = last - first
    if n <= FEW:
        for k in range(n):
            block[0, m + k] = slots.x[first + k] + sx
            block[1, m + k] = slots.y[first + k] + sy
            block[3, m + k] = slots.ux[first + k]
            block[4, m + k] = slots.uy[first + k]
            if slots.z.shape[0] > 0:
                block[2, m + k] = slots.z[first + k] + sz
                block[5, m + k] = slots.uz[first + k]
            if slots.speed.shape[0] > 0:
                block[9, m + k] = slots.speed[first + k]
            if slots.kind.shape[0] > 0:
                block[10, m + k] = slots.kind[first + k]
            for q in range(slots.signal.shape[0]):
                signals[q, m + k] = slots.signal[q, first + k]
        return m + n
    copy_column(block[0], m, slots.x, first, n, sx)
    copy_column(block[1], m, slots.y, first, n, sy)
    copy_column(block[3], m, slots.ux, first, n, 0.0)
    copy_column(block[4], m, slots.uy, first, n, 0.0)
    if slots.z.shape[0] > 0:
        copy_column(block[2], m, slots.z, first, n, sz)
        copy_column(block[5], m, slots.uz, first, n, 0.0)
    if slots.speed.shape[0] > 0:
        copy_column(block[9], m, slots.speed, first, n, 0.0)
    if slots.kind.shape[0] > 0:
        copy_column(block[10], m, slots.kind, first, n, 0.0)
    for q in range(slots.signal.shape[0]):
        copy_column(signals[q], m, slots.signal[q], first, n, 0.0)
    return m + n


@compiled
def fill_block(grid, space, slots, cell, block, signals):
    """Copy the agents of the cells around `cell` into the block, shifted to the nearest image.

    Returns how many. Neighbouring cells along x are neighbours in memory too, so that away from
    the seam three of them are one run.
    """
    nx, ny = grid.shape[0], grid.shape[1]
    cx, cy, cz = cell % nx, (cell // nx) % ny, cell // (nx * ny)
    fx, mx = axis_cells(grid, space, 0, cx, 1)
    fy, my = axis_cells(grid, space, 1, cy, 1)
    fz, mz = axis_cells(grid, space, 2, cz, 1)
    m = 0
    for kz in range(fz, fz + mz):
        az, sz = wrap_cell(grid, space, 2, cz + kz)
        for ky in range(fy, fy + my):
            ay, sy = wrap_cell(grid, space, 1, cy + ky)
            base = (az * ny + ay) * nx
            if cx + fx >= 0 and cx + fx + mx <= nx:
                first = grid.start[base + cx + fx]
                last = grid.start[base + cx + fx + mx]
                m = copy_run(slots, block, signals, m, first, last, 0.0, sy, sz)
            else:
                for kx in range(fx, fx + mx):
                    ax, sx = wrap_cell(grid, space, 0, cx + kx)
                    first, last = grid.start[base + ax], grid.start[base + ax + 1]
                    m = copy_run(slots, block, signals, m, first, last, sx, sy, sz)
    return m


@compiled
def nearest_images(space, grid, block, m, x, y, z, dim):
    """For axes of a single cell: bring every agent of the block to its image nearest to (x, y, z).

    The images stand in rows 6 to 8 of the block, where `NearClaim` reads positions.
    """
    for axis in range(dim):
        coordinate = x if axis == 0 else (y if axis == 1 else z)
        length = space.size[axis]
        if space.images[axis] and grid.shape[axis] == 1:
            for j in range(m):
                d = block[axis, j] - coordinate
                block[6 + axis, j] = coordinate + (d - length * math.floor(d / length + 0.5))
        else:
            for j in range(m):
                block[6 + axis, j] = block[axis, j]
