"""A body that goes at constant speed and turns no faster than it can (Couzin et al. 2002)."""

from __future__ import annotations

import math

from agents.engine.block import BodyMove
from agents.engine.noise import cos_sin
from agents.engine.vector_lanes import where
from agents.models.declare import Body, Parameters, parameter
from worlds.compilation import compiled


class TurningBody(Parameters):
    """Parameters of the turning body."""

    s: float = parameter(
        3.0,
        "Speed of every agent",
        words="Speed",
        symbol="s",
        unit="length/s",
        low=0.0,
        high=20.0,
        proposed=(0.0, 10.0),
        step=0.1,
        source="Couzin et al. 2002, table 1",
    )
    theta: float = parameter(
        40.0,
        "Turning rate: how far an agent can turn in a second",
        words="Turning rate",
        symbol="\\theta",
        unit="deg/s",
        low=1.0,
        high=1800.0,
        step=1.0,
        source="Couzin et al. 2002, table 1",
    )
    tau: float = parameter(
        0.1,
        "Time that a tick lasts",
        words="Time of a tick",
        symbol="\\tau",
        unit="s",
        low=0.01,
        high=1.0,
        step=0.01,
        source="Couzin et al. 2002, table 1",
    )


@compiled
def turn_towards(ux, uy, uz, x, y, z, turn_limit):
    """The heading u turned towards the direction (x, y, z), both unit vectors, by at most a limit.

    The limit is in rad. A direction straight behind has no shorter side: it is turned to the left,
    or about the vertical.
    """
    c, s = cos_sin(min(turn_limit, math.pi))
    along = ux * x + uy * y + uz * z
    ax, ay, az = x - along * ux, y - along * uy, z - along * uz
    length = math.sqrt(ax * ax + ay * ay + az * az)
    is_behind = length < 1e-9
    level = math.sqrt(ux * ux + uy * uy)
    upright = level < 1e-9
    ax = where(is_behind, where(upright, 1.0, -uy), ax)
    ay = where(is_behind, where(upright, 0.0, ux), ay)
    az = where(is_behind, 0.0, az)
    s = s / where(is_behind, where(upright, 1.0, level), length)
    within = along >= c
    return (
        where(within, x, c * ux + s * ax),
        where(within, y, c * uy + s * ay),
        where(within, z, c * uz + s * az),
    )


@compiled
def move(me, near, surroundings, want, p, out):
    """Turn by at most theta tau towards the wanted heading, then go s tau along the new one."""
    turn_limit = math.radians(p.theta) * p.tau
    ux, uy, uz = turn_towards(me.ux, me.uy, me.uz, want.x, want.y, want.z, turn_limit)
    length = math.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux / length, uy / length, uz / length
    d = p.s * p.tau
    return BodyMove(me.x + d * ux, me.y + d * uy, me.z + d * uz, ux, uy, uz, p.s)


BODY = Body(
    name="turning",
    title="Constant speed, limited turning rate",
    source="Couzin et al. 2002",
    parameters=TurningBody,
    move=move,
    speed=lambda p: p.s,
    by_lanes=True,
    lasts=lambda p: p.tau,
    unit="s",
)
