"""How information agents find their way: waypoint after waypoint along the mission's path."""

from __future__ import annotations

import math

from agents.engine.block import Wish
from worlds.compiled import compiled


@compiled
def apart(ground, leg, me):
    """Vector from the agent to a waypoint, and its length."""
    dx = ground.path[leg, 0] - me.x
    dy = ground.path[leg, 1] - me.y
    dz = ground.path[leg, 2] - me.z
    return dx, dy, dz, math.sqrt(dx * dx + dy * dy + dz * dz)


@compiled
def guided(flock, ground, i, me):
    """The heading theta^d of the information agent of row i, a unit Wish.

    To the waypoint of `flock.leg[i]`; within `ground.switch` of it the next one is taken. After the
    last waypoint, and in a world without a path, the heading stays as it is.
    """
    legs = ground.path.shape[0]
    leg = flock.leg[i]
    if leg < legs:
        dx, dy, dz, d = apart(ground, leg, me)
        if d <= ground.switch:
            leg = (leg + 1) % legs if ground.closed else leg + 1
            flock.leg[i] = leg
            if leg < legs:
                dx, dy, dz, d = apart(ground, leg, me)
        if leg < legs and d > 0.0:
            return Wish(dx / d, dy / d, dz / d)
    return Wish(me.ux, me.uy, me.uz)
