"""A tick in two phases: every agent decides on the same state, then all of them move.

This file is a template. `agents.engine.compiled_loop` loads it once for each rule and body as a
module of its own, with the names of `agents.engine.template` put in place, because numba caches a
kernel on disk only if it reaches the rule as a global.

Everything a tick does passes through the one loop in `advance`: many ticks in one call, a share of
the flock on one of several threads, a single agent. They run the same machine instructions on the
same blocks, and so give the same bits.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from agents.engine.arrays import COUNT, FILL, PLACE, PLAN, PREPARE, SHARE, SWEEP
from agents.engine.block import Me, NeighbourBlock, neighbour_of, see_points
from agents.engine.cells import (
    FAR,
    count_rows,
    fill_block,
    fill_slots,
    nearest_images,
    number_of,
    place_rows,
    plan,
    share_slots,
    wrap_into_box,
)
from agents.engine.flat import ones, zeros
from agents.engine.heeding import (
    FIRST,
    OWN,
    POWER,
    RADIUS,
    WEIGHT,
    add_relations,
    edge_of_view,
    is_steered,
    relation_terms,
    steered_wish,
)
from agents.engine.neighbour_search import all_images, covered_distance, fill_all, rank, width_for
from agents.engine.noise import add_heading_noise, carry_with_wind, tick_key
from agents.engine.solid_collision import PASSES, crash, fall, keep_out_of_solids
from agents.engine.waypoint_heading import waypoint_heading
from worlds.compilation import compiled, entry
from worlds.queries.surroundings import set_goal

if TYPE_CHECKING:
    from agents.engine.template import (
        ASKS_SPEED,
        CRASHES,
        DEAFENS,
        DIM,
        HEADS,
        KINDS,
        MEASURES,
        MEETS,
        NEAREST,
        PRIVATE,
        SEES_POINTS,
        SIFTS,
        SIGNALS,
        WINDY,
        decide,
        holds,
        measure,
        move,
        own_of_row,
        passes,
        perceive,
        prepare,
        remember,
        show,
        touches,
        view_of,
    )


MANY = 24
"""Agents in a block from which on those within reach are picked out for a rule that `SIFTS`."""


@compiled
def write_move(flock, space, surroundings, i, me, move, context):
    """Write where body and wind bring row i, within the world's edges and out of its solids."""
    if WINDY:
        move = carry_with_wind(move, context, me.tick)
    if MEETS != PASSES and not passes(context.parameters):
        move = keep_out_of_solids(surroundings, space, me, move, MEETS)
    flock.position[i, 0] = wrap_into_box(move.x, space.size[0]) if space.wraps[0] else move.x
    flock.position[i, 1] = wrap_into_box(move.y, space.size[1]) if space.wraps[1] else move.y
    flock.heading[i, 0] = move.ux
    flock.heading[i, 1] = move.uy
    if DIM == 3:
        flock.position[i, 2] = wrap_into_box(move.z, space.size[2]) if space.wraps[2] else move.z
        flock.heading[i, 2] = move.uz
    flock.speed[i] = move.speed


@compiled
def act(flock, space, surroundings, i, me, near, visible, context, workspace):
    """One agent's tick: perceive, decide, add noise, move, remember; or fall, if it has crashed.

    The rule goes by those `visible`, the body by all that are `near`. An information agent listens
    to nobody: it follows the mission's path, or keeps its heading.
    """
    p = own_of_row(context.parameters, flock.own, i)
    q = own_of_row(context.unbounded, flock.own, i) if NEAREST else p
    if CRASHES and flock.crash_record[i, 0] >= 0.0:
        fall(flock, space, surroundings, i, context.lasts)
        return
    if KINDS and flock.kind[i] < 0.0:
        flock.speed[i] = 0.0
        return
    out = workspace.out
    for k in range(SIGNALS):
        out[k] = me.signal[k]
    if me.informed:
        want = waypoint_heading(flock, surroundings, i, me)
    else:
        if PRIVATE > 0:
            perceive(me, visible, surroundings, q)
        want = decide(me, visible, surroundings, q)
        if KINDS:
            related = related_sum(me, near, workspace.block[10], flock.kind[i], context, p)
            want = add_relations(want, related)
            if is_steered(flock, i):
                want = steered_wish(flock, i)
        if HEADS:
            want = add_heading_noise(me, want, context.noise, p.eta, DIM)
    body_move = move(me, near, surroundings, want, p, out)
    write_move(flock, space, surroundings, i, me, body_move, context)
    if SIGNALS > 0:
        remember(me, visible, q, out)
    for k in range(SIGNALS):
        flock.memory[k, i] = out[k]
    for k in range(PRIVATE):
        flock.memory[SIGNALS + k, i] = me.memory[k]
    if MEASURES > 0:
        measure(me, near, p, workspace.measured)
        for k in range(MEASURES):
            flock.memory[SIGNALS + PRIVATE + k, i] = workspace.measured[k]


@compiled
def judge(flock, surroundings, i, me, near, context):
    """Crash the agent of row i if it touches another agent or what is solid."""
    p = own_of_row(context.parameters, flock.own, i)
    cause = touches(me, near, surroundings, p)
    if cause > 0.0:
        crash(flock, i, me.tick, cause)


@compiled
def agent_of_slot(flock, slots, slot, workspace, tick, key):
    """`Me` of a slot; the workspace receives its signals and its memory."""
    i = slots.row[slot]
    for k in range(SIGNALS):
        workspace.mine[k] = slots.signal[k, slot]
    for k in range(PRIVATE):
        workspace.own[k] = flock.memory[SIGNALS + k, i]
    return Me(
        slots.x[slot],
        slots.y[slot],
        slots.z[slot] if DIM == 3 else 0.0,
        slots.ux[slot],
        slots.uy[slot],
        slots.uz[slot] if DIM == 3 else 0.0,
        flock.speed[i],
        workspace.mine,
        workspace.own,
        flock.informed[i],
        0.0 if DEAFENS else 1.0,
        flock.ids[i],
        tick,
        key,
        flock.ids.shape[0],
        slots.kind[slot] if KINDS else 0.0,
    )


@compiled
def ready(flock, space, grid, slots, workspace, context, tick, key):
    """Before anyone decides: what each agent shows, and what the rule needs of the whole flock."""
    if SIGNALS > 0:
        for slot in range(slots.row.shape[0]):
            me = agent_of_slot(flock, slots, slot, workspace, tick, key)
            for k in range(SIGNALS):
                workspace.out[k] = workspace.mine[k]
            show(me, own_of_row(context.parameters, flock.own, slots.row[slot]), workspace.out)
            for k in range(SIGNALS):
                slots.signal[k, slot] = workspace.out[k]
        if KINDS:
            for kind in range(context.relations.shape[0]):
                for other in range(context.relations.shape[0]):
                    slots.heeds[kind, other] = context.relations[kind, other, OWN]
        prepare(flock, space, grid, slots, context.parameters, tick)
        for slot in range(slots.row.shape[0]):
            for k in range(SIGNALS):
                flock.memory[k, slots.row[slot]] = slots.signal[k, slot]


@compiled
def copy_within_reach(workspace, m, at, me, reach):
    """Copy those of the m agents of the block that are within reach to `close`; how many."""
    block = workspace.block
    r2 = reach * reach * FAR
    for j in range(np.uintp(m)):
        dx, dy = block[at, j] - me.x, block[at + 1, j] - me.y
        d2 = dx * dx + dy * dy
        if DIM == 3:
            dz = block[at + 2, j] - me.z
            d2 += dz * dz
        workspace.apart[j] = d2
    n = np.uintp(0)
    for j in range(np.uintp(m)):
        workspace.chosen[n] = j
        n += np.uintp(1) if workspace.apart[j] <= r2 else np.uintp(0)
    pick(workspace, at, n)
    return np.intp(n)


@compiled
def pick(workspace, at, n):
    """Copy the n agents of the block that are `chosen` to `close`; positions start at row `at`."""
    block, selected = workspace.block, workspace.close
    for axis in range(DIM):
        for k in range(n):
            selected[axis, k] = block[at + axis, np.uintp(workspace.chosen[k])]
        for k in range(n):
            selected[3 + axis, k] = block[3 + axis, np.uintp(workspace.chosen[k])]
    if ASKS_SPEED:
        for k in range(n):
            selected[6, k] = block[9, np.uintp(workspace.chosen[k])]
    if KINDS:
        for k in range(n):
            selected[7, k] = block[10, np.uintp(workspace.chosen[k])]
    for q in range(SIGNALS):
        for k in range(n):
            workspace.close_signals[q, k] = workspace.signals[q, np.uintp(workspace.chosen[k])]


@compiled
def pick_nearest(workspace, m, at, me, k):
    """Copy the k nearest of the m agents of the block to `close`; how many, and how far they go.

    That is the square of the distance of the k-th, inf where there are fewer.
    """
    n = rank(workspace.block, at, m, DIM, me, k, workspace.apart, workspace.chosen)
    pick(workspace, at, np.uintp(n))
    return n, workspace.apart[n - 1] if n == k else math.inf


@compiled
def pick_heeded(workspace, m, at, me, kind, context):
    """Copy those of the m agents of the block that are neighbours of an agent of a kind to `close`;
    how many. It is among them itself."""
    block = workspace.block
    r2 = context.reach * context.reach * FAR
    n = np.uintp(0)
    for j in range(m):
        dx, dy = block[at, j] - me.x, block[at + 1, j] - me.y
        d2 = dx * dx + dy * dy
        if DIM == 3:
            dz = block[at + 2, j] - me.z
            d2 += dz * dz
        other = int(block[10, j])
        is_heeded = d2 == 0.0
        if other >= 0 and kind >= 0.0 and d2 <= r2:
            is_heeded = is_heeded or context.relations[int(kind), other, OWN] > 0.0
        workspace.chosen[n] = j
        n += np.uintp(1) if is_heeded else np.uintp(0)
    pick(workspace, at, n)
    return np.intp(n)


@compiled
def related_sum(me, near, kinds, kind, context, p):
    """What those around an agent of a kind add to its wish, as `relation_terms` has it."""
    x = y = z = fx = fy = fz = 0.0
    edge = edge_of_view(view_of(p))
    for j in range(near.n):
        if kinds[j] < 0.0:
            continue
        relation = context.relations[int(kind), int(kinds[j])]
        if relation[WEIGHT] == 0.0:
            continue
        more = relation_terms(
            me,
            neighbour_of(me, near, j),
            edge,
            relation[WEIGHT],
            relation[RADIUS],
            relation[POWER],
            relation[FIRST],
        )
        x, y, z = x + more[0], y + more[1], z + more[2]
        fx, fy, fz = fx + more[3], fy + more[4], fz + more[5]
    return x, y, z, fx, fy, fz


@compiled
def nearest_to(space, grid, slots, workspace, cell, m, at, me, context):
    """Copy the nearest agents to `close`; how many. The block of the cell stays as it was.

    They are among the m agents of the block, or else everybody is looked at.
    """
    sure = covered_distance(grid, DIM)
    n, d2 = pick_nearest(workspace, m, at, me, context.nearest)
    if d2 > sure * sure:
        block = workspace.block
        count = fill_all(grid, slots, block, workspace.signals)
        all_images(space, block, count, me.x, me.y, me.z, DIM)
        n, _ = pick_nearest(workspace, count, 6, me, context.nearest)
        fill_block(grid, space, slots, cell, block, workspace.signals)
        nearest_images(space, grid, block, m, me.x, me.y, me.z, DIM)
    return n


@compiled
def lay(grid, space, context, position):
    """Lay the cells of a tick: as wide as the reach, or as it takes to hold the nearest agents."""
    wide = context.reach
    if NEAREST:
        wide = max(wide, width_for(space, position, context.nearest))
    plan(grid, space, wide, position)


@compiled
def nearby(m, workspace, at, points):
    """The m agents of the workspace's block, and the points there, as a rule sees them.

    Positions start at row `at`, -1 for those that were picked out.
    """
    block, signals, speeds, kinds = workspace.block, workspace.signals, 9, 10
    if at < 0:
        block, signals, at, speeds, kinds = workspace.close, workspace.close_signals, 0, 6, 7
    flat: Any = zeros()
    z, uz = (flat, flat) if DIM == 2 else (block[at + 2], block[5])
    heard: Any = signals[SIGNALS - 1] if DEAFENS else ones()
    spot = workspace.points
    return NeighbourBlock(
        m,
        block[at],
        block[at + 1],
        z,
        block[3],
        block[4],
        uz,
        block[speeds] if ASKS_SPEED else flat,
        signals,
        heard,
        points,
        spot[0],
        spot[1],
        workspace.spare,
        block[kinds] if KINDS else flat,
    )


@compiled
def sweep(flock, space, surroundings, grid, slots, workspace, context, tick, key, first, last):
    """The agents of slots first to last act, cell by cell."""
    block = workspace.block
    lone = False
    for axis in range(DIM):
        lone = lone or (space.images[axis] == 1 and grid.shape[axis] == 1)
    at = 6 if lone else 0
    slot = first
    cells = number_of(grid)
    while slot < last:
        cell = slots.cell[slots.row[slot]]
        if CRASHES and cell == cells:
            fall(flock, space, surroundings, slots.row[slot], context.lasts)
            slot += 1
            continue
        end = min(last, grid.start[cell + 1])
        m = fill_block(grid, space, slots, cell, block, workspace.signals)
        near = nearby(m, workspace, at, 0)
        while slot < end:
            me = agent_of_slot(flock, slots, slot, workspace, tick, key)
            if SEES_POINTS:
                near = nearby(
                    m, workspace, at, see_points(surroundings, context.reach, me, workspace)
                )
            if lone:
                nearest_images(space, grid, block, m, me.x, me.y, me.z, DIM)
            visible = near
            if KINDS:
                kind = flock.kind[slots.row[slot]]
                heeded_count = pick_heeded(workspace, m, at, me, kind, context)
                visible = nearby(heeded_count, workspace, -1, near.points)
            elif NEAREST:
                nearest_count = nearest_to(space, grid, slots, workspace, cell, m, at, me, context)
                visible = nearby(nearest_count, workspace, -1, near.points)
            elif SIFTS and m > MANY:
                nearest_count = copy_within_reach(workspace, m, at, me, context.reach)
                near = visible = nearby(nearest_count, workspace, -1, near.points)
            if CRASHES:
                judge(flock, surroundings, slots.row[slot], me, near, context)
            act(flock, space, surroundings, slots.row[slot], me, near, visible, context, workspace)
            slot += 1


@compiled
def note(position, numbers):
    """Copy the positions (N, dim), without the temporary array of an assignment."""
    for i in range(position.shape[0]):
        for axis in range(DIM):
            numbers[i, axis] = position[i, axis]


@entry
def advance(
    flock,
    space,
    surroundings,
    grid,
    slots,
    workspace,
    context,
    seed,
    tick,
    ticks,
    work,
    until,
    trace,
):
    """Run `ticks` ticks, or the asked phases of one.

    `work` = (phases, part, parts, first row, last row): phases is a sum of PLAN .. SWEEP, and the
    rows (slots, while sweeping) are those of this part. `until` is when to stop (`StopCondition`).
    `trace` (ticks, N, dim) or (0, N, dim) receives the positions after each tick. Returns (ticks
    done, last tick at which `holds` did not or -1, first row with a position that is no number or
    -1, room that the workspace's block lacks or 0); where it lacks room, the tick has not begun.
    """
    phases, part, parts, first, last = work
    last_off = until.last_off
    done = 0
    while done < ticks:
        tick_now = tick + done
        if until.numbers.shape[0] > 0:
            if not holds(flock, until.numbers):
                last_off = tick_now
            elif tick_now - last_off >= until.hold:
                break
        key = tick_key(seed, tick_now)
        if phases & PLAN:
            set_goal(surroundings, tick_now * context.lasts)
            lay(grid, space, context, flock.position)
        if phases & COUNT:
            bad_row = count_rows(grid, space, slots, flock, part, first, last)
            if bad_row >= 0:
                return done, last_off, bad_row, 0
        if phases & SHARE:
            need = min(3**DIM * share_slots(grid, parts), flock.ids.shape[0])
            if NEAREST:
                need = flock.ids.shape[0]
            if need > workspace.block.shape[1]:
                return done, last_off, -1, need
        if phases & PLACE:
            place_rows(grid, slots, part, first, last)
        if phases & FILL:
            fill_slots(
                slots,
                flock.position,
                flock.heading,
                flock.speed,
                flock.memory,
                flock.kind,
                first,
                last,
            )
        if phases & PREPARE:
            ready(flock, space, grid, slots, workspace, context, tick_now, key)
        if phases & SWEEP:
            sweep(
                flock,
                space,
                surroundings,
                grid,
                slots,
                workspace,
                context,
                tick_now,
                key,
                first,
                last,
            )
        if trace.shape[0] > 0:
            note(flock.position, trace[done])
        done += 1
    return done, last_off, -1, 0
