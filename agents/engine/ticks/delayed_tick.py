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
    number_of,
    plan,
)
from agents.engine.message_past import FURTHEST, age_of, note_present, place_error
from agents.engine.noise import tick_key
from agents.engine.solid_collision import fall
from worlds.compilation import compiled, entry

if TYPE_CHECKING:
    from agents.engine.ticks.sequential_tick import (
        act_on_block,
        link,
        own_of_row,
        row_of,
        show_own_signals,
        sort_flock,
    )
    from agents.engine.ticks.synchronous_tick import (
        ASKS_SPEED,
        CRASHES,
        DIM,
        KINDS,
        NEAREST,
        SIGNALS,
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
    bad_row = sort_flock(flock, space, surroundings, grid, slots, workspace, context, tick, key)
    if bad_row >= 0:
        return bad_row
    note_present(flock, tick)
    error_reach = FURTHEST * messages.error * math.sqrt(DIM)
    back = look_back(flock, space, messages, tick, memory)
    plan(grid, space, context.reach + error_reach + back, memory)
    for cell in range(number_of(grid) + 1):
        grid.start[cell] = -1
    for i in range(flock.ids.shape[0] - 1, -1, -1):
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
    if KINDS:
        block[10, m] = flock.kind[j]
    for k in range(SIGNALS):
        signals[k, m] = flock.past[j, at, 2 * DIM + 1 + k]


@compiled
def copy_self(flock, block, signals, workspace, me, i, m):
    """Copy the agent of row i itself, as it is now, to place m of a block."""
    block[0, m], block[1, m], block[2, m] = me.x, me.y, me.z
    block[3, m], block[4, m], block[5, m] = me.ux, me.uy, me.uz
    if ASKS_SPEED:
        block[9, m] = me.speed
    if KINDS:
        block[10, m] = flock.kind[i]
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
    copy_self(flock, workspace.block, workspace.signals, workspace, me, i, 0)
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
    copy_self(flock, workspace.block, workspace.signals, workspace, me, i, 0)
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
            show_own_signals(me, own_of_row(context.parameters, flock.own, i), workspace)
        if NEAREST:
            m = gather_all(flock, space, workspace, messages, seed, me, i, memory)
        else:
            m = gather(flock, space, grid, slots, workspace, messages, seed, me, i, cell, memory)
        if m < 0:
            return at, -1
        act_on_block(flock, space, surroundings, grid, i, me, m, context, workspace)
    return order.shape[0], -1
