"""Sort the agents into slots at every tick, so that those of a cell lie side by side.

A place is where an agent's position and heading stand in the flock's arrays between two ticks: its
row, or its last slot. Within a cell agents stand in the order of their rows, so that sums over them
do not depend on where they came from, nor on the number of threads.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from agents.engine.cells import number_of, wrap_into_box
from worlds.compilation import compiled

ONE = np.uintp(1)


@compiled
def cell_axis(grid, axis):
    """What `cell_along` needs of an axis: where its cells begin, how many in a length, the last."""
    return grid.origin[axis], grid.inverse[axis], grid.shape[axis] - 1


@compiled
def cell_along(axis, x):
    """The cell along a `cell_axis` of a coordinate in the box."""
    origin, inverse, last = axis
    return min(max(int((x - origin) * inverse), 0), last)


@compiled
def count_places(grid, space, position, slots, part, low, high):
    """First pass: the cell of places low to high, counted for this part.

    Positions are brought into the box. Returns the first place with one that is not finite, or -1.
    """
    count = grid.tally[part]
    for cell in range(np.uintp(number_of(grid))):
        count[cell] = 0
    bad_row = -1
    solid = position.shape[1] == 3
    # In the loop LLVM would read these anew for every agent, since it writes positions.
    x_wraps, y_wraps, z_wraps = space.wraps[0] != 0, space.wraps[1] != 0, space.wraps[2] != 0
    x_size, y_size, z_size = space.size[0], space.size[1], space.size[2]
    x_axis, y_axis, z_axis = cell_axis(grid, 0), cell_axis(grid, 1), cell_axis(grid, 2)
    nx, ny = grid.shape[0], grid.shape[1]
    for i in range(np.uintp(low), np.uintp(high)):
        x, y, z = position[i, 0], position[i, 1], position[i, 2] if solid else 0.0
        if not (abs(x) + abs(y) + abs(z) < math.inf):
            bad_row = int(i) if bad_row < 0 else bad_row
            x = y = z = 0.0
        if x_wraps and not 0.0 <= x < x_size:
            x = position[i, 0] = wrap_into_box(x, x_size)
        if y_wraps and not 0.0 <= y < y_size:
            y = position[i, 1] = wrap_into_box(y, y_size)
        cell = cell_along(y_axis, y)
        if solid:
            if z_wraps and not 0.0 <= z < z_size:
                z = position[i, 2] = wrap_into_box(z, z_size)
            cell += cell_along(z_axis, z) * ny
        cell = cell * nx + cell_along(x_axis, x)
        slots.cell[i] = cell
        count[np.uintp(cell)] += 1
    return bad_row


@compiled
def fill_slots(grid, position, heading, speed, kind, slots, part, low, high):
    """Third pass, after `share_slots`: copy places low to high into their slots."""
    count = grid.tally[part]
    solid = position.shape[1] == 3
    for i in range(np.uintp(low), np.uintp(high)):
        cell = np.uintp(slots.cell[i])
        slot = np.uintp(count[cell])
        count[cell] += 1
        slots.row[slot] = slots.queue[i]
        slots.x[slot] = position[i, 0]
        slots.y[slot] = position[i, 1]
        slots.ux[slot] = heading[i, 0]
        slots.uy[slot] = heading[i, 1]
        if solid:
            slots.z[slot] = position[i, 2]
            slots.uz[slot] = heading[i, 2]
        if slots.speed.shape[0] > 0:
            slots.speed[slot] = speed[slots.queue[i]]
        if slots.kind.shape[0] > 0:
            slots.kind[slot] = kind[slots.queue[i]]


@compiled
def exchange(slots, a, b):
    """Swap two slots."""
    slots.row[a], slots.row[b] = slots.row[b], slots.row[a]
    slots.x[a], slots.x[b] = slots.x[b], slots.x[a]
    slots.y[a], slots.y[b] = slots.y[b], slots.y[a]
    slots.ux[a], slots.ux[b] = slots.ux[b], slots.ux[a]
    slots.uy[a], slots.uy[b] = slots.uy[b], slots.uy[a]
    if slots.z.shape[0] > 0:
        slots.z[a], slots.z[b] = slots.z[b], slots.z[a]
        slots.uz[a], slots.uz[b] = slots.uz[b], slots.uz[a]
    if slots.speed.shape[0] > 0:
        slots.speed[a], slots.speed[b] = slots.speed[b], slots.speed[a]
    if slots.kind.shape[0] > 0:
        slots.kind[a], slots.kind[b] = slots.kind[b], slots.kind[a]


@compiled
def order_cells(grid, slots, low, high):
    """Fourth pass: the agents of cells low to high by row. Few are out of it, as few have moved."""
    row = slots.row
    for cell in range(np.uintp(low), np.uintp(high)):
        begin, end = np.uintp(grid.start[cell]), np.uintp(grid.start[cell + ONE])
        for slot in range(begin + ONE, end):
            at: Any = slot
            while at > begin and row[at - ONE] > row[at]:
                exchange(slots, at - ONE, at)
                at -= ONE


@compiled
def restore_row_order(flock, slots):
    """Give positions and headings their rows again, in a tick that does not come to its end."""
    n = slots.row.shape[0]
    for axis in range(flock.position.shape[1]):
        for i in range(n):
            slots.x[i] = flock.position[i, axis]
            slots.y[i] = flock.heading[i, axis]
        for i in range(n):
            flock.position[slots.queue[i], axis] = slots.x[i]
            flock.heading[slots.queue[i], axis] = slots.y[i]


@compiled
def cell_at(grid, slot):
    """The cell of a slot."""
    low, high = 0, number_of(grid)
    while high - low > 1:
        middle = (low + high) // 2
        if grid.start[middle] <= slot:
            low = middle
        else:
            high = middle
    return low
