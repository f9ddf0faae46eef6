"""What is in an agent's three zones: the sums that Couzin's rule and its kin are made of."""

from __future__ import annotations

import math
from typing import NamedTuple

from worlds.compiled import compiled

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
def zone_sums(me, near, r_r, r_o, r_a, close_edge, far_edge):
    """The sums over the zones of outer radii r_r, r_o, r_a (length), without a branch.

    `close_edge` is the cosine at which sight ends in the zone of repulsion, ALL_ROUND for none, and
    `far_edge` that in the two others. The radii need not rise: an agent is in the first that fits.
    """
    rx = ry = rz = ox = oy = oz = ax = ay = az = n_r = n_o = n_a = 0.0
    for j in range(near.n):
        dx = near.x[j] - me.x
        dy = near.y[j] - me.y
        dz = near.z[j] - me.z
        d2 = dx * dx + dy * dy + dz * dz
        there = d2 > 0.0
        d = math.sqrt(d2 if there else 1.0)
        along = dx * me.ux + dy * me.uy + dz * me.uz
        far = there & (d >= r_r) & (along >= far_edge * d)
        in_r = there & (d < r_r) & (along >= close_edge * d)
        in_o = far & (d < r_o)
        in_a = far & (d >= r_o) & (d <= r_a)
        inverse = 1.0 / d
        away = inverse if in_r else 0.0
        to = inverse if in_a else 0.0
        with_ = 1.0 if in_o else 0.0
        rx -= away * dx
        ry -= away * dy
        rz -= away * dz
        ox += with_ * near.ux[j]
        oy += with_ * near.uy[j]
        oz += with_ * near.uz[j]
        ax += to * dx
        ay += to * dy
        az += to * dz
        n_r += 1.0 if in_r else 0.0
        n_o += with_
        n_a += 1.0 if in_a else 0.0
    return Sums(rx, ry, rz, ox, oy, oz, ax, ay, az, n_r, n_o, n_a)


@compiled
def weigh_zones(me, near, r_r, r_o, r_a, close_edge, far_edge, out):
    """1 for those that count: the zone of repulsion alone if anyone is in it, else the others."""
    n_r = zone_sums(me, near, r_r, r_o, r_a, close_edge, far_edge).n_r
    for j in range(near.n):
        dx, dy, dz = near.x[j] - me.x, near.y[j] - me.y, near.z[j] - me.z
        d = math.sqrt(dx * dx + dy * dy + dz * dz)
        along = dx * me.ux + dy * me.uy + dz * me.uz
        close = 0.0 < d < r_r and along >= close_edge * d
        far = r_r <= d <= max(r_o, r_a) and along >= far_edge * d
        out[j] = 1.0 if (close if n_r > 0.0 else far) else 0.0
