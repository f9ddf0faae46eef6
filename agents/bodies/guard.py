"""The guard takes out of a velocity the part that would lead an agent into an obstacle."""

from __future__ import annotations

import math

from worlds.compilation import compiled
from worlds.queries.surroundings import nearest_surface

LEAST = 0.01
"""Share of the range that an agent must keep to the next surface; else it stays where it is."""


@compiled
def limit_inward_speed(at, vx, vy, vz, allowed):
    """The velocity with at most the speed `allowed` towards the surface."""
    over = min(0.0, vx * at.nx + vy * at.ny + vz * at.nz + allowed)
    return vx - over * at.nx, vy - over * at.ny, vz - over * at.nz


@compiled
def guard_velocity(surroundings, at, me, vx, vy, vz, reach):
    """The velocity (length/tick) of an agent whose nearest surface is `at`, within `reach`.

    Up to reach / 2 from the surface no velocity towards it is left; further out at most half the
    distance per tick. Where the step would end at another surface, as in a corner, what leads there
    is taken out too, and a step that even so ends in the solid is not made.
    """
    allowed = 0.0 if at.distance <= 0.5 * reach else 0.5 * at.distance
    vx, vy, vz = limit_inward_speed(at, vx, vy, vz, allowed)
    least_distance = min(at.distance, LEAST * reach)
    if at.distance - math.sqrt(vx * vx + vy * vy + vz * vz) >= least_distance:
        return vx, vy, vz
    next_surface = nearest_surface(surroundings, me.x + vx, me.y + vy, me.z + vz)
    if next_surface.distance < least_distance:
        vx, vy, vz = limit_inward_speed(next_surface, vx, vy, vz, 0.0)
        next_surface = nearest_surface(surroundings, me.x + vx, me.y + vy, me.z + vz)
        if next_surface.distance < least_distance:
            return 0.0, 0.0, 0.0
    return vx, vy, vz
