"""A body that always moves at the speed v0 along its heading (Liu et al. 2021 (7), (8))."""

from __future__ import annotations

from agents.engine.block import BodyMove
from agents.models.declare import Body, Parameters, parameter
from worlds.compilation import compiled


class ConstantSpeed(Parameters):
    """Parameters of the constant-speed body."""

    v0: float = parameter(
        0.03,
        "Distance that each agent moves per tick",
        words="Speed",
        symbol="v_0",
        unit="length/tick",
        low=0.0,
        high=1.0,
        step=0.005,
        source="Liu et al. 2021, (7)",
    )


@compiled
def move(me, near, surroundings, want, p, out):
    """x(k+1) = x(k) + v0 u(k+1): (7) and (8)."""
    return BodyMove(
        me.x + p.v0 * want.x,
        me.y + p.v0 * want.y,
        me.z + p.v0 * want.z,
        want.x,
        want.y,
        want.z,
        p.v0,
    )


BODY = Body(
    name="constant-speed",
    title="Constant speed",
    family="vicsek",
    source="Liu et al. 2021, (7), (8)",
    parameters=ConstantSpeed,
    move=move,
    speed=lambda p: p.v0,
    by_lanes=True,
)
