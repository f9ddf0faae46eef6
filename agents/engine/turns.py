"""Turns: agents act one after another, each on the flock as those before it have left it.

NetLogo's way (`ask turtles`), and Mesa's where agents move at once. Like `sweep.py` this is a
template that `agents.engine.loop` loads for each rule. Agents are kept in lists by cell, so that a
move is seen at once. What a rule needs of the whole flock (`prepare`) is taken at the start of the
tick.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from agents.engine.block import Me
from agents.engine.cells import (
    around,
    cell_of,
    count_rows,
    fill_slots,
    place_rows,
    plan,
    share_slots,
)
from agents.engine.noise import tick_key
from worlds.compiled import compiled, entry

if TYPE_CHECKING:
    from agents.engine.sweep import SIGNALS, act, nearby, nearest_images, ready, show


@compiled
def link(grid, slots, i, cell):
    """Put row i at the head of a cell's list: `grid.start` the heads, `slots.row` what follows."""
    slots.row[i] = grid.start[cell]
    grid.start[cell] = i
    slots.cell[i] = cell


@compiled
def unlink(grid, slots, i):
    """Take row i out of the list of its cell."""
    cell = slots.cell[i]
    at = grid.start[cell]
    if at == i:
        grid.start[cell] = slots.row[i]
        return
    while slots.row[at] != i:
        at = slots.row[at]
    slots.row[at] = slots.row[i]


@compiled
def open_tick(flock, space, grid, slots, desk, p, reach, tick, key):
    """Sort the flock, do what needs all of it, and link the lists; returns a bad row or -1."""
    n = flock.ids.shape[0]
    plan(grid, space, reach, flock.position)
    bad = count_rows(grid, space, slots, flock.position, 0, 0, n)
    if bad >= 0:
        return bad
    share_slots(grid, 1)
    place_rows(grid, slots, 0, 0, n)
    fill_slots(slots, flock.position, flock.heading, flock.memory, 0, n)
    ready(flock, space, grid, slots, p, tick, key, desk.mine, desk.out)
    for cell in range(grid.shape[0] * grid.shape[1] * grid.shape[2]):
        grid.start[cell] = -1
    for i in range(n - 1, -1, -1):
        link(grid, slots, i, slots.cell[i])
    return -1


@compiled
def row_of(flock, i, shown, tick, key):
    """`Me` of a row as it stands now; `shown` receives its signals."""
    flat = flock.position.shape[1] == 2
    for k in range(SIGNALS):
        shown[k] = flock.memory[k, i]
    return Me(
        flock.position[i, 0],
        flock.position[i, 1],
        0.0 if flat else flock.position[i, 2],
        flock.heading[i, 0],
        flock.heading[i, 1],
        0.0 if flat else flock.heading[i, 2],
        flock.speed[i],
        shown,
        flock.ids[i],
        tick,
        key,
        flock.ids.shape[0],
    )


@compiled
def gather(flock, space, grid, slots, desk, p, i, tick, key):
    """Copy the agents around row i into the desk's block; returns how many, or -1 for no room."""
    block = desk.block
    m = 0
    for c in range(27):
        cell, sx, sy, sz = around(grid, space, slots.cell[i], c)
        j = grid.start[cell] if cell >= 0 else -1
        while j >= 0:
            if m == block.shape[1]:
                return -1
            other = row_of(flock, j, desk.mine, tick, key)
            block[0, m] = other.x + sx
            block[1, m] = other.y + sy
            block[2, m] = other.z + sz
            block[3, m] = other.ux
            block[4, m] = other.uy
            block[5, m] = other.uz
            if SIGNALS > 0:
                for k in range(SIGNALS):
                    desk.out[k] = desk.mine[k]
                show(other, p, desk.out)
                for k in range(SIGNALS):
                    desk.signals[k, m] = desk.out[k]
            m += 1
            j = slots.row[j]
    return m


@entry
def advance(flock, space, grid, slots, desk, p, noise, reach, seed, tick, order, first, opens):
    """Let the rows order[first:] act in turn, after opening the tick if `opens`.

    Returns (place in `order` reached, first row with a position that is no number or -1). It stops
    early, before the agent at that place has acted, if the desk's block lacks room.
    """
    key = tick_key(seed, tick)
    if opens:
        bad = open_tick(flock, space, grid, slots, desk, p, reach, tick, key)
        if bad >= 0:
            return first, bad
    for at in range(first, order.shape[0]):
        i = order[at]
        m = gather(flock, space, grid, slots, desk, p, i, tick, key)
        if m < 0:
            return at, -1
        me = row_of(flock, i, desk.mine, tick, key)
        if SIGNALS > 0:
            for k in range(SIGNALS):
                desk.out[k] = desk.mine[k]
            show(me, p, desk.out)
            for k in range(SIGNALS):
                desk.mine[k] = desk.out[k]
        nearest_images(space, grid, desk.block, m, me.x, me.y, me.z)
        near = nearby(m, desk.block, 6, desk.signals)
        act(flock, space, i, me, near, p, noise, desk.out)
        unlink(grid, slots, i)
        cell = cell_of(grid, space, flock.position, i)
        if cell < 0:
            return at, i
        link(grid, slots, i, cell)
    return order.shape[0], -1
