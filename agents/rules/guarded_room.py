"""The room that an agent keeps for itself: the ball in which it could circle for ever.

An agent that cannot stop can circle: it turns by theta_max every tick at its present speed, round a
centre that stays. Its *room* is the ball round that centre that holds the circle and the body. It
tells the others where that is. Rooms that do not overlap are kept apart by the plane halfway between
their surfaces; an agent only makes a step after which its next room lies on its own side of the
planes to all others, and clear of what is solid. As all others do the same, the next rooms do not
overlap either, even if all decide at once; and as going on in the circle leaves the room where it
is, there always is such a step. So no two bodies ever touch. Planes that share the space are those
of buffered Voronoi cells (Zhou et al. 2017, IEEE RA-L 2, 1047); an escape that is kept free is the
fastest way known to a proof (Schouwenaars et al. 2004).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from worlds.compiled import compiled
from worlds.ground import signed_distance

CENTRE_X, CENTRE_Y, CENTRE_Z, RADIUS = 0, 1, 2, 3
"""Rows of `near.signal`: from an agent to the centre of its circle, and the circle's radius."""
SKIN = 0.01
"""What a room is wider than circle and body, length."""
ENOUGH = 1e-9
"""An overlap that rounding may make, length."""


class Room(NamedTuple):
    """A circle that an agent could fly: its centre and radius, length."""

    x: float
    y: float
    z: float
    radius: float


@compiled
def circle_radius(speed, p):
    """Radius of the circle of positions that a turn by theta_max at a speed goes through, length.

    Positions are the corners of a polygon with sides speed * tau that turn by theta_max tau.
    """
    return 0.5 * speed * p.tau / math.sin(0.5 * math.radians(p.theta_max) * p.tau)


@compiled
def circle(x, y, z, ux, uy, uz, speed, nx, ny, nz, p):
    """The circle from a place with a heading u and a speed, turning towards the unit vector n.

    n is at right angles to u. The step that comes next is turned already, so the centre lies back
    from n by half a turn.
    """
    half = 0.5 * math.radians(p.theta_max) * p.tau
    r = circle_radius(speed, p)
    c, s = r * math.cos(half), r * math.sin(half)
    return Room(x + c * nx - s * ux, y + c * ny - s * uy, z + c * nz - s * uz, r)


@compiled
def overlap(me, near, ground, own, then, p):
    """By how much the room `then` oversteps the planes round the room `own`, and solids; length.

    The sum over all others within reach and the nearest surface; 0 means: the step is safe.
    """
    reach2 = p.range * p.range
    grown = then.radius - own.radius
    vx, vy, vz = then.x - own.x, then.y - own.y, then.z - own.z
    signal = near.signal
    # Both bodies, with their skins.
    apart = own.radius + p.body + 2.0 * SKIN
    total = 0.0
    for j in range(near.n):
        dx = near.x[j] - me.x
        dy = near.y[j] - me.y
        dz = near.z[j] - me.z
        d2 = dx * dx + dy * dy + dz * dz
        ex = near.x[j] + signal[CENTRE_X, j] - own.x
        ey = near.y[j] + signal[CENTRE_Y, j] - own.y
        ez = near.z[j] + signal[CENTRE_Z, j] - own.z
        e2 = ex * ex + ey * ey + ez * ez
        e = math.sqrt(e2) if e2 > 0.0 else 1.0
        gap = e - apart - signal[RADIUS, j]
        over = (vx * ex + vy * ey + vz * ez) / e + grown - 0.5 * gap
        total += over if (d2 > 0.0) & (d2 <= reach2) & (over > ENOUGH) else 0.0
    clear = signed_distance(ground, then.x, then.y, then.z) - then.radius - 0.5 * p.body - SKIN
    return total + (-clear if clear < -ENOUGH else 0.0)
