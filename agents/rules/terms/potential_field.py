"""The artificial potential field round obstacles of the thesis's model 2."""

from __future__ import annotations

import math

from worlds.compilation import compiled
from worlds.queries.surroundings import solids_around, surface

NEAREST = 0.05
"""An obstacle that is touched pushes as one at this distance does, length."""


@compiled
def obstacle_force(me, surroundings, p):
    """The sum of the forces of the obstacles ahead, (x, y, z), mass length/s^2.

    Each solid, walls among them, pushes from its nearest place with -grad U of (4.1): U =
    gain / 2 (1 / D - 1 / Q)^2 for D <= Q, where D is the distance from the body's skin. It counts
    if that place lies within 90 degrees of the heading. The print has +grad U, which would pull.
    """
    x = y = z = 0.0
    nearby = solids_around(surroundings, me.x, me.y)
    for k in range(nearby.number):
        at = surface(surroundings, nearby, k, me.x, me.y, me.z)
        d = max(at.distance - 0.5 * p.body, NEAREST)
        # The nearest place lies against the normal, which points away from the solid.
        is_ahead = at.nx * me.ux + at.ny * me.uy + at.nz * me.uz <= 0.0
        if at.distance < math.inf and (is_ahead or at.distance < 0.0) and d <= p.Q:
            force = p.gain * (1.0 / d - 1.0 / p.Q) / (d * d)
            x += force * at.nx
            y += force * at.ny
            z += force * at.nz
    return x, y, z


@compiled
def bend_around_obstacles(me, x, y, z, surroundings, p):
    """The velocity (4.2) of a wished direction (x, y, z) of length v0, bent by the field.

    v = v0 d + (tau / m) sum of forces; it is brought back to length v0, the speed being the body's.
    """
    fx, fy, fz = obstacle_force(me, surroundings, p)
    share = p.tau / p.m
    x, y, z = p.v0 * x + share * fx, p.v0 * y + share * fy, p.v0 * z + share * fz
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-12:
        return p.v0 * me.ux, p.v0 * me.uy, p.v0 * me.uz
    return p.v0 * x / length, p.v0 * y / length, p.v0 * z / length
