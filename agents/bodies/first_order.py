"""A body without inertia: it moves at the velocity that its rule wishes, x' = v.

The step is that of Euler: places at which nobody moves are those of the differential equation, for
any length of a tick. Where wishes grow without bound as two come near each other, a step can throw
them apart: FASTEST is a number that can be seen to be wrong, instead of no number.
"""

from __future__ import annotations

import math

from agents.engine.block import BodyMove
from agents.models.declare import Body, Parameters, parameter
from worlds.compilation import compiled

FASTEST = 1e4
"""Largest speed of one without a limit of its own, length/s."""


class FirstOrder(Parameters):
    """Parameters of the body without inertia."""

    dt: float = parameter(
        0.01,
        "Time of a tick",
        words="Time of a tick",
        symbol="\\Delta t",
        unit="s",
        low=0.0001,
        high=1.0,
        proposed=(0.001, 0.05),
        step=0.001,
        source="ours",
    )
    v_max: float = parameter(
        0.0,
        f"Largest speed; 0: none, and {FASTEST:g} length/s shows that two came too near each other "
        "for the step",
        words="Largest speed",
        symbol="v_{max}",
        unit="length/s",
        low=0.0,
        high=1000.0,
        step=0.1,
        source="ours",
    )


@compiled
def move(me, near, surroundings, want, p, out):
    """x += dt v, |v| <= v_max where that is set; it looks where it goes, and at rest as before."""
    speed = math.sqrt(want.x * want.x + want.y * want.y + want.z * want.z)
    if speed == 0.0:
        return BodyMove(me.x, me.y, me.z, me.ux, me.uy, me.uz, 0.0)
    ux, uy, uz = want.x / speed, want.y / speed, want.z / speed
    speed = min(speed, p.v_max if p.v_max > 0.0 else FASTEST)
    step_length = p.dt * speed
    return BodyMove(
        me.x + step_length * ux, me.y + step_length * uy, me.z + step_length * uz, ux, uy, uz, speed
    )


BODY = Body(
    name="first-order",
    title="Body without inertia",
    source="the velocity is what the rule wishes",
    parameters=FirstOrder,
    move=move,
    takes="velocity",
    stride=lambda p: p.v_max * p.dt,
    lasts=lambda p: p.dt,
    unit="s",
)
