"""A tick in which agents know of each other only what messages have brought.

Every agent decides on its own present and on the others as the newest message from each tells of
them, or as it takes that for (`agents.engine.message_past`). What is felt and not told, a touch,
goes by the present. Like `synchronous_tick.py` this is a template that
`agents.engine.compiled_loop` loads for each rule. Agents are kept in lists by the cell of the
newest place that may be known of them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from agents.engine.cells import (
    cell_around,
    cell_of,
    count_rows,
    fill_slots,
    nearest_images,
    number_of,
    place_rows,
    plan,
    share_slots,
)
from agents.engine.message_past import FURTHEST, age_of, note_present, place_error
from agents.engine.neighbour_search import all_images
from agents.engine.noise import tick_key
from agents.engine.solid_collision import fall
from worlds.compilation import compiled, entry
from worlds.queries.surroundings import set_goal

if TYPE_CHECKING:
    from agents.engine.ticks.sequential_tick import judge_all, link, row_of
    from agents.engine.ticks.synchronous_tick import (
        ASKS_SPEED,
        CRASHES,
        DIM,
        NEAREST,
        SEES_POINTS,
        SIGNALS,
        act,
        lay,
        nearby,
        pick_nearest,
        ready,
        see_points,
        show,
    )


@compiled
def across(space, axis, d):
    """A separation along an axis, to the nearest image if the world shows images."""
    if space.images[axis]:
        return d - space.size[axis] * math.floor(d / space.size[axis] + 0.5)
    return d


@compiled
def look_back(flock, space, messages, tick, memory):
    """Fill `memory` (N, dim) with the newest places that messages may tell of.

    Returns how far from there the oldest ones may be, length.
    """
    n, ages, _ = flock.past.shape
    first = min(messages.delay, ages - 1)
    latest = (tick - first + ages) % ages
    furthest_step = 0.0
    for i in range(n):
        for axis in range(DIM):
            memory[i, axis] = flock.past[i, latest, axis]
        for age in range(first + 1, ages):
            at = (tick - age + ages) % ages
            d2 = 0.0
            for axis in range(DIM):
                d = across(space, axis, flock.past[i, at, axis] - memory[i, axis])
                d2 += d * d
            furthest_step = max(furthest_step, d2)
    return math.sqrt(furthest_step)


@compiled
def open_tick(
    flock, space, surroundings, grid, slots, workspace, context, messages, memory, tick, key
):
    """Do what needs the whole flock, tell the present, and link the lists; a bad row or -1."""
    n = flock.ids.shape[0]
    set_goal(surroundings, tick * context.lasts)
    lay(grid, space, context, flock.position)
    bad_row = count_rows(grid, space, slots, flock, 0, 0, n)
    if bad_row >= 0:
        return bad_row
    share_slots(grid, 1)
    place_rows(grid, slots, 0, 0, n)
    fill_slots(slots, flock.position, flock.heading, flock.speed, flock.memory, 0, n)
    ready(flock, space, grid, slots, workspace, context.parameters, tick, key)
    if CRASHES:
        judge_all(flock, space, surroundings, grid, slots, workspace, context.parameters, tick, key)
    note_present(flock, tick)
    error_reach = FURTHEST * messages.error * math.sqrt(DIM)
    back = look_back(flock, space, messages, tick, memory)
    plan(grid, space, context.reach + error_reach + back, memory)
    for cell in range(number_of(grid) + 1):
        grid.start[cell] = -1
    for i in range(n - 1, -1, -1):
        if not (CRASHES and flock.crash_record[i, 0] >= 0.0):
            link(grid, slots, i, cell_of(grid, space, memory, i))
    return -1


@compiled
def copy_known(flock, space, block, signals, j, age, m, memory, tick, shifts):
    """Copy to place m of a block what is known of row j: its state `age` ticks ago."""
    ages = flock.past.shape[1]
    at = (tick - age + ages) % ages
    for axis in range(DIM):
        place = memory[j, axis] + across(space, axis, flock.past[j, at, axis] - memory[j, axis])
        block[axis, m] = place + shifts[axis]
        block[3 + axis, m] = flock.past[j, at, DIM + axis]
    if ASKS_SPEED:
        block[9, m] = flock.past[j, at, 2 * DIM]
    for k in range(SIGNALS):
        signals[k, m] = flock.past[j, at, 2 * DIM + 1 + k]


@compiled
def copy_self(block, signals, workspace, me, m):
    """Copy the agent itself, as it is now, to place m of a block."""
    block[0, m], block[1, m], block[2, m] = me.x, me.y, me.z
    block[3, m], block[4, m], block[5, m] = me.ux, me.uy, me.uz
    if ASKS_SPEED:
        block[9, m] = me.speed
    for k in range(SIGNALS):
        signals[k, m] = workspace.mine[k]


@compiled
def add_known(flock, space, workspace, messages, seed, me, i, j, m, memory, shifts):
    """Put what row i knows of row j into place m of the block; the next place."""
    ages = flock.past.shape[1]
    age = age_of(messages, seed, me.tick, flock.ids[i], flock.ids[j], ages)
    if age == ages:
        return m
    block, signals = workspace.block, workspace.signals
    copy_known(flock, space, block, signals, j, age, m, memory, me.tick, shifts)
    if messages.error > 0.0:
        for axis in range(DIM):
            off = place_error(seed, me.tick, flock.ids[i], flock.ids[j], axis)
            block[axis, m] += messages.error * off
    return m + 1


@compiled
def gather(flock, space, grid, slots, workspace, messages, seed, me, i, cell, memory):
    """Copy what row i knows of those around it, and itself, into the block; how many, or -1.

    -1: the block has no room.
    """
    copy_self(workspace.block, workspace.signals, workspace, me, 0)
    m = 1
    for c in range(27):
        near, sx, sy, sz = cell_around(grid, space, cell, c)
        j = grid.start[near] if near >= 0 else -1
        while j >= 0:
            if j != i:
                if m == workspace.block.shape[1]:
                    return -1
                shifts = (sx, sy, sz)
                m = add_known(flock, space, workspace, messages, seed, me, i, j, m, memory, shifts)
            j = slots.row[j]
    return m


@compiled
def gather_all(flock, space, workspace, messages, seed, me, i, memory):
    """Copy what row i knows of all that have not crashed, and itself; how many, or -1."""
    n = flock.ids.shape[0]
    if n > workspace.block.shape[1]:
        return -1
    copy_self(workspace.block, workspace.signals, workspace, me, 0)
    m = 1
    for j in range(n):
        if j != i and not (CRASHES and flock.crash_record[j, 0] >= 0.0):
            shifts = (0.0, 0.0, 0.0)
            m = add_known(flock, space, workspace, messages, seed, me, i, j, m, memory, shifts)
    return m


@entry
def advance(
    flock,
    space,
    surroundings,
    grid,
    slots,
    workspace,
    context,
    messages,
    memory,
    seed,
    tick,
    order,
    first,
    opens,
):
    """Let the rows order[first:] act, after opening the tick if `opens`.

    `messages` says how old they get; `memory` (N, dim) keeps the newest places between two calls.
    Returns what `advance` of `sequential_tick.py` does.
    """
    key = tick_key(seed, tick)
    if opens:
        bad_row = open_tick(
            flock, space, surroundings, grid, slots, workspace, context, messages, memory, tick, key
        )
        if bad_row >= 0:
            return first, bad_row
    for at in range(first, order.shape[0]):
        i = order[at]
        if CRASHES and flock.crash_record[i, 0] >= 0.0:
            fall(flock, space, surroundings, i, context.lasts)
            continue
        cell = cell_of(grid, space, flock.position, i)
        if cell < 0:
            return at, i
        me = row_of(flock, i, workspace, tick, key)
        if SIGNALS > 0:
            for k in range(SIGNALS):
                workspace.out[k] = workspace.mine[k]
            show(me, context.parameters, workspace.out)
            for k in range(SIGNALS):
                workspace.mine[k] = workspace.out[k]
        if NEAREST:
            m = gather_all(flock, space, workspace, messages, seed, me, i, memory)
        else:
            m = gather(flock, space, grid, slots, workspace, messages, seed, me, i, cell, memory)
        if m < 0:
            return at, -1
        if NEAREST:
            all_images(space, workspace.block, m, me.x, me.y, me.z, DIM)
        else:
            nearest_images(space, grid, workspace.block, m, me.x, me.y, me.z, DIM)
        points = see_points(surroundings, context.reach, me, workspace) if SEES_POINTS else 0
        near = nearby(m, workspace, 6, points)
        visible = near
        if NEAREST:
            nearest_count, _ = pick_nearest(workspace, m, 6, me, context.nearest)
            visible = nearby(nearest_count, workspace, -1, points)
        act(flock, space, surroundings, i, me, near, visible, context, workspace)
    return order.shape[0], -1
