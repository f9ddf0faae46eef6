"""A point mass: Newton's second law and nothing else, but for a largest speed if one is set.

The velocity changes first and the position follows it (semi-implicit Euler), so that a flock under
forces that come from a potential keeps its energy over long runs. A step that is too long for its
forces makes it swing up: it then stays at FASTEST, a number that can be seen to be wrong, instead
of running off to no number.
"""

from __future__ import annotations

import math

import numpy as np

from agents.engine.block import BodyMove
from agents.models.declare import Body, Parameters, parameter
from worlds.compilation import compiled

FASTEST = 1e4
"""Speed of a point mass without a largest speed whose step is too long for its forces, m/s."""


class PointMass(Parameters):
    """Parameters of the point mass."""

    m: float = parameter(
        1.0,
        "Mass: what the wished force is divided by",
        words="Mass",
        symbol="m",
        unit="kg",
        low=0.001,
        high=1000.0,
        step=0.1,
        source="Newton's second law",
    )
    dt: float = parameter(
        0.01,
        "Time of a tick",
        words="Time of a tick",
        symbol="\\Delta t",
        unit="s",
        low=0.0001,
        high=1.0,
        step=0.01,
        source="ours",
    )
    v_max: float = parameter(
        0.0,
        f"Largest speed; 0: none, and {FASTEST:g} m/s shows that dt is too long for the forces",
        words="Largest speed",
        symbol="v_{max}",
        unit="m/s",
        low=0.0,
        high=1000.0,
        step=0.1,
        source="ours",
    )
    v_start: float = parameter(
        0.0,
        "Largest speed at the start, in any direction; 0: at rest",
        words="Speed at the start",
        symbol="v_{start}",
        unit="m/s",
        low=0.0,
        high=1000.0,
        step=0.1,
        source="ours",
    )


def begins(p, chance):
    """The speed of a velocity that is uniform in the disc of radius v_start, m/s."""
    return p.v_start * np.sqrt(chance)


@compiled
def move(me, near, surroundings, want, p, out):
    """v += dt F / m, |v| <= v_max where that is set, x += dt v. At rest the heading is kept."""
    h = p.dt / p.m
    vx = me.speed * me.ux + h * want.x
    vy = me.speed * me.uy + h * want.y
    vz = me.speed * me.uz + h * want.z
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    if speed == 0.0:
        return BodyMove(me.x, me.y, me.z, me.ux, me.uy, me.uz, 0.0)
    ux, uy, uz = vx / speed, vy / speed, vz / speed
    speed = min(speed, p.v_max if p.v_max > 0.0 else FASTEST)
    step_length = p.dt * speed
    return BodyMove(
        me.x + step_length * ux, me.y + step_length * uy, me.z + step_length * uz, ux, uy, uz, speed
    )


BODY = Body(
    name="point-mass",
    title="Point mass",
    source="Newton's second law",
    parameters=PointMass,
    move=move,
    takes="acceleration",
    begins=begins,
    stride=lambda p: p.v_max * p.dt,
    lasts=lambda p: p.dt,
    unit="s",
)
