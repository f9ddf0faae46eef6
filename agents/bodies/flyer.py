"""A flapping-wing aircraft as a point with limits: it turns and gains speed only so fast.

Its body is a ball that crashes where it touches another, a block or a wall (thesis, section 5).
"""

from __future__ import annotations

import math
from typing import Literal

from agents.bodies.turning import turn_towards
from agents.bodies.upwash import drag_saving
from agents.engine.block import BodyMove
from agents.models.declare import Body, Parameters, parameter
from worlds.compilation import compiled
from worlds.queries.crossing import skin
from worlds.queries.surroundings import signed_distance

ALWAYS = 0.0
"""`contact` as compiled code has it."""


class Flyer(Parameters):
    """Parameters of the flapping-wing aircraft."""

    v0: float = parameter(
        3.0,
        "Cruise speed, which an agent takes where its rule asks for no other",
        words="Cruise speed",
        symbol="v_0",
        unit="length/s",
        low=0.0,
        high=20.0,
        proposed=(0.0, 10.0),
        step=0.1,
        source="thesis, table 5.1 (V_max)",
    )
    v_min: float = parameter(
        0.0,
        "Least speed",
        words="Least speed",
        symbol="v_{min}",
        unit="length/s",
        low=0.0,
        high=20.0,
        proposed=(0.0, 10.0),
        step=0.1,
        source="ours: the thesis has none",
    )
    v_max: float = parameter(
        3.0,
        "Largest speed",
        words="Largest speed",
        symbol="V_{max}",
        unit="length/s",
        low=0.0,
        high=20.0,
        proposed=(0.0, 10.0),
        step=0.1,
        source="thesis, table 5.1",
    )
    a_max: float = parameter(
        1.0,
        "Largest gain or loss of speed",
        words="Largest acceleration",
        symbol="a_{max}",
        unit="length/s^2",
        low=0.0,
        high=50.0,
        step=0.1,
        source="thesis, table 5.1",
    )
    theta_max: float = parameter(
        120.0,
        "Turning rate: how far an agent can turn in a second",
        words="Turning rate",
        symbol="\\theta_{max}",
        unit="deg/s",
        low=1.0,
        high=1800.0,
        proposed=(10.0, 500.0),
        step=5.0,
        source="thesis, table 5.1, taken per second",
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
        source="thesis, algorithm 1; found from its figures",
    )
    body: float = parameter(
        0.75,
        "Diameter of the body, a ball; bodies that touch crash",
        words="Diameter of the body",
        symbol="d_b",
        unit="length",
        low=0.0,
        high=5.0,
        proposed=(0.0, 3.0),
        step=0.05,
        source="thesis, table 5.1",
    )
    contact: Literal["always", "start"] = parameter(
        "always",
        "Whether bodies are solid all the time, or only looked at as the run starts",
        words="Contact",
        symbol="contact",
        source="thesis, section 5.3: it counts crashes at tick 0 only",
    )
    d_0: float = parameter(
        0.0,
        "At the start, distance below which two agents cannot get out of each other's way: they "
        "crash at once",
        words="Distance of the first crashes",
        symbol="d_0",
        unit="length",
        low=0.0,
        high=10.0,
        proposed=(0.0, 5.0),
        step=0.1,
        source="thesis, section 5.3.2, without a value; 2 gives the crashes of its tables",
    )
    b: float = parameter(
        0.75,
        "Wing span, which sets the vortices behind an agent",
        words="Wing span",
        symbol="b",
        unit="length",
        low=0.05,
        high=10.0,
        proposed=(0.05, 4.0),
        step=0.05,
        source="ours: the body of table 5.1 is as wide",
    )


@compiled
def move(me, near, surroundings, want, p, out):
    """Turn by at most theta_max tau towards the wanted velocity, take its speed within a_max tau.

    Then go on along the new heading for tau. (0, 0, 0) keeps the heading and aims at v0.
    """
    wanted_speed = math.sqrt(want.x * want.x + want.y * want.y + want.z * want.z)
    ux, uy, uz = me.ux, me.uy, me.uz
    if wanted_speed > 1e-12:
        turn_limit = math.radians(p.theta_max) * p.tau
        ux, uy, uz = turn_towards(
            ux,
            uy,
            uz,
            want.x / wanted_speed,
            want.y / wanted_speed,
            want.z / wanted_speed,
            turn_limit,
        )
        length = math.sqrt(ux * ux + uy * uy + uz * uz)
        ux, uy, uz = ux / length, uy / length, uz / length
    else:
        wanted_speed = p.v0
    aim = max(min(wanted_speed, p.v_max), p.v_min)
    step = p.a_max * p.tau
    speed = me.speed + min(max(aim - me.speed, -step), step)
    d = speed * p.tau
    return BodyMove(me.x + d * ux, me.y + d * uy, me.z + d * uz, ux, uy, uz, speed)


@compiled
def touches(me, near, surroundings, p):
    """1.0 if the body touches another, 2.0 if it touches a block or a wall, else 0.0.

    At no distance stands the agent itself; whoever else does touches it.
    """
    if p.contact != ALWAYS and me.tick > 0:
        return 0.0
    nearest2 = math.inf
    agents_here = 0
    for j in range(near.n):
        dx = near.x[j] - me.x
        dy = near.y[j] - me.y
        dz = near.z[j] - me.z
        d2 = dx * dx + dy * dy + dz * dz
        nearest2 = min(nearest2, d2 if d2 > 0.0 else math.inf)
        agents_here += 0 if d2 > 0.0 else 1
    crash_distance = max(p.body, p.d_0) if me.tick == 0 else p.body
    if agents_here > 1 or nearest2 <= crash_distance * crash_distance:
        return 1.0
    touching_distance = 0.5 * p.body + 2.0 * skin(me.x, me.y, me.z)
    if (
        surroundings.solids > 0
        and signed_distance(surroundings, me.x, me.y, me.z) <= touching_distance
    ):
        return 2.0
    return 0.0


@compiled
def measure(me, near, p, out):
    """The share of its induced drag that the agent saves by the others' upwash."""
    out[0] = drag_saving(me, near, p.b)


def begins(p, chance):
    """A random speed, uniform from the least to the cruise speed (thesis, section 4.1)."""
    slowest = min(p.v_min, p.v0)
    return slowest + (p.v0 - slowest) * chance


@compiled
def passes(p):
    """Whether it goes through blocks and walls: bodies are only looked at as a run starts."""
    return p.contact != ALWAYS


FLYER = Body(
    name="flyer",
    title="Flapping-wing aircraft",
    source="thesis, section 3.2 and table 5.1",
    parameters=Flyer,
    move=move,
    takes="velocity",
    size="body",
    touches=touches,
    measures=("saved",),
    words={"saved": "drag saved"},
    measure=measure,
    begins=begins,
    stops=True,
    passes=passes,
    passes_with="contact = start",
    sight="sight",
    lasts=lambda p: p.tau,
    unit="s",
    family="aircraft",
)
