"""A tick of a rule that is a sum over pairs: eight agents at once, in the order of their cells.

A template as `agents.engine.ticks.synchronous_tick` is, for flocks in which nobody has signals, can
crash, or has a body that asks who is near. Agents whose cells are neighbours along x lie side by
side in the slots: eight of them are the lanes of a vector, which meet those around them at once
(`agents.engine.pairs.pair_sums`). So nothing is copied into blocks, and no sum runs across lanes.

Between the ticks of one call the flock's positions and headings stay in the order of the slots; the
last tick puts them back into their rows. Threads meet between the phases of a tick without leaving
compiled code. What an agent keeps to itself stays in its row: nobody else reads it.

The bits of an agent are those of its own lane: its candidates come in the order of cells and rows,
and those that are too far add nothing. So they do not depend on who else is in the vector, and are
the same for any number of threads, in a run of many ticks, and where one agent steps alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from agents.engine.block import BodyMove, Me, NeighbourBlock, PointBlock, see_points
from agents.engine.cells import number_of, plan, share_slots, wrap_into_box
from agents.engine.eight_others import eight_from, is_there
from agents.engine.flat import ones, zeros
from agents.engine.heeding import (
    RELATED,
    add_relations,
    common_kind,
    is_steered,
    spread_relations,
    steer_lanes,
    steered_wish,
)
from agents.engine.neighbour_search import width_for
from agents.engine.noise import add_heading_noise, carry_with_wind, tick_key
from agents.engine.pairs.cell_sort import (
    cell_at,
    count_places,
    fill_slots,
    order_cells,
    restore_row_order,
)
from agents.engine.pairs.pair_workspace import SPEED, UX, UY, UZ, X, Y, Z
from agents.engine.pairs.term_sums import keep_sums, no_sums, sums_of
from agents.engine.pairs.thread_barrier import BAD, NEXT, STOP, add, meet_threads, read
from agents.engine.solid_collision import PASSES, keep_out_of_solids
from agents.engine.vector_lanes import WIDTH, lane_rows, load, store
from agents.engine.waypoint_heading import waypoint_heading
from worlds.compilation import compiled, entry
from worlds.queries.surroundings import set_goal

if TYPE_CHECKING:
    from agents.engine.pairs.pair_sums import is_any_lone, nearest_sums, pair_sums
    from agents.engine.template import (
        ASKS_SPEED,
        BY_LANES,
        DIM,
        HEADS,
        KINDS,
        MEETS,
        NEAREST,
        PRIVATE,
        SEES_POINTS,
        SUMS,
        WINDY,
        answer,
        holds,
        move,
        own_of_eight,
        own_of_row,
        passes,
    )

# The names of a template are in its module before this runs; on its own it stands for a loop of no
# rule.
ALL_SUMS = globals().get("SUMS", 0) + (RELATED if globals().get("KINDS") else 0)
"""The sums of a rule, and those of relations between kinds behind them."""
SHARE = 512
"""Slots that a thread takes at a time."""
RUN, OPEN, ONE = 0, 1, 2
"""What `advance` is asked for: whole ticks, the sort of one, or one slot of an opened tick."""


@compiled
def empty_block():
    """The agents around, for bodies that do not look at them."""
    none: Any = zeros()
    return NeighbourBlock(
        0, none, none, none, none, none, none, none, none, ones(), 0, none, none, none, none
    )


@compiled
def recall(flock, slots, slot, last, memory):
    """Read what the agents of slots `slot` to `last`, at most eight, keep to themselves."""
    begin = np.uintp(slot)
    for lane in range(np.uintp(last - slot)):
        row = np.uintp(slots.row[begin + lane])
        for k in range(np.uintp(PRIVATE)):
            memory[k, lane] = flock.memory[k, row]


@compiled
def agents_of_lanes(flock, slots, slot, last, notes, identities, tick, key):
    """`Me` of eight slots from one on; those from `last` on are of no account."""
    if PRIVATE > 0 and BY_LANES:
        recall(flock, slots, slot, last, notes.memory)
    if not identities:
        for lane in range(last - slot):
            notes.ids[lane] = flock.ids[slots.row[slot + lane]]
    return Me(
        load(slots.x, slot),
        load(slots.y, slot),
        load(slots.z, slot) if DIM == 3 else 0.0,
        load(slots.ux, slot),
        load(slots.uy, slot),
        load(slots.uz, slot) if DIM == 3 else 0.0,
        load(slots.speed, slot) if ASKS_SPEED else 0.0,
        notes.table[0],
        lane_rows(notes.memory),
        False,
        1.0,
        load(slots.row, slot) + flock.ids[0] if identities else load(notes.ids, 0),
        tick,
        key,
        flock.ids.shape[0],
        load(slots.kind, slot) if KINDS else 0.0,
    )


@compiled
def agent_of_slot(flock, slots, slot, table, tick, key):
    """`Me` of one slot, whose memory is that of its row."""
    i = slots.row[slot]
    return Me(
        slots.x[slot],
        slots.y[slot],
        slots.z[slot] if DIM == 3 else 0.0,
        slots.ux[slot],
        slots.uy[slot],
        slots.uz[slot] if DIM == 3 else 0.0,
        flock.speed[i],
        table[0],
        flock.memory[:, i],
        flock.informed[i],
        1.0,
        flock.ids[i],
        tick,
        key,
        flock.ids.shape[0],
        slots.kind[slot] if KINDS else 0.0,
    )


@compiled
def write_move(flock, space, row, to, moved):
    """Write a move to the place `to` of the agent of a row, within the world's edges."""
    flock.position[to, 0] = wrap_into_box(moved.x, space.size[0]) if space.wraps[0] else moved.x
    flock.position[to, 1] = wrap_into_box(moved.y, space.size[1]) if space.wraps[1] else moved.y
    flock.heading[to, 0] = moved.ux
    flock.heading[to, 1] = moved.uy
    if DIM == 3:
        flock.position[to, 2] = wrap_into_box(moved.z, space.size[2]) if space.wraps[2] else moved.z
        flock.heading[to, 2] = moved.uz
    if ASKS_SPEED or to == row:
        flock.speed[row] = moved.speed


@compiled
def move_of_lane(table, lane):
    """The move that is written down for one of eight."""
    return BodyMove(
        table[X, lane],
        table[Y, lane],
        table[Z, lane],
        table[UX, lane],
        table[UY, lane],
        table[UZ, lane],
        table[SPEED, lane],
    )


@compiled
def wish_of_one(surroundings, agent, sums, notes, p, reach):
    """What an agent wishes; a rule that sees boundary points is given those within reach."""
    if SEES_POINTS:
        n = see_points(surroundings, reach, agent, notes)
        points = PointBlock(n, notes.points[0], notes.points[1], notes.spare)
        return answer(agent, sums, points, surroundings, p)
    return answer(agent, sums, surroundings, p)


@compiled
def move_one(flock, space, surroundings, slots, slot, lane, me, notes, context):
    """The move of one slot, the lane of eight, of which sums or moves are written down."""
    table, out = notes.table, notes.table[0]
    p = own_of_row(context.parameters, flock.own, slots.row[slot])
    q = own_of_row(context.unbounded, flock.own, slots.row[slot]) if NEAREST else p
    agent = agent_of_slot(flock, slots, slot, table, me.tick, me.key)
    if KINDS and slots.kind[slot] < 0.0:
        return BodyMove(agent.x, agent.y, agent.z, agent.ux, agent.uy, agent.uz, 0.0)
    if BY_LANES and not agent.informed:
        moved = move_of_lane(table, lane)
    else:
        if agent.informed:
            wish = waypoint_heading(flock, surroundings, int(slots.row[slot]), agent)
        else:
            if KINDS:
                all_sums = sums_of(table, ALL_SUMS, lane)
                wish = wish_of_one(surroundings, agent, all_sums[:SUMS], notes, q, context.reach)
                wish = add_relations(wish, all_sums[SUMS:])
                if is_steered(flock, slots.row[slot]):
                    wish = steered_wish(flock, slots.row[slot])
            else:
                sums = sums_of(table, SUMS, lane)
                wish = wish_of_one(surroundings, agent, sums, notes, q, context.reach)
            if HEADS:
                wish = add_heading_noise(agent, wish, context.noise, p.eta, DIM)
        moved = move(agent, empty_block(), surroundings, wish, p, out)
    if WINDY:
        moved = carry_with_wind(moved, context, me.tick)
    if MEETS != PASSES and not passes(context.parameters):
        moved = keep_out_of_solids(surroundings, space, agent, moved, MEETS)
    return moved


@compiled
def act(flock, space, surroundings, slots, slot, last, me, p, q, sums, notes, context, to_rows):
    """Slots `slot` to `last`, at most eight, decide on their sums and move.

    The body goes by their parameters `p`, the rule by `q`: the same but where the nearest are heard
    whatever their distance. An information agent listens to nobody: it follows the mission's path,
    or keeps its heading.
    """
    table, out = notes.table, notes.table[0]
    if BY_LANES:
        if KINDS:
            want = add_relations(answer(me, sums[:SUMS], surroundings, q), sums[SUMS:])
            if flock.wish.shape[0] > 0:
                want = steer_lanes(flock, slots.row, slot, last, want)
        else:
            want = answer(me, sums, surroundings, q)
        if HEADS:
            want = add_heading_noise(me, want, context.noise, p.eta, DIM)
        body_move = move(me, empty_block(), surroundings, want, p, out)
        store(table, X, body_move.x)
        store(table, Y, body_move.y)
        store(table, Z, body_move.z)
        store(table, UX, body_move.ux)
        store(table, UY, body_move.uy)
        store(table, UZ, body_move.uz)
        store(table, SPEED, body_move.speed)
    else:
        keep_sums(table, sums)
    begin = np.uintp(slot)
    for lane in range(np.uintp(last - slot)):
        at = begin + lane
        row = np.uintp(slots.row[at])
        to = row if to_rows else at
        is_plain = BY_LANES and not WINDY and MEETS == PASSES and not KINDS
        if is_plain and not flock.informed[row]:
            moved = move_of_lane(table, lane)
        else:
            moved = move_one(flock, space, surroundings, slots, at, lane, me, notes, context)
        write_move(flock, space, row, to, moved)
        if PRIVATE > 0 and BY_LANES and not flock.informed[row]:
            for k in range(np.uintp(PRIVATE)):
                flock.memory[k, row] = notes.memory[k, lane]
        slots.queue[to] = row


@compiled
def sweep(flock, space, surroundings, grid, slots, notes, context, tick, key, span, how):
    """The agents of slots span[0] to span[1] act, up to eight of a row of cells at a time.

    `how` = (whether they are written to their rows, whether their numbers follow one another).
    """
    slot, last = span
    to_rows, identities = how
    lone = is_any_lone(space, grid)
    nx = grid.shape[0]
    low = cell_at(grid, slot)
    line = low // nx
    while slot < last:
        while grid.start[np.uintp(low + 1)] <= slot:
            low += 1
        while low >= (line + 1) * nx:
            line += 1
        end = min(min(slot + WIDTH, last), grid.start[np.uintp((line + 1) * nx)])
        high = low
        while grid.start[np.uintp(high + 1)] < end:
            high += 1
        me = agents_of_lanes(flock, slots, slot, end, notes, identities, tick, key)
        p = own_of_eight(context.parameters, flock.own, slots.row, slot, end)
        q = own_of_eight(context.unbounded, flock.own, slots.row, slot, end) if NEAREST else p
        kind = -1
        if KINDS:
            kind = common_kind(slots.kind, slot, end)
            if kind < 0:
                spread_relations(context.relations, slots.kind, slot, end, notes.relations)
        if NEAREST:
            there = is_there(eight_from(slot, end))
            sums = nearest_sums(
                grid, space, slots, line, low, high, there, me, q, context, lone, notes
            )
        else:
            sums, _ = pair_sums(
                no_sums(ALL_SUMS, me.x),
                grid,
                space,
                slots,
                line,
                low,
                high,
                me,
                q,
                context,
                lone,
                notes,
                1,
                0.0,
                kind,
            )
        act(flock, space, surroundings, slots, slot, end, me, p, q, sums, notes, context, to_rows)
        slot = end


@compiled
def sort(flock, space, surroundings, grid, slots, context, tick, meeting, part, parts):
    """Sort the flock into its slots, each thread its part; a place that is no number, or -1."""
    n = slots.row.shape[0]
    low, high = n * part // parts, n * (part + 1) // parts
    if part == 0:
        set_goal(surroundings, tick * context.lasts)
        wide = context.reach
        if NEAREST:
            wide = max(wide, width_for(space, flock.position, context.nearest))
        plan(grid, space, wide, flock.position)
    meet_threads(meeting, parts)
    meeting[BAD + part] = count_places(grid, space, flock.position, slots, part, low, high)
    meet_threads(meeting, parts)
    for k in range(parts):
        if meeting[BAD + k] >= 0:
            return meeting[BAD + k]
    if part == 0:
        share_slots(grid, parts)
    meet_threads(meeting, parts)
    fill_slots(grid, flock.position, flock.heading, flock.speed, flock.kind, slots, part, low, high)
    meet_threads(meeting, parts)
    cells = number_of(grid)
    order_cells(grid, slots, cells * part // parts, cells * (part + 1) // parts)
    meet_threads(meeting, parts)
    return -1


@compiled
def is_numbered(ids):
    """Whether the agents' numbers follow one another, as they do until one is taken away."""
    mismatches = 0
    for row in range(np.uintp(ids.shape[0])):
        mismatches |= ids[row] ^ (ids[0] + row)
    return mismatches == 0


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
    notes,
    context,
    seed,
    tick,
    ticks,
    work,
    meeting,
    until,
    trace,
):
    """Run `ticks` ticks, sort one, or let one slot of a sorted one act.

    `work` = (what is asked for, part, parts, slot). All threads of a run call this at once, each
    with its part and its notes. `until` is when to stop (`StopCondition`), for one thread. `trace`
    (ticks, N, dim) or (0, N, dim) receives the positions after each tick. Returns (ticks done, last
    tick at which `holds` did not or -1, first row with a position that is no number or -1).
    """
    asked_ticks, part, parts, slot = work
    n = slots.row.shape[0]
    identities = is_numbered(flock.ids)
    is_watched = until.numbers.shape[0] > 0
    each_to_rows = asked_ticks == ONE or is_watched or trace.shape[0] > 0
    last_off = until.last_off
    if asked_ticks != ONE:
        for i in range(n * part // parts, n * (part + 1) // parts):
            slots.queue[i] = i
    done = 0
    while done < ticks:
        tick_now = tick + done
        if is_watched:
            if not holds(flock, until.numbers):
                last_off = tick_now
            elif tick_now - last_off >= until.hold:
                break
        if asked_ticks != ONE:
            bad_row = sort(
                flock, space, surroundings, grid, slots, context, tick_now, meeting, part, parts
            )
            if bad_row >= 0:
                bad_row = slots.queue[bad_row]
                meet_threads(meeting, parts)
                if part == 0:
                    restore_row_order(flock, slots)
                meet_threads(meeting, parts)
                return done, last_off, bad_row
            if asked_ticks == OPEN or read(meeting, STOP) != 0:
                break
        first, end, size = (slot, slot + 1, 1) if asked_ticks == ONE else (0, n, n)
        if parts > 1:
            first, size = add(meeting, NEXT, SHARE), SHARE
        key = tick_key(seed, tick_now)
        how = (each_to_rows or done == ticks - 1, identities)
        while first < end:
            span = (first, min(first + size, end))
            sweep(flock, space, surroundings, grid, slots, notes, context, tick_now, key, span, how)
            first = add(meeting, NEXT, SHARE) if parts > 1 else end
        meet_threads(meeting, parts)
        if part == 0 and trace.shape[0] > 0:
            note(flock.position, trace[done])
        done += 1
    return done, last_off, -1
