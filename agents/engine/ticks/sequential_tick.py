"""Sequential activation: each agent acts on the flock as those before it have left it.

NetLogo's way (`ask turtles`), and Mesa's where agents move at once. Like `synchronous_tick.py` this
is a template that `agents.engine.compiled_loop` loads for each rule. Agents are kept in lists by
cell, so that a move is seen at once. What a rule needs of the whole flock (`prepare`) is taken at
the start of the tick.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from agents.engine.block import Me
from agents.engine.cells import (
    cell_around,
    cell_of,
    count_rows,
    fill_block,
    fill_slots,
    nearest_images,
    number_of,
    place_rows,
    share_slots,
)
from agents.engine.neighbour_search import all_images
from agents.engine.noise import tick_key
from agents.engine.solid_collision import fall
from worlds.compilation import compiled, entry
from worlds.queries.surroundings import set_goal

if TYPE_CHECKING:
    from agents.engine.ticks.synchronous_tick import (
        ASKS_SPEED,
        CRASHES,
        DEAFENS,
        DIM,
        KINDS,
        NEAREST,
        PRIVATE,
        SEES_POINTS,
        SIGNALS,
        act,
        agent_of_slot,
        judge,
        lay,
        nearby,
        own_of_row,
        pick_heeded,
        pick_nearest,
        ready,
        see_points,
        show,
    )


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
def judge_all(flock, space, surroundings, grid, slots, workspace, context, tick, key):
    """Crash those that touch something, all on the flock as the tick finds it.

    They are seen until the tick ends. The workspace's block has room for all agents.
    """
    cells = number_of(grid)
    slot = 0
    while slot < grid.start[cells]:
        cell = slots.cell[slots.row[slot]]
        m = fill_block(grid, space, slots, cell, workspace.block, workspace.signals)
        while slot < grid.start[cell + 1]:
            me = agent_of_slot(flock, slots, slot, workspace, tick, key)
            nearest_images(space, grid, workspace.block, m, me.x, me.y, me.z, DIM)
            judge(flock, surroundings, slots.row[slot], me, nearby(m, workspace, 6, 0), context)
            slot += 1


@compiled
def sort_flock(flock, space, surroundings, grid, slots, workspace, context, tick, key):
    """Sort the flock into cells and do what needs all of it; returns a bad row or -1."""
    n = flock.ids.shape[0]
    set_goal(surroundings, tick * context.lasts)
    lay(grid, space, context, flock.position)
    bad_row = count_rows(grid, space, slots, flock, 0, 0, n)
    if bad_row >= 0:
        return bad_row
    share_slots(grid, 1)
    place_rows(grid, slots, 0, 0, n)
    fill_slots(slots, flock.position, flock.heading, flock.speed, flock.memory, flock.kind, 0, n)
    ready(flock, space, grid, slots, workspace, context, tick, key)
    if CRASHES:
        judge_all(flock, space, surroundings, grid, slots, workspace, context, tick, key)
    return -1


@compiled
def open_tick(flock, space, surroundings, grid, slots, workspace, context, tick, key):
    """Sort the flock, do what needs all of it, and link the lists; returns a bad row or -1."""
    bad_row = sort_flock(flock, space, surroundings, grid, slots, workspace, context, tick, key)
    if bad_row >= 0:
        return bad_row
    for cell in range(number_of(grid) + 1):
        grid.start[cell] = -1
    for i in range(flock.ids.shape[0] - 1, -1, -1):
        link(grid, slots, i, slots.cell[i])
    return -1


@compiled
def row_of(flock, i, workspace, tick, key):
    """`Me` of a row as it stands now; the workspace receives its signals and its memory."""
    flat = flock.position.shape[1] == 2
    for k in range(SIGNALS):
        workspace.mine[k] = flock.memory[k, i]
    for k in range(PRIVATE):
        workspace.own[k] = flock.memory[SIGNALS + k, i]
    return Me(
        flock.position[i, 0],
        flock.position[i, 1],
        0.0 if flat else flock.position[i, 2],
        flock.heading[i, 0],
        flock.heading[i, 1],
        0.0 if flat else flock.heading[i, 2],
        flock.speed[i],
        workspace.mine,
        workspace.own,
        flock.informed[i],
        0.0 if DEAFENS else 1.0,
        flock.ids[i],
        tick,
        key,
        flock.ids.shape[0],
        flock.kind[i] if KINDS else 0.0,
    )


@compiled
def show_signals(me, p, workspace):
    """Put into `workspace.out` what an agent shows the others, from what it remembers of it."""
    for k in range(SIGNALS):
        workspace.out[k] = workspace.mine[k]
    show(me, p, workspace.out)


@compiled
def show_own_signals(me, p, workspace):
    """Let the agent that acts see its own signals as the others do."""
    show_signals(me, p, workspace)
    for k in range(SIGNALS):
        workspace.mine[k] = workspace.out[k]


@compiled
def act_on_block(flock, space, surroundings, grid, i, me, m, context, workspace):
    """Let row i act on the m agents that the block holds, brought to their nearest images."""
    if NEAREST:
        all_images(space, workspace.block, m, me.x, me.y, me.z, DIM)
    else:
        nearest_images(space, grid, workspace.block, m, me.x, me.y, me.z, DIM)
    points = see_points(surroundings, context.reach, me, workspace) if SEES_POINTS else 0
    near = nearby(m, workspace, 6, points)
    visible = near
    if KINDS:
        heeded_count = pick_heeded(workspace, m, 6, me, flock.kind[i], context)
        visible = nearby(heeded_count, workspace, -1, points)
    elif NEAREST:
        nearest_count, _ = pick_nearest(workspace, m, 6, me, context.nearest)
        visible = nearby(nearest_count, workspace, -1, points)
    act(flock, space, surroundings, i, me, near, visible, context, workspace)


@compiled
def copy_row(flock, workspace, p, m, j, sx, sy, sz, tick, key):
    """Copy row j, shifted, into column m of the block."""
    block = workspace.block
    other = row_of(flock, j, workspace, tick, key)
    block[0, m] = other.x + sx
    block[1, m] = other.y + sy
    block[2, m] = other.z + sz
    block[3, m] = other.ux
    block[4, m] = other.uy
    block[5, m] = other.uz
    if ASKS_SPEED:
        block[9, m] = other.speed
    if KINDS:
        block[10, m] = flock.kind[j]
    if SIGNALS > 0:
        show_signals(other, own_of_row(p, flock.own, j), workspace)
        for k in range(SIGNALS):
            workspace.signals[k, m] = workspace.out[k]


@compiled
def gather_all(flock, workspace, p, tick, key):
    """Copy all agents that have not crashed into the block; how many, or -1 without room."""
    n = flock.ids.shape[0]
    if n > workspace.block.shape[1]:
        return -1
    m = 0
    for j in range(n):
        if not CRASHES or flock.crash_record[j, 0] < 0.0:
            copy_row(flock, workspace, p, m, j, 0.0, 0.0, 0.0, tick, key)
            m += 1
    return m


@compiled
def gather(flock, space, grid, slots, workspace, p, i, tick, key):
    """Copy the agents around row i into the block; returns how many, or -1 if it has no room."""
    block = workspace.block
    m = 0
    for c in range(27):
        cell, sx, sy, sz = cell_around(grid, space, slots.cell[i], c)
        j = grid.start[cell] if cell >= 0 else -1
        while j >= 0:
            if m == block.shape[1]:
                return -1
            copy_row(flock, workspace, p, m, j, sx, sy, sz, tick, key)
            m += 1
            j = slots.row[j]
    return m


@entry
def advance(
    flock, space, surroundings, grid, slots, workspace, context, seed, tick, order, first, opens
):
    """Let the rows order[first:] act in turn, after opening the tick if `opens`.

    Returns (place in `order` reached, first row with a position that is no number or -1). It stops
    early, before the agent at that place has acted, if the workspace's block lacks room.
    """
    p = context.parameters
    key = tick_key(seed, tick)
    if opens:
        bad_row = open_tick(flock, space, surroundings, grid, slots, workspace, context, tick, key)
        if bad_row >= 0:
            return first, bad_row
    for at in range(first, order.shape[0]):
        i = order[at]
        if CRASHES and flock.crash_record[i, 0] >= 0.0:
            fall(flock, space, surroundings, i, context.lasts)
            continue
        if NEAREST:
            m = gather_all(flock, workspace, p, tick, key)
        else:
            m = gather(flock, space, grid, slots, workspace, p, i, tick, key)
        if m < 0:
            return at, -1
        me = row_of(flock, i, workspace, tick, key)
        if SIGNALS > 0:
            show_own_signals(me, own_of_row(p, flock.own, i), workspace)
        act_on_block(flock, space, surroundings, grid, i, me, m, context, workspace)
        unlink(grid, slots, i)
        cell = cell_of(grid, space, flock.position, i)
        if cell < 0:
            return at, i
        link(grid, slots, i, cell)
    return order.shape[0], -1
