"""Steering without neighbours: around surfaces ahead, and to a goal (Reynolds 1999)."""

from __future__ import annotations

import math

from worlds.compilation import compiled
from worlds.queries.surroundings import nearest_surface

PROBES = 5
"""Points at which a boid looks for surfaces, evenly spaced from its own place to look_ahead."""
SLIGHT = 1e-6
"""A component of a unit vector that is as good as none: head-on if it is that across the heading,
along the surface if it is that of the heading along the normal."""


@compiled
def cut(x, y, z):
    """The vector, at most 1 long."""
    length = math.sqrt(x * x + y * y + z * z)
    share = 1.0 / length if length > 1.0 else 1.0
    return share * x, share * y, share * z


@compiled
def sideways(me):
    """A unit vector across the heading, to the left in the plan: where to turn when head-on."""
    length = math.sqrt(me.ux * me.ux + me.uy * me.uy)
    if length < SLIGHT:
        return 1.0, 0.0, 0.0
    return -me.uy / length, me.ux / length, 0.0


@compiled
def avoidance(me, surroundings, p):
    """Across the heading, away from the first surface that the way ahead comes too close to.

    The part of the surface normal across the heading (Reynolds 1999, containment), as a unit
    vector times an urgency that falls linearly with the distance of the probe; nothing where the
    way leads away from the surface.
    """
    for k in range(PROBES):
        way = p.look_ahead * k / (PROBES - 1)
        at = nearest_surface(
            surroundings, me.x + way * me.ux, me.y + way * me.uy, me.z + way * me.uz
        )
        towards = at.nx * me.ux + at.ny * me.uy + at.nz * me.uz
        if at.distance < p.clearance and towards <= SLIGHT:
            x, y, z = at.nx - towards * me.ux, at.ny - towards * me.uy, at.nz - towards * me.uz
            length = math.sqrt(x * x + y * y + z * z)
            urgency = 1.0 - k / PROBES
            if length < SLIGHT:
                x, y, z = sideways(me)
                length = 1.0
            return urgency * x / length, urgency * y / length, urgency * z / length
    return 0.0, 0.0, 0.0


@compiled
def seek(me, surroundings, p):
    """Towards the goal at full speed: the wanted change of velocity over max_speed, at most 1."""
    if surroundings.route.shape[0] == 0:
        return 0.0, 0.0, 0.0
    dx = surroundings.goal[0, 0] - me.x
    dy = surroundings.goal[0, 1] - me.y
    dz = surroundings.goal[0, 2] - me.z
    d = math.sqrt(dx * dx + dy * dy + dz * dz)
    d = d if d > 0.0 else 1.0
    v = me.speed / p.max_speed
    return cut(dx / d - v * me.ux, dy / d - v * me.uy, dz / d - v * me.uz)
