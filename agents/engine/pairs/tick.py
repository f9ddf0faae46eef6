"""A tick of a rule that is a sum over pairs: eight agents at once, in the order of their cells.

A template as `agents.engine.ticks.synchronous_tick` is, for flocks in which nobody has signals, can
crash, or has a body that asks who is near. Agents whose cells are neighbours along x
lie side by side in the slots: eight of them are the lanes of a vector, and everyone in the rows of
cells around is a candidate, met by all eight at once. So nothing is copied into blocks, and no sum
runs across lanes.

Between the ticks of one call the flock's positions and headings stay in the order of the slots; the
last tick puts them back into their rows. Threads meet between the phases of a tick without leaving
compiled code. What an agent keeps to itself stays in its row: nobody else reads it.

The bits of an agent are those of its own lane: its candidates come in the order of cells and rows,
and those that are too far add nothing. So they do not depend on who else is in the vector, and are
the same for any number of threads, in a run of many ticks, and where one agent steps alone.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from agents.engine.block import BodyMove, Me, NeighbourBlock, OtherAgent, PointBlock, see_points
from agents.engine.cells import (
    FAR,
    CellGrid,
    axis_cells,
    number_of,
    plan,
    share_slots,
    wrap_cell,
    wrap_into_box,
)
from agents.engine.eight_others import eight_from, is_there, no_lanes
from agents.engine.flat import ones, zeros
from agents.engine.heeding import (
    COLUMNS,
    FIRST,
    OWN,
    POWER,
    RADIUS,
    RELATED,
    WEIGHT,
    add_relations,
    common_kind,
    edge_of_view,
    hide,
    is_steered,
    relation_lanes,
    relation_terms,
    spread_relations,
    steer_lanes,
    steered_wish,
)
from agents.engine.neighbour_search import (
    begin_least,
    count_ties,
    covered_distance,
    holds_rings,
    keep_least,
    width_for,
)
from agents.engine.noise import add_heading_noise, carry_with_wind, tick_key
from agents.engine.pairs.cell_sort import (
    cell_at,
    count_places,
    fill_slots,
    order_cells,
    restore_row_order,
)
from agents.engine.pairs.term_sums import add_terms, choose_sums, keep_sums, no_sums, sums_of
from agents.engine.pairs.thread_barrier import BAD, NEXT, STOP, add, meet_threads, read
from agents.engine.solid_collision import PASSES, keep_out_of_solids
from agents.engine.vector_lanes import WIDTH, is_any, lane_rows, load, store, where
from agents.engine.waypoint_heading import waypoint_heading
from worlds.compilation import compiled, entry
from worlds.queries.surroundings import set_goal

if TYPE_CHECKING:
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
        SIFTS,
        SUMS,
        WINDY,
        answer,
        holds,
        move,
        own_of_eight,
        own_of_row,
        passes,
        term,
        view_of,
    )

# The names of a template are in its module before this runs; on its own it stands for a loop of no
# rule.
ALL_SUMS = globals().get("SUMS", 0) + (RELATED if globals().get("KINDS") else 0)
"""The sums of a rule, and those of relations between kinds behind them."""
SHARE = 512
"""Slots that a thread takes at a time."""
CHOSEN = 256
"""Candidates that are picked out at a time."""
RUN, OPEN, ONE = 0, 1, 2
"""What `advance` is asked for: whole ticks, the sort of one, or one slot of an opened tick."""
X, Y, Z, UX, UY, UZ, SPEED = range(7)
"""Rows of the table in which the moves of eight agents are written down."""
OWN_ROW, OTHERS, TERMS = 0, 1, 2
"""Rounds of the cells around: the k nearest are looked for in the own row, where most of them are,
then in the other rows; the last round adds up terms."""
MOST_RINGS = 4
"""Rings of cells around an agent in which its k nearest are looked for; beyond them everywhere."""


class PairWorkspace(NamedTuple):
    """What a thread writes down for itself."""

    table: np.ndarray
    """Sums and moves of eight agents, (SPEED + 1 or as many sums, 8)."""
    ids: np.ndarray
    """Their numbers, (8,)."""
    chosen: np.ndarray
    """Slots of candidates that are within reach, (CHOSEN,)."""
    least: np.ndarray
    """The least squares of distances of eight agents so far, in order, (k, 8)."""
    memory: np.ndarray
    """What eight agents keep to themselves, (PRIVATE, 8), where they answer at once."""
    found: np.ndarray
    """Boundary points around one agent: indices, int32 (points,)."""
    points: np.ndarray
    """Their coordinates, (2, points)."""
    spare: np.ndarray
    """For the rule's own working with them, (4, points)."""
    one_cell: np.ndarray
    """The shape of a grid of one cell, (3,)."""
    all_slots: np.ndarray
    """Where the slots of that cell begin and end, (2,)."""
    relations: np.ndarray
    """What eight agents have to do with each kind, (K COLUMNS, 8)."""


def empty_notes(
    number: int, private: int, points: int, index: Any, nearest: int = 1, kinds: int = 0
) -> PairWorkspace:
    """Notes of nothing yet; slots are numbered by `index`.

    For so many sums, numbers that each agent keeps to itself, boundary points around one, nearest
    agents, and kinds.
    """
    return PairWorkspace(
        np.zeros((max(SPEED + 1, number), WIDTH)),
        np.zeros(WIDTH, np.int64),
        np.zeros(CHOSEN, np.uint64),
        np.zeros((nearest, WIDTH)),
        np.zeros((private, WIDTH)),
        np.zeros(points, np.int32),
        np.zeros((2, points)),
        np.zeros((4, points)),
        np.ones(3, np.int64),
        np.zeros(2, index),
        np.zeros((kinds * COLUMNS, WIDTH)),
    )


@compiled
def empty_block():
    """The agents around, for bodies that do not look at them."""
    none: Any = zeros()
    return NeighbourBlock(
        0, none, none, none, none, none, none, none, none, ones(), 0, none, none, none, none
    )


@compiled
def is_lone(space, grid, axis):
    """Whether an axis has one cell alone, in which the nearest image is to be looked for."""
    return space.images[axis] == 1 and grid.shape[axis] == 1


@compiled
def is_any_lone(space, grid):
    """Whether some axis is."""
    return is_lone(space, grid, 0) or is_lone(space, grid, 1) or is_lone(space, grid, 2)


@compiled
def nearest(space, grid, axis, d):
    """A separation along an axis, to the nearest image."""
    if not is_lone(space, grid, axis):
        return d
    length = space.size[axis]
    return d - length * math.floor(d / length + 0.5)


@compiled
def met(slots, j, place, space, grid, lone):
    """Slot j as eight agents at `place` see it; `place` is less the shift of their images."""
    dx = slots.x[j] - place[0]
    dy = slots.y[j] - place[1]
    dz = slots.z[j] - place[2] if DIM == 3 else 0.0
    if lone:
        dx = nearest(space, grid, 0, dx)
        dy = nearest(space, grid, 1, dy)
        dz = nearest(space, grid, 2, dz) if DIM == 3 else 0.0
    d2 = dx * dx + dy * dy + dz * dz
    uz = slots.uz[j] if DIM == 3 else 0.0
    speed = slots.speed[j] if ASKS_SPEED else 0.0
    kind = slots.kind[j] if KINDS else 0.0
    return OtherAgent(dx, dy, dz, d2, slots.ux[j], slots.uy[j], uz, speed, True, kind)


@compiled
def select_within_reach(slots, first, last, place, space, grid, lone, reach, chosen):
    """Write down those of slots first to last that are within reach of any of eight; how many."""
    r2 = reach * reach * FAR
    n = np.uintp(0)
    for j in range(np.uintp(first), np.uintp(last)):
        chosen[n] = j
        n += is_any(met(slots, j, place, space, grid, lone).d2 <= r2)
    return n


@compiled
def add_run_terms(sums, slots, first, last, place, me, p, context, space, grid, lone, chosen):
    """The sums with the terms of slots first to last; `place` is less the shift of their images."""
    if SIFTS:
        for begin in range(first, last, CHOSEN):
            end = min(begin + CHOSEN, last)
            n = select_within_reach(
                slots, begin, end, place, space, grid, lone, context.reach, chosen
            )
            for k in range(n):
                other = met(slots, np.uintp(chosen[k]), place, space, grid, lone)
                sums = add_terms(sums, term(me, other, p))
        return sums
    for j in range(np.uintp(first), np.uintp(last)):
        sums = add_terms(sums, term(me, met(slots, j, place, space, grid, lone), p))
    return sums


@compiled
def add_terms_of_one_kind(sums, slots, first, last, place, me, p, space, grid, lone, relations):
    """The same where there are kinds and the eight are of one, `relations` of which are
    (K, COLUMNS): the terms of those who are neighbours, and what others add."""
    edge = edge_of_view(view_of(p))
    for j in range(np.uintp(first), np.uintp(last)):
        kind = int(slots.kind[j])
        if kind < 0:
            continue
        relation = relations[np.uintp(kind)]
        if relation[OWN] > 0.0:
            other = met(slots, j, place, space, grid, lone)
            sums = add_terms(sums[:SUMS], term(me, other, p)) + sums[SUMS:]
        if relation[WEIGHT] != 0.0:
            other = met(slots, j, place, space, grid, lone)
            numbers = relation[WEIGHT], relation[RADIUS], relation[POWER], relation[FIRST]
            more = relation_terms(me, other, edge, *numbers)
            sums = sums[:SUMS] + add_terms(sums[SUMS:], more)
    return sums


@compiled
def add_related_terms(sums, slots, first, last, place, me, p, space, grid, lone, relations):
    """The same where the eight are of several kinds; `relations` are those of each, side by side.

    A pair of which nobody of the eight has to do with the other's kind asks for one comparison.
    """
    edge = edge_of_view(view_of(p))
    for j in range(np.uintp(first), np.uintp(last)):
        kind = int(slots.kind[j])
        if kind < 0:
            continue
        other = met(slots, j, place, space, grid, lone)
        is_own = relation_lanes(relations, kind, OWN) > 0.0
        if is_any(is_own):
            terms = add_terms(sums[:SUMS], term(me, hide(other, is_own), p))
            sums = terms + sums[SUMS:]
        weight = relation_lanes(relations, kind, WEIGHT)
        if is_any((weight < 0.0) | (weight > 0.0)):
            more = relation_terms(
                me,
                other,
                edge,
                weight,
                relation_lanes(relations, kind, RADIUS),
                relation_lanes(relations, kind, POWER),
                relation_lanes(relations, kind, FIRST),
            )
            sums = sums[:SUMS] + add_terms(sums[SUMS:], more)
    return sums


@compiled
def look_for_nearest(slots, first, last, place, space, grid, lone, k, least):
    """Keep the k least squares of distances (k, 8) of eight agents, slots first to last with them.

    Most slots are too far from all eight, which asks for one comparison.
    """
    for j in range(np.uintp(first), np.uintp(last)):
        d2 = met(slots, j, place, space, grid, lone).d2
        if is_any((d2 > 0.0) & (d2 < load(least[k - 1], 0))):
            keep_least(least, k, where(d2 > 0.0, d2, math.inf))


@compiled
def add_nearest_terms(sums, ties, slots, first, last, place, me, p, space, grid, lone, limit2):
    """The sums with the terms of those of slots first to last that are among the k nearest.

    These are nearer than the k-th, the square of whose distance is `limit2`, or as far: of such
    the first ones, as many as `ties`. Returns the sums, and how many of them are left.
    """
    for j in range(np.uintp(first), np.uintp(last)):
        other = met(slots, j, place, space, grid, lone)
        if is_any((other.d2 > 0.0) & (other.d2 <= limit2)):
            is_tie = other.d2 == limit2
            is_near = (other.d2 > 0.0) & ((other.d2 < limit2) | (is_tie & (ties > 0.0)))
            ties = where(is_tie, ties - 1.0, ties)
            sums = choose_sums(is_near, add_terms(sums, term(me, other, p)), sums)
    return sums, ties


@compiled
def nearest_sums(grid, space, slots, line, low, high, there, me, p, context, lone, notes):
    """The sums of eight agents, or those that are `there`, over the k nearest of each.

    `line`, `low` and `high` as in `pair_sums`. Those whose k-th is further off than the cells
    around are sure to reach look further, and in the end at everybody, as if there were one cell.
    """
    sums = no_sums(SUMS, me.x)
    seeking, rings = there, 1
    while is_any(seeking):
        if rings > MOST_RINGS or not holds_rings(grid, space, DIM, rings):
            grid = CellGrid(
                grid.origin,
                grid.extent,
                grid.inverse,
                notes.one_cell,
                notes.all_slots,
                grid.tally,
                grid.corners,
            )
            notes.all_slots[1] = slots.row.shape[0]
            lone = is_any_lone(space, grid)
            line = low = high = 0
        begin_least(notes.least, context.nearest, seeking)
        sure = covered_distance(grid, DIM) * rings
        sums, seeking = pair_sums(
            sums,
            grid,
            space,
            slots,
            line,
            low,
            high,
            me,
            p,
            context,
            lone,
            notes,
            rings,
            sure * sure,
            -1,
        )
        rings *= 2
    return sums


@compiled
def pair_sums(
    sums, grid, space, slots, line, low, high, me, p, context, lone, notes, rings, sure2, kind
):
    """The sums, and those of eight agents in cells low to high of one row of cells along x.

    `line` is the number of that row; so many `rings` of cells around are gone through. `kind` is
    that of all eight, -1 where they are of several, or where there are none. Returns the
    sums; where the k nearest are neighbours also whose k-th is further off than the root of
    `sure2`: to their sums nothing is added.
    """
    nx, ny = grid.shape[0], grid.shape[1]
    cy, cz = (line % ny, line // ny) if DIM == 3 else (line, 0)
    fy, my = axis_cells(grid, space, 1, cy, rings)
    fz, mz = axis_cells(grid, space, 2, cz, rings)
    left, right = low - line * nx - rings, high - line * nx + rings
    crosses = space.images[0] != 0 and nx > 1
    first_side = -1 if crosses and left < 0 else 0
    last_side = 1 if crosses and right >= nx else 0
    k, least = context.nearest, notes.least
    limit2 = ties = no_lanes()
    beyond = limit2 > 0.0
    for turn in range(OWN_ROW if NEAREST else TERMS, TERMS + 1):
        if NEAREST and turn == TERMS:
            limit2 = load(least[k - 1], 0)
            ties = count_ties(least, k)
            beyond = limit2 > sure2
            limit2 = where(beyond, -1.0, limit2)
        for kz in range(fz, fz + mz):
            az, sz = wrap_cell(grid, space, 2, cz + kz)
            for ky in range(fy, fy + my):
                if NEAREST and turn != TERMS and (turn == OWN_ROW) != (kz == 0 and ky == 0):
                    continue
                ay, sy = wrap_cell(grid, space, 1, cy + ky)
                row = (az * ny + ay) * nx
                # The cells beyond the seam on the left, the row, those beyond it on the right.
                for side in range(first_side, last_side + 1):
                    begin, end = max(left, 0), min(right + 1, nx)
                    if side != 0:
                        begin, end = (
                            (nx + min(left, 0), nx) if side < 0 else (0, max(right + 1 - nx, 0))
                        )
                    first, last = grid.start[np.uintp(row + begin)], grid.start[np.uintp(row + end)]
                    place = (me.x - side * space.size[0], me.y - sy, me.z - sz)
                    if NEAREST and turn != TERMS:
                        look_for_nearest(slots, first, last, place, space, grid, lone, k, least)
                    elif NEAREST:
                        sums, ties = add_nearest_terms(
                            sums,
                            ties,
                            slots,
                            first,
                            last,
                            place,
                            me,
                            p,
                            space,
                            grid,
                            lone,
                            limit2,
                        )
                    elif KINDS and kind >= 0:
                        sums = add_terms_of_one_kind(
                            sums,
                            slots,
                            first,
                            last,
                            place,
                            me,
                            p,
                            space,
                            grid,
                            lone,
                            context.relations[np.uintp(kind)],
                        )
                    elif KINDS:
                        sums = add_related_terms(
                            sums,
                            slots,
                            first,
                            last,
                            place,
                            me,
                            p,
                            space,
                            grid,
                            lone,
                            notes.relations,
                        )
                    else:
                        sums = add_run_terms(
                            sums,
                            slots,
                            first,
                            last,
                            place,
                            me,
                            p,
                            context,
                            space,
                            grid,
                            lone,
                            notes.chosen,
                        )
    return sums, beyond


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
