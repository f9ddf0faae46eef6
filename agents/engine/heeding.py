"""Who heeds whom among kinds of agents: as neighbours of the rule, or to flee from or to chase.

A relation of a kind A to a kind B is a row of `Context.relations` (K, K, 6): whether agents of B
are neighbours of A's rule, then what they add to its wish, see `relation_terms`. What is not
related is not met. Agents that are caught and stand still have the kind CAUGHT: nobody meets them.
"""

from __future__ import annotations

import math

import numpy as np

from agents.engine.block import Decision, OtherAgent
from agents.engine.noise import exp, log
from agents.engine.own_parameters import lanes_of_rows
from agents.engine.vector_lanes import is_any, load, where
from worlds.compilation import compiled

OWN, WEIGHT, RADIUS, POWER, FIRST, CATCH = range(6)
"""Columns of a relation. WEIGHT: above 0 they chase, below 0 they flee. POWER: of the falloff with
distance, LINEAR for one that is 0 at the radius. FIRST: whether nothing else counts beside it.
CATCH: the distance at which A catches B, 0 where it does not."""
COLUMNS = 6
MOST_KINDS = 8
"""Beside the ordinary agents."""
LINEAR = -1.0
CAUGHT = -1.0
RELATED = 6
"""Sums of what others add to a wish: the vector of relations, and that of those that come first."""


@compiled
def relation_terms(me, other, edge, weight, radius, power, first):
    """What an agent of another kind adds to the wish of one, or of eight: six numbers.

    weight e_ij g(d) within the radius and the field of view, whose half has the cosine `edge`;
    g = 1 - d / radius, or d^-power.
    """
    d2 = other.d2
    ahead = other.dx * me.ux + other.dy * me.uy + other.dz * me.uz
    is_met = (d2 > 0.0) & (d2 <= radius * radius)
    d = math.sqrt(where(is_met, d2, 1.0))
    is_met = is_met & (ahead >= edge * d)
    falling = 1.0 - d / where(radius > 0.0, radius, 1.0)
    if is_any(power >= 0.0):  # rare, and dear
        falling = where(power < 0.0, falling, exp(-power * log(d)))
    share = where(is_met, weight * falling / d, 0.0)
    before = share * first
    share = share - before
    return (
        share * other.dx,
        share * other.dy,
        share * other.dz,
        before * other.dx,
        before * other.dy,
        before * other.dz,
    )


@compiled
def add_relations(wish, related):
    """A wish with what others add to it; where there is something that comes first, that alone."""
    x, y, z, fx, fy, fz = related
    is_first = fx * fx + fy * fy + fz * fz > 0.0
    return Decision(
        where(is_first, fx, wish.x + x),
        where(is_first, fy, wish.y + y),
        where(is_first, fz, wish.z + z),
    )


@compiled
def edge_of_view(view):
    """Cosine of half a field of view (deg); less than any cosine where it is all round."""
    return where(view < 360.0, math.cos(0.5 * math.radians(view)), -2.0)


@compiled
def hide(other, is_own):
    """Another agent as a rule sees it: in one's own spot, and so no neighbour, unless `is_own`."""
    return OtherAgent(
        where(is_own, other.dx, 0.0),
        where(is_own, other.dy, 0.0),
        where(is_own, other.dz, 0.0),
        where(is_own, other.d2, 0.0),
        other.ux,
        other.uy,
        other.uz,
        other.speed,
        True,
        other.kind,
    )


@compiled
def is_steered(flock, row):
    """Whether the agent of a row is told from outside what to wish."""
    return flock.wish.shape[0] > 0 and flock.wish[row, 0] == flock.wish[row, 0]


@compiled
def steered_wish(flock, row):
    """What it is told to wish."""
    return Decision(flock.wish[row, 0], flock.wish[row, 1], flock.wish[row, 2])


@compiled
def steer_lanes(flock, rows, slot, last, wish):
    """The wish of eight agents, or what those are told that are steered."""
    x = lanes_of_rows(flock.wish, rows, slot, last, 0)
    y = lanes_of_rows(flock.wish, rows, slot, last, 1)
    z = lanes_of_rows(flock.wish, rows, slot, last, 2)
    is_given = x == x  # nan is not
    return Decision(
        where(is_given, x, wish.x), where(is_given, y, wish.y), where(is_given, z, wish.z)
    )


# Eight agents at once: their relations to each kind, side by side.


@compiled
def common_kind(kinds, slot, last):
    """The kind of the agents of slots `slot` to `last`, where they are all of one, or -1."""
    kind = int(kinds[slot])
    for at in range(slot + 1, last):
        if int(kinds[at]) != kind:
            return -1
    return kind


@compiled
def spread_relations(relations, kinds, slot, last, table):
    """Write the relations of the agents of eight slots into a table (K COLUMNS, 8)."""
    number = relations.shape[0]
    for lane in range(np.uintp(table.shape[1])):
        at = min(slot + lane, last - 1)
        mine = int(kinds[at])
        for kind in range(number):
            for column in range(COLUMNS):
                value = 0.0
                if mine >= 0:
                    value = relations[mine, kind, column]
                table[kind * COLUMNS + column, lane] = value


@compiled
def relation_lanes(table, kind, column):
    """A column of the relations of eight agents to a kind, as lanes."""
    return load(table[np.uintp(kind * COLUMNS + column)], 0)
