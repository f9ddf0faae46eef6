"""A particle in a fluid: it goes as it is driven, without inertia, and its heading diffuses.

Overdamped Langevin dynamics by the step of Euler and Maruyama. The noise is drawn from the run's
seed, tick and agent (`agents.engine.noise`), so it is the same for any number of threads.
"""

from __future__ import annotations

import math

from agents.engine.block import BodyMove
from agents.engine.noise import cos_sin, log, normal, uniform
from agents.models.declare import Body, Parameters, parameter
from worlds.compilation import compiled

TURN, KICK = 4, 6
"""Draws of the body's own noise: two for the heading, two for each axis of the position."""
SOURCE = "Bechinger et al. 2016, (1) to (4)"


class Brownian(Parameters):
    """Parameters of the Brownian body."""

    D_r: float = parameter(
        0.01,
        "Rotational diffusion: the heading is forgotten in 1 / D_r in the plane, 1 / (2 D_r) in "
        "space",
        words="Rotational diffusion",
        symbol="D_r",
        unit="rad^2/s",
        low=0.0,
        high=20.0,
        proposed=(0.001, 10.0),
        step=0.01,
        source=f"{SOURCE}; value chosen here",
        noise=True,
    )
    D_t: float = parameter(
        0.0,
        "Translational diffusion: kicks of the fluid",
        words="Translational diffusion",
        symbol="D_t",
        unit="length^2/s",
        low=0.0,
        high=20.0,
        step=0.001,
        source=f"{SOURCE}; value chosen here",
        noise=True,
    )
    dt: float = parameter(
        0.01,
        "Time of a tick",
        words="Time of a tick",
        symbol="\\Delta t",
        unit="s",
        low=0.0001,
        high=0.1,
        step=0.005,
        source="ours",
    )


@compiled
def diffuse_heading(me, s):
    """The heading after rotational diffusion, of deviation s (rad) about each axis across it.

    In the plane, the heading's and its own, by a normal angle; in space along a tangent whose two
    components are normal.
    """
    radius = math.sqrt(-2.0 * log(1.0 - uniform(me.key, me.id, TURN)))
    c, d = cos_sin(2.0 * math.pi * uniform(me.key, me.id, TURN + 1))
    if me.z == 0.0 and me.uz == 0.0:
        c, d = cos_sin(s * radius * c)
        return c * me.ux - d * me.uy, d * me.ux + c * me.uy, 0.0
    # An orthonormal pair across the heading, without a singular direction (Duff et al. 2017).
    sign = -1.0 if me.uz < 0.0 else 1.0
    a = -1.0 / (sign + me.uz)
    b = me.ux * me.uy * a
    tx = c * (1.0 + sign * me.ux * me.ux * a) + d * b
    ty = c * sign * b + d * (sign + me.uy * me.uy * a)
    tz = -c * sign * me.ux - d * me.uy
    along, sideways = cos_sin(s * radius)
    return (
        along * me.ux + sideways * tx,
        along * me.uy + sideways * ty,
        along * me.uz + sideways * tz,
    )


@compiled
def move(me, near, surroundings, want, p, out):
    """x += dt v + sqrt(2 D_t dt) xi, and the heading turns by sqrt(2 D_r dt) xi."""
    x, y, z = me.x + p.dt * want.x, me.y + p.dt * want.y, me.z + p.dt * want.z
    if p.D_t > 0.0:
        kick = math.sqrt(2.0 * p.D_t * p.dt)
        x += kick * normal(me.key, me.id, KICK)
        y += kick * normal(me.key, me.id, KICK + 2)
        if me.z != 0.0 or me.uz != 0.0:
            z += kick * normal(me.key, me.id, KICK + 4)
    ux, uy, uz = me.ux, me.uy, me.uz
    if p.D_r > 0.0:
        ux, uy, uz = diffuse_heading(me, math.sqrt(2.0 * p.D_r * p.dt))
        length = math.sqrt(ux * ux + uy * uy + uz * uz)
        ux, uy, uz = ux / length, uy / length, uz / length
    speed = math.sqrt(want.x * want.x + want.y * want.y + want.z * want.z)
    return BodyMove(x, y, z, ux, uy, uz, speed)


BODY = Body(
    name="brownian",
    title="Brownian particle",
    source=SOURCE,
    parameters=Brownian,
    move=move,
    takes="velocity",
    lasts=lambda p: p.dt,
    unit="s",
)
