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
        d = math.sqrt(d2) if d2 > 0.0 else 1.0
        dx, dy, dz = dx / d, dy / d, dz / d
        along = dx * me.ux + dy * me.uy + dz * me.uz
        close = (d2 > 0.0) & (d < r_r)
        far = (d2 > 0.0) & (d >= r_r) & (along >= far_edge)
        in_r = 1.0 if close & (along >= close_edge) else 0.0
        in_o = 1.0 if far & (d < r_o) else 0.0
        in_a = 1.0 if far & (d >= r_o) & (d <= r_a) else 0.0
        rx -= in_r * dx
        ry -= in_r * dy
        rz -= in_r * dz
        ox += in_o * near.ux[j]
        oy += in_o * near.uy[j]
        oz += in_o * near.uz[j]
        ax += in_a * dx
        ay += in_a * dy
        az += in_a * dz
        n_r += in_r
        n_o += in_o
        n_a += in_a
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
