"""What is in an agent's three zones: the sums that Couzin's rule and its kin are made of."""

from __future__ import annotations

import math
from typing import NamedTuple

from agents.engine.block import neighbour_of
from agents.engine.pairs.term_sums import add_terms, no_sums
from agents.engine.vector_lanes import where
from worlds.compilation import compiled

ZONE_SUMS = 12
"""How many numbers `Sums` has."""
ALL_ROUND = -2.0
"""In place of the cosine of half a field of view: nobody is out of sight."""


class Sums(NamedTuple):
    """Sums over the agents in each zone, and how many they are."""

    rx: float
    """Away from those in the zone of repulsion: -sum of unit vectors to them."""
    ry: float
    rz: float
    ox: float
    """Headings of those in the zone of orientation."""
    oy: float
    oz: float
    ax: float
    """Unit vectors to those in the zone of attraction."""
    ay: float
    az: float
    n_r: float
    n_o: float
    n_a: float


@compiled
def edge_of(alpha):
    """Cosine of half the field of view, of full angle alpha (deg), at which sight ends."""
    return math.cos(math.radians(0.5 * alpha))


@compiled
def zone_terms(me, other, r_r, r_o, r_a, close_edge, far_edge):
    """What one other agent adds to `Sums`, for the zones of outer radii r_r, r_o, r_a (length).

    `close_edge` is the cosine at which sight ends in the zone of repulsion, ALL_ROUND for none, and
    `far_edge` that in the two others. The radii need not rise: an agent is in the first that fits.
    """
    dx, dy, dz = other.dx, other.dy, other.dz
    is_other = other.d2 > 0.0
    d = math.sqrt(where(is_other, other.d2, 1.0))
    along = dx * me.ux + dy * me.uy + dz * me.uz
    in_r = is_other & (d < r_r) & (along >= close_edge * d)
    is_far = is_other & (d >= r_r) & (along >= far_edge * d)
    in_o = is_far & (d < r_o)
    in_a = is_far & (d >= r_o) & (d <= r_a)
    inverse = 1.0 / d
    away = in_r * inverse
    to = in_a * inverse
    return (
        -away * dx,
        -away * dy,
        -away * dz,
        in_o * other.ux,
        in_o * other.uy,
        in_o * other.uz,
        to * dx,
        to * dy,
        to * dz,
        in_r,
        in_o,
        in_a,
    )


@compiled
def zone_sums(me, near, r_r, r_o, r_a, close_edge, far_edge):
    """The sums over the zones, of the agents of the block: see `zone_terms`."""
    sums = no_sums(ZONE_SUMS, 0.0)
    for j in range(near.n):
        terms = zone_terms(me, neighbour_of(me, near, j), r_r, r_o, r_a, close_edge, far_edge)
        sums = add_terms(sums, terms)
    return Sums(*sums)


@compiled
def weigh_zones(me, near, r_r, r_o, r_a, close_edge, far_edge, out):
    """1 for those that count: the zone of repulsion alone if anyone is in it, else the others."""
    n_r = zone_sums(me, near, r_r, r_o, r_a, close_edge, far_edge).n_r
    for j in range(near.n):
        dx, dy, dz = near.x[j] - me.x, near.y[j] - me.y, near.z[j] - me.z
        d = math.sqrt(dx * dx + dy * dy + dz * dz)
        along = dx * me.ux + dy * me.uy + dz * me.uz
        is_close = 0.0 < d < r_r and along >= close_edge * d
        is_far = r_r <= d <= max(r_o, r_a) and along >= far_edge * d
        out[j] = 1.0 if (is_close if n_r > 0.0 else is_far) else 0.0
