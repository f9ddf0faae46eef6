"""Agents whose rule does not see what is solid bounce off it, as light does off a mirror."""

from __future__ import annotations

from worlds.ground import nearest_surface

from agents.engine.block import Moved
from worlds.compiled import compiled

REFLECTIONS = 3
"""Surfaces that an agent may meet within one tick, as in a corner."""


@compiled
def bounced(ground, moved):
    """The move, mirrored at each surface that it has gone through."""
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
    return Moved(x, y, z, ux, uy, uz, moved.speed)
