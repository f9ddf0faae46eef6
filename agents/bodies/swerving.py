"""A body of constant speed that an acceleration turns: what is along its heading does nothing."""

from __future__ import annotations

import math

from agents.engine.block import BodyMove
from agents.engine.noise import cos_sin
from agents.engine.vector_lanes import where
from agents.models.declare import Body, Parameters, parameter
from worlds.compilation import compiled


class SwervingBody(Parameters):
    """Parameters of the swerving body."""

    v0: float = parameter(
        1.0,
        "Speed of every agent",
        words="Speed",
        symbol="v_0",
        unit="length/s",
        low=0.000001,
        high=100.0,
        step=0.1,
        source="Cavagna et al. 2015; value ours",
    )
    dt: float = parameter(
        0.05,
        "Time of a tick",
        words="Time of a tick",
        symbol="\\Delta t",
        unit="s",
        low=0.0001,
        high=1.0,
        step=0.01,
        source="ours",
    )


@compiled
def move(me, near, surroundings, want, p, out):
    """dv/dt = a across the heading: u turns towards it by |a| dt / v_0, then x += dt v_0 u."""
    along = want.x * me.ux + want.y * me.uy + want.z * me.uz
    ax, ay, az = want.x - along * me.ux, want.y - along * me.uy, want.z - along * me.uz
    a = math.sqrt(ax * ax + ay * ay + az * az)
    c, s = cos_sin(a * p.dt / p.v0)
    s = s / where(a == 0.0, 1.0, a)
    ux, uy, uz = c * me.ux + s * ax, c * me.uy + s * ay, c * me.uz + s * az
    length = math.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux / length, uy / length, uz / length
    step_length = p.v0 * p.dt
    return BodyMove(
        me.x + step_length * ux, me.y + step_length * uy, me.z + step_length * uz, ux, uy, uz, p.v0
    )


def begins(p, chance):
    """The speed, v_0."""
    return p.v0


BODY = Body(
    name="swerving",
    title="Constant speed under an acceleration",
    source="Cavagna et al. 2015, |v| = v_0",
    parameters=SwervingBody,
    move=move,
    by_lanes=True,
    takes="acceleration",
    begins=begins,
    lasts=lambda p: p.dt,
    unit="s",
)
