"""A car that turns on the spot: it is displaced by as much as the rule wishes.

The Matlab simulation of Jacobs and Koessler, section III.A: "at each time step a car is displaced
by some delta proportionate to D".
"""

from __future__ import annotations

import math

from agents.bodies.tracking import Tracking
from agents.engine.block import BodyMove
from agents.models.declare import Body, Vehicle, parameter
from worlds.compilation import compiled


class ZeroTurn(Tracking):
    """Parameters of the car that turns on the spot."""

    gain: float = parameter(
        1.0,
        "Speed for each unit of the wish",
        words="Gain of the speed",
        symbol="g",
        unit="m/s",
        low=0.0,
        high=20.0,
        step=0.05,
        source="Jacobs and Koessler III.A, which gives no value",
    )


@compiled
def move(me, near, surroundings, want, p, out):
    """x(t + dt) = x(t) + g D dt; it looks where it goes, and keeps its heading at rest."""
    d = p.gain * p.dt
    x, y = me.x + d * want.x, me.y + d * want.y
    length = math.sqrt(want.x * want.x + want.y * want.y)
    if length < 1e-12:
        return BodyMove(x, y, me.z, me.ux, me.uy, me.uz, 0.0)
    return BodyMove(x, y, me.z, want.x / length, want.y / length, 0.0, p.gain * length)


BODY = Body(
    name="zero-turn",
    title="Car that turns on the spot",
    source="Jacobs and Koessler, section III.A",
    parameters=ZeroTurn,
    move=move,
    takes="velocity",
    lasts=lambda p: p.dt,
    unit="s",
    vehicle=Vehicle(),
)
