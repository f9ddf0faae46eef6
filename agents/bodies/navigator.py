"""A UAV that keeps its distance to others and flies along obstacles (Liu et al. 2021, 2.3, 2.4).

It carries out the heading that a rule of the Vicsek family wants: along the tangent of an obstacle
in its way, with repulsion and attraction between neighbours. The printed composition (25) of the
velocity leaves out that an obstacle is solid and takes agents into it; `guard` adds that.
"""

from __future__ import annotations

import math

from agents.bodies.guard import guard_velocity
from agents.engine.block import BodyMove, Decision
from agents.models.declare import Body, Parameters, Rule, parameter
from agents.models.model import Model
from agents.models.tries import LessonCheck, LessonStep
from worlds.compilation import compiled
from worlds.queries.surroundings import surface_within

HEARD, AVOIDS = 1.0, 0.0
"""The body's signal o_i (19): whether its heading counts for its neighbours."""


class Navigator(Parameters):
    """Parameters of the navigating body."""

    v0: float = parameter(
        0.1,
        "Speed at which agents follow their heading, and the largest speed",
        words="Speed",
        symbol="v_0",
        unit="length/tick",
        low=0.0,
        high=1.0,
        step=0.005,
        source="Liu et al. 2021, (7), (26)",
    )
    c_align: float = parameter(
        1.0,
        "Weight of the wanted heading in the velocity",
        words="Weight of the heading",
        symbol="c^{align}",
        low=0.0,
        high=5.0,
        step=0.05,
        source="Liu et al. 2021, (25)",
    )
    c_rep: float = parameter(
        0.1,
        "Weight of the repulsion from neighbours within r_rep",
        words="Weight of the repulsion",
        symbol="c^{rep}",
        unit="length/tick",
        low=0.0,
        high=1.0,
        step=0.005,
        source="Liu et al. 2021, (25)",
    )
    r_rep: float = parameter(
        0.7,
        "Distance within which neighbours repel each other",
        words="Radius of the repulsion",
        symbol="r_{rep}",
        unit="length",
        low=0.01,
        high=5.0,
        proposed=(0.05, 2.0),
        step=0.05,
        source="Liu et al. 2021, (24)",
    )
    c_att: float = parameter(
        0.003,
        "Weight of the attraction to neighbours between r_rep and r_att",
        words="Weight of the attraction",
        symbol="c^{att}",
        unit="length/tick",
        low=0.0,
        high=1.0,
        proposed=(0.0002, 0.2),
        step=0.001,
        source="Liu et al. 2021, (25)",
    )
    r_att: float = parameter(
        1.0,
        "Distance within which neighbours attract each other; r is the most that counts",
        words="Radius of the attraction",
        symbol="r_{att}",
        unit="length",
        low=0.02,
        high=5.0,
        proposed=(0.05, 3.0),
        step=0.05,
        source="Liu et al. 2021, (23)",
    )
    r_avoid: float = parameter(
        0.5,
        "Distance at which an obstacle is noticed",
        words="Sight of obstacles",
        symbol="r_{avoid}",
        unit="length",
        low=0.05,
        high=2.0,
        step=0.05,
        source="Liu et al. 2021, (20)",
    )
    theta_obstruct: float = parameter(
        round(11.0 * math.pi / 20.0, 4),
        "An obstacle is in the way if it lies within this angle of the wanted heading",
        words="Angle that counts as ahead",
        symbol="\\theta_{obstruct}",
        unit="rad",
        low=0.0,
        high=round(math.pi, 4),
        step=0.05,
        source="Liu et al. 2021, (21)",
    )
    guard: bool = parameter(
        True,
        "Whether the velocity towards an obstacle is taken out or capped close to it, so that no "
        "agent enters it; off is the paper's literal text",
        words="Guard",
        symbol="g",
        source="added to Liu et al. 2021, (25)",
    )


@compiled
def avoid_along_tangent(want, at, x, y, z, me, p):
    """theta_i (22): the wanted heading, or the tangent if an obstacle is in the way; and o_i (19).

    Of the two tangent directions at the nearest point `at` the one within 90 degrees of the
    previous heading is taken; a corner has no tangent, and nothing is done about it.
    """
    if not (at.distance <= p.r_avoid) or at.smooth == 0.0:
        return want, HEARD
    dx, dy, dz = at.x - x, at.y - y, at.z - z
    d = math.sqrt(dx * dx + dy * dy + dz * dz)
    forward = dx * want.x + dy * want.y + dz * want.z
    if forward < d * math.cos(p.theta_obstruct):
        return want, HEARD
    inward = me.ux * at.nx + me.uy * at.ny + me.uz * at.nz
    tx, ty, tz = me.ux - inward * at.nx, me.uy - inward * at.ny, me.uz - inward * at.nz
    length = math.sqrt(tx * tx + ty * ty + tz * tz)
    if length < 1e-9:
        tx, ty, tz = -at.ny, at.nx, 0.0
        length = math.sqrt(tx * tx + ty * ty)
        if length < 1e-9:
            tx, length = 1.0, 1.0
    return Decision(tx / length, ty / length, tz / length), AVOIDS


@compiled
def spring(me, near, p):
    """Repulsion (24) and attraction (23), summed over the neighbours: six numbers."""
    rx = ry = rz = ax = ay = az = 0.0
    reach2 = p.r * p.r
    for j in range(near.n):
        dx = me.x - near.x[j]
        dy = me.y - near.y[j]
        dz = me.z - near.z[j]
        d2 = dx * dx + dy * dy + dz * dz
        is_in_reach = 1.0 if (d2 > 0.0) & (d2 <= reach2) else 0.0
        d = math.sqrt(d2) if d2 > 0.0 else 1.0
        rep = is_in_reach * (p.r_rep - d) / (p.r_rep * d) if d <= p.r_rep else 0.0
        att = is_in_reach * (p.r_rep - d) / ((p.r_att - p.r_rep) * d)
        att = att if (d > p.r_rep) & (d <= p.r_att) else 0.0
        rx += rep * dx
        ry += rep * dy
        rz += rep * dz
        ax += att * dx
        ay += att * dy
        az += att * dz
    return rx, ry, rz, ax, ay, az


@compiled
def explain(me, near, surroundings, p, out):
    """The terms of (25), length/tick: along the present heading, repulsion, attraction."""
    rx, ry, rz, ax, ay, az = spring(me, near, p)
    c = p.c_align * p.v0
    out[0, 0], out[0, 1], out[0, 2] = c * me.ux, c * me.uy, c * me.uz
    out[1, 0], out[1, 1], out[1, 2] = p.c_rep * rx, p.c_rep * ry, p.c_rep * rz
    out[2, 0], out[2, 1], out[2, 2] = p.c_att * ax, p.c_att * ay, p.c_att * az


@compiled
def move(me, near, surroundings, want, p, out):
    """Heading (22), velocity (25), (26) and position (8). An information UAV flies its path."""
    last = out.shape[0] - 1
    if me.informed:
        out[last] = HEARD
        v = p.v0
        return BodyMove(
            me.x + v * want.x, me.y + v * want.y, me.z + v * want.z, want.x, want.y, want.z, v
        )
    at = surface_within(surroundings, me.x, me.y, me.z, p.r_avoid)
    u, obstacle_share = avoid_along_tangent(want, at, me.x, me.y, me.z, me, p)
    out[last] = obstacle_share
    rx, ry, rz, ax, ay, az = spring(me, near, p)
    vx = p.c_align * p.v0 * u.x + p.c_rep * rx + p.c_att * ax
    vy = p.c_align * p.v0 * u.y + p.c_rep * ry + p.c_att * ay
    vz = p.c_align * p.v0 * u.z + p.c_rep * rz + p.c_att * az
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    if speed > p.v0:
        vx, vy, vz = vx * (p.v0 / speed), vy * (p.v0 / speed), vz * (p.v0 / speed)
    if p.guard > 0.0 and at.distance <= p.r_avoid:
        vx, vy, vz = guard_velocity(surroundings, at, me, vx, vy, vz, p.r_avoid)
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    return BodyMove(me.x + vx, me.y + vy, me.z + vz, u.x, u.y, u.z, speed)


@compiled
def passes(p):
    """Whether it goes through what is solid, as in the paper's literal text."""
    return p.guard == 0.0


BODY = Body(
    name="navigator",
    title="Navigating UAV",
    family="mission",
    source="Liu et al. 2021, (18) to (26)",
    parameters=Navigator,
    move=move,
    speed=lambda p: p.v0,
    signals=("heard",),
    words={"heard": "heard by others?"},
    deafens=True,
    sees_obstacles=True,
    passes=passes,
    passes_with="guard = false",
    sight="r_avoid",
    forces=("alignment", "repulsion", "attraction"),
    explain=explain,
)


TRIES = (
    LessonStep(
        "Let UAVs repel each other only within 0.3.",
        "They close up, to about 0.3 from each other, and go on with the mission.",
        {"r_rep": 0.3},
        LessonCheck("nearest-neighbour", "below", 0.35, 300),
    ),
    LessonStep(
        "Take the repulsion away, and strengthen the attraction.",
        "They crowd into clumps, all in nearly one spot.",
        {"c_rep": 0.0, "c_att": 0.1},
        LessonCheck("nearest-neighbour", "below", 0.05, 300),
    ),
    LessonStep(
        "Raise the noise to 4 rad.",
        "The flock falls apart into many small groups, and only the information agent still "
        "flies its path.",
        {"eta": 4.0},
        LessonCheck("largest-group", "below", 22, 300),
    ),
)


def model(rule: Rule) -> Model:
    """The model NAME-nav: a rule of the Vicsek family on a mission among obstacles."""
    return Model(
        rule,
        BODY,
        suffix="-nav",
        title_suffix=" on a mission",
        summary_suffix=" On a mission: with repulsion, attraction, and flight along obstacles.",
        defaults={"eta": 0.1},
        world="liu2021-mission",
        agents=49,
        tries=TRIES,
    )
