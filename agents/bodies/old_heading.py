"""A body that moves along the heading it had, and then takes the new one (Vicsek et al. 1995, (1)).

The backward update: of two agents that turn now, the turn is seen in their ways a tick later. Liu
et al. 2021 (7), (8) and Grégoire and Chaté 2004 update forward: `agents.bodies.constant_speed`.
"""

from __future__ import annotations

from agents.engine.block import BodyMove
from agents.models.declare import Body, Parameters, parameter
from worlds.compilation import compiled


class OldHeading(Parameters):
    """Parameters of the body that moves along its old heading."""

    v0: float = parameter(
        0.03,
        "Distance that each agent moves per tick",
        words="Speed",
        symbol="v_0",
        unit="length/tick",
        low=0.0,
        high=1.0,
        step=0.005,
        source="Vicsek et al. 1995, (1)",
    )


@compiled
def move(me, near, surroundings, want, p, out):
    """x(t + 1) = x(t) + v u(t): (1); the heading is the new one."""
    return BodyMove(
        me.x + p.v0 * me.ux,
        me.y + p.v0 * me.uy,
        me.z + p.v0 * me.uz,
        want.x,
        want.y,
        want.z,
        p.v0,
    )


BODY = Body(
    name="old-heading",
    title="Constant speed, along the old heading",
    family="vicsek",
    source="Vicsek et al. 1995, (1)",
    parameters=OldHeading,
    move=move,
    speed=lambda p: p.v0,
    by_lanes=True,
)
