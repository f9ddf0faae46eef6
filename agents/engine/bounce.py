"""Agents whose rule does not see what is solid bounce off it, as light does off a mirror."""

from __future__ import annotations

from agents.engine.block import Moved
from worlds.compiled import compiled
from worlds.ground import nearest_surface, signed_distance

REFLECTIONS = 3
"""Surfaces that an agent may meet within one tick, as in a corner."""


@compiled
def bounced(ground, me, moved):
    """The move, mirrored at each surface that it has gone through.

    An agent that a narrow corner still holds then goes back to where it was and turns round.
    """
    x, y, z, ux, uy, uz = moved.x, moved.y, moved.z, moved.ux, moved.uy, moved.uz
    for _ in range(REFLECTIONS):
        at = nearest_surface(ground, x, y, z)
        if at.distance < 0.0:
            x -= 2.0 * at.distance * at.nx
            y -= 2.0 * at.distance * at.ny
            z -= 2.0 * at.distance * at.nz
            inward = min(0.0, ux * at.nx + uy * at.ny + uz * at.nz)
            ux -= 2.0 * inward * at.nx
            uy -= 2.0 * inward * at.ny
            uz -= 2.0 * inward * at.nz
    if signed_distance(ground, x, y, z) < 0.0:
        return Moved(me.x, me.y, me.z, -moved.ux, -moved.uy, -moved.uz, 0.0)
    return Moved(x, y, z, ux, uy, uz, moved.speed)
