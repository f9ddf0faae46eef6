"""The heading of information agents: to the next waypoint of the mission's path."""

from __future__ import annotations

import math

from agents.engine.block import Decision
from worlds.compilation import compiled


@compiled
def offset_to_waypoint(surroundings, leg, me):
    """Vector from the agent to a waypoint, and its length."""
    dx = surroundings.path[leg, 0] - me.x
    dy = surroundings.path[leg, 1] - me.y
    dz = surroundings.path[leg, 2] - me.z
    return dx, dy, dz, math.sqrt(dx * dx + dy * dy + dz * dz)


@compiled
def waypoint_heading(flock, surroundings, i, me):
    """The heading theta^d of the information agent of row i, a unit Wish.

    To the waypoint of `flock.leg[i]`; within `surroundings.switch` of it the next one is taken.
    After the last waypoint, and in a world without a path, the heading stays as it is.
    """
    legs = surroundings.path.shape[0]
    leg = flock.leg[i]
    if leg < legs:
        dx, dy, dz, d = offset_to_waypoint(surroundings, leg, me)
        if d <= surroundings.switch:
            leg = (leg + 1) % legs if surroundings.closed else leg + 1
            flock.leg[i] = leg
            if leg < legs:
                dx, dy, dz, d = offset_to_waypoint(surroundings, leg, me)
        if leg < legs and d > 0.0:
            return Decision(dx / d, dy / d, dz / d)
    return Decision(me.ux, me.uy, me.uz)
