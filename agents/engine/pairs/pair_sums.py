"""The sums of eight agents over those around them, all within reach or the nearest.

A template like `agents.engine.pairs.tick`, which is given `pair_sums` and `nearest_sums` of it.
Everyone in the rows of cells around is a candidate, met by all eight at once. Candidates come in
the order of cells and rows, and those that are too far add nothing.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from agents.engine.block import OtherAgent
from agents.engine.cells import FAR, CellGrid, axis_cells, wrap_cell
from agents.engine.eight_others import no_lanes
from agents.engine.heeding import (
    FIRST,
    OWN,
    POWER,
    RADIUS,
    WEIGHT,
    edge_of_view,
    hide,
    relation_lanes,
    relation_terms,
)
from agents.engine.neighbour_search import (
    begin_least,
    count_ties,
    covered_distance,
    holds_rings,
    keep_least,
)
from agents.engine.pairs.pair_workspace import CHOSEN
from agents.engine.pairs.term_sums import add_terms, choose_sums, no_sums
from agents.engine.vector_lanes import is_any, load, where
from worlds.compilation import compiled

if TYPE_CHECKING:
    from agents.engine.template import (
        ASKS_SPEED,
        DIM,
        KINDS,
        NEAREST,
        SIFTS,
        SUMS,
        term,
        view_of,
    )

OWN_ROW, OTHERS, TERMS = 0, 1, 2
"""Rounds of the cells around: the k nearest are looked for in the own row, where most of them are,
then in the other rows; the last round adds up terms."""
MOST_RINGS = 4
"""Rings of cells around an agent in which its k nearest are looked for; beyond them everywhere."""


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
