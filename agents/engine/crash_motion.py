"""Crashes: an agent that touches something falls, and lies where it comes to rest."""

from __future__ import annotations

import math

from worlds.compilation import compiled
from worlds.queries.surroundings import signed_distance

GRAVITY = 9.81
"""Acceleration of free fall, length/s^2."""


@compiled
def crash(flock, i, tick, cause):
    """Note when, by touching what and where the agent of row i crashed; it stops there."""
    flock.crash_record[i, 0] = tick
    flock.crash_record[i, 1] = cause
    for axis in range(flock.position.shape[1]):
        flock.crash_record[i, 2 + axis] = flock.position[i, axis]
    flock.speed[i] = 0.0


@compiled
def fall(flock, space, surroundings, i, lasts):
    """Free fall for a tick, to the floor or to what is solid below; nothing in two dimensions.

    `flock.speed` is the speed of the fall, and 0 for one that lies.
    """
    if flock.position.shape[1] == 2:
        return
    x, y, z = flock.position[i, 0], flock.position[i, 1], flock.position[i, 2]
    speed = flock.speed[i] + GRAVITY * lasts
    below = max(z - speed * lasts, min(z, space.floor))
    rests = below <= space.floor
    if surroundings.solids > 0 and signed_distance(surroundings, x, y, below) < 0.0:
        # It sinks into a block at most as far as a crash has brought it there.
        clear = signed_distance(surroundings, x, y, z) >= 0.0
        below = resting(surroundings, x, y, z, below) if clear else below
        rests = rests or clear
    flock.position[i, 2] = below
    flock.speed[i] = 0.0 if rests else speed


@compiled
def resting(surroundings, x, y, high, low):
    """The least height, from `high` down to `low`, at which nothing solid is entered yet."""
    while high - low > 1e-3 * (1.0 + math.fabs(high)):
        middle = 0.5 * (high + low)
        if signed_distance(surroundings, x, y, middle) < 0.0:
            low = middle
        else:
            high = middle
    return high
