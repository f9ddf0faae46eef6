"""Boundary points and expected velocity: flocking round obstacles of any shape (Wu et al. 2023, 3).

An agent perceives the boundary points of obstacles within r. Each pushes as a flock-mate does, and
all of them together tow it to where it expects to be next: along the boundary while an obstacle is
in its way, to the gamma agent otherwise. In the plane only: phases have no order in space.

What the paper leaves open is read so that its claims come out. An obstacle is in the way if a
perceived point lies ahead of the agent, towards the gamma agent and no further than that, within
d_e of the straight line to it. Phases are compared as (16) says; the sign printed in (15) never
holds on an ascending sort.
"""

from __future__ import annotations

import math
from typing import Literal

from agents.engine.block import Decision, is_neighbour, points_of
from agents.models.declare import Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.sigma import (
    FORCES,
    Interaction,
    fade,
    has_goal,
    level,
    push,
    sigma_norm,
    stretch,
    weigh,
    write_forces,
)
from agents.rules.terms.sums import of_pairs, sums_around
from worlds.compilation import compiled

MEMORY = (
    "following",
    "blocked",
    "split_x",
    "split_y",
    "rejoin_x",
    "rejoin_y",
    "aim_x",
    "aim_y",
    "phase",
    "scenario",
)
"""What an agent keeps to itself.

following: 1 from a split point on until it is free again. blocked: 1 while an obstacle is in its
way. split, rejoin: the last such points, m. aim: the expected position, m. phase: of the aim, rad
in [0, 2 pi) from the axis. scenario: 1 to 4 for A1 to A4 of table 2, 0 where there is no goal.
"""
FOLLOWING, BLOCKED, SPLIT, REJOIN, AIM, PHASE, SCENARIO = 0, 1, 2, 4, 6, 8, 9
"""Their places in `me.memory`; points take two."""
AT_SPLIT, BETWEEN, AT_REJOIN, FREE = 1.0, 2.0, 3.0, 4.0
"""The scenarios A1 to A4."""
CLOCKWISE = 1.0
"""Index of `clockwise` among the choices of `sense`."""
TURN = 2.0 * math.pi


class BoundaryPoints(Interaction):
    """Parameters of boundary-point flocking."""

    tau_a: float = parameter(
        0.1,
        "Weight of attraction and repulsion further away than d",
        words="Weight beyond d",
        symbol="\\tau_a",
        low=0.0,
        high=1e6,
        proposed=(0.001, 100.0),
        step=0.1,
        source="Wu et al. 2023, (12), table 3",
    )
    tau_e: float = parameter(
        10.0,
        "Weight of the repulsion between the early-warning distance d_e and d",
        words="Weight within d",
        symbol="\\tau_e",
        low=0.0,
        high=1e6,
        proposed=(0.1, 10000.0),
        step=1.0,
        source="Wu et al. 2023, (12), table 3",
    )
    tau_s: float = parameter(
        10000.0,
        "Weight of the repulsion nearer than the early-warning distance d_e",
        words="Weight when too near",
        symbol="\\tau_s",
        low=0.0,
        high=1e6,
        proposed=(10.0, 1000000.0),
        step=100.0,
        source="Wu et al. 2023, (12), table 3",
    )
    d_min: float = parameter(
        1.0,
        "Least safe distance; the early-warning distance is d_e = d_min + 2 p_max dt",
        words="Least safe distance",
        symbol="d_{min}",
        unit="m",
        low=0.0,
        high=10.0,
        step=0.1,
        source="Wu et al. 2023, (12), table 3",
    )
    dtheta: float = parameter(
        round(math.pi / 4.0, 4),
        "Gap in phase at which a boundary is taken to end",
        words="Gap that ends a boundary",
        symbol="\\Delta\\theta",
        unit="rad",
        low=0.01,
        high=round(TURN, 3),
        proposed=(0.1, 3.1),
        step=0.05,
        source="Wu et al. 2023, (15), (16), table 3",
    )
    sense: Literal["counterclockwise", "clockwise"] = parameter(
        "counterclockwise",
        "Which way round the flock goes: phases are compared from small to large, or back",
        words="Way round obstacles",
        symbol="s",
        source="Wu et al. 2023, (15), (16), table 2",
    )


@compiled
def alarm(p):
    """The early-warning distance d_e = d_min + 2 p_max dt, m."""
    return p.d_min + 2.0 * p.p_max * p.dt


@compiled
def is_blocked(me, points, gx, gy, width):
    """1.0 if a perceived point lies ahead and within `width` (m) of the line to the gamma agent."""
    x, y = gx - me.x, gy - me.y
    length = math.sqrt(x * x + y * y)
    if length == 0.0:
        return 0.0
    ux, uy = x / length, y / length
    count = 0.0
    for k in range(points.n):
        dx = points.x[k] - me.x
        dy = points.y[k] - me.y
        along = dx * ux + dy * uy
        offset = math.fabs(dx * uy - dy * ux)
        inside = (along > 0.0) & (along <= length) & (offset <= width)
        count = 1.0 if inside else count
    return count


@compiled
def boundary_end(me, points, ax, ay, p):
    """The point q_k(m) at which the boundary ends, by phase from the axis to (ax, ay): (15), (16).

    The first phase in ascending order that the next exceeds by dtheta or more, else the last.
    Clockwise the order is the opposite. Without a sort: from the first phase on, the furthest that
    is less than dtheta ahead is jumped to, until there is none. Returns (x, y, phase).
    """
    axis = math.atan2(ay - me.y, ax - me.x)
    sign = -1.0 if p.sense == CLOCKWISE else 1.0
    current = math.inf
    for k in range(points.n):
        phase = math.atan2(points.y[k] - me.y, points.x[k] - me.x) - axis
        phase = sign * (phase + TURN if phase < 0.0 else phase)
        points.spare[0, k] = phase
        current = phase if phase < current else current
    while True:
        last_step = current
        for k in range(points.n):
            phase = points.spare[0, k]
            last_step = phase if (phase - current < p.dtheta) & (phase > last_step) else last_step
        if last_step == current:
            break
        current = last_step
    k = 0
    while points.spare[0, k] != current:
        k += 1
    return points.x[k], points.y[k], sign * current


@compiled
def perceive(me, points, surroundings, p):
    """Split point, rejoin point and expected position (table 2, figures 3 and 4)."""
    m = me.memory
    m[SCENARIO] = 0.0
    if not has_goal(surroundings):
        return
    gx, gy = surroundings.goal[0, 0], surroundings.goal[0, 1]
    was = m[BLOCKED]
    m[BLOCKED] = is_blocked(me, points, gx, gy, alarm(p))
    scenario = AT_SPLIT if m[BLOCKED] > 0.0 else FREE
    if m[FOLLOWING] > 0.0:
        away = math.hypot(me.x - gx, me.y - gy)
        if away <= math.hypot(m[SPLIT] - gx, m[SPLIT + 1] - gy):
            m[REJOIN], m[REJOIN + 1] = me.x, me.y
            scenario = AT_REJOIN if m[BLOCKED] > 0.0 else FREE
        elif m[BLOCKED] == 0.0 or was > 0.0:
            scenario = BETWEEN
    m[SCENARIO] = scenario
    m[FOLLOWING] = 0.0 if scenario == FREE else 1.0
    if scenario == FREE:
        m[AIM], m[AIM + 1], m[PHASE] = gx, gy, 0.0
        return
    ax, ay = gx, gy
    if scenario == BETWEEN:
        ax, ay = m[SPLIT], m[SPLIT + 1]
    else:
        m[SPLIT], m[SPLIT + 1] = me.x, me.y
    if points.n > 0:
        m[AIM], m[AIM + 1], m[PHASE] = boundary_end(me, points, ax, ay, p)


@compiled
def boundary(me, points, p):
    """The sums of (14) and (18) over the boundary points: gradient (x, y), then sum of b_ik."""
    warning = alarm(p)
    fx = fy = heed = 0.0
    for k in range(points.n):
        dx = points.x[k] - me.x
        dy = points.y[k] - me.y
        d2 = dx * dx + dy * dy
        force, rho = push(d2, p)
        f = level(d2, warning, p.d, p.tau_a, p.tau_e, p.tau_s) * force
        fx += f * dx
        fy += f * dy
        heed += rho
    return fx, fy, heed


@compiled
def quick_push(d2, p):
    """`push` of eight agents at once: with quotients of parameters, which are taken once."""
    c = math.fabs(p.a - p.b) / math.sqrt(4.0 * p.a * p.b)
    per_range, per_fading = 1.0 / (stretch(p.r * p.r, p.eps) - 1.0), 1.0 / (1.0 - p.h)
    per_eps = 1.0 / p.eps
    wide = stretch(d2, p.eps)
    z = (wide - 1.0) * per_range
    rho = fade(z, (z - p.h) * per_fading)
    x = (wide - 1.0) * per_eps - sigma_norm(p.d * p.d, p.eps) + c
    root = math.sqrt(1.0 + x * x)
    return rho * 0.5 * ((p.a + p.b) * x + (p.a - p.b) * root) / (root * wide), rho


@compiled
def term(me, other, p):
    """What another agent adds to (13): gradient (x, y) and consensus (x, y), without gains."""
    force, rho = quick_push(other.d2, p)
    is_near = is_neighbour(other, p.r)
    f = is_near * (force * level(other.d2, alarm(p), p.d, p.tau_a, p.tau_e, p.tau_s))
    w = is_near * rho
    return (
        f * other.dx,
        f * other.dy,
        w * (other.speed * other.ux - me.speed * me.ux),
        w * (other.speed * other.uy - me.speed * me.uy),
    )


@compiled
def terms(me, sums, points, surroundings, p):
    """The terms of u_i (19), a row (x, y, z) for each of FORCES, m/s^2.

    Without a gamma agent nothing is in the way, and boundary points push but do not tow.
    """
    vx, vy = me.speed * me.ux, me.speed * me.uy
    fx, fy, cx, cy = sums
    bx = by = ex = ey = gx = gy = 0.0
    if points.n > 0:
        bx, by, heed = boundary(me, points, p)
        if me.memory[SCENARIO] > 0.0:
            ex = heed * ((me.memory[AIM] - me.x) / p.dt - vx)
            ey = heed * ((me.memory[AIM + 1] - me.y) / p.dt - vy)
    if has_goal(surroundings):
        gx = -p.c1g * (me.x - surroundings.goal[0, 0]) - p.c2g * (vx - surroundings.goal[1, 0])
        gy = -p.c1g * (me.y - surroundings.goal[0, 1]) - p.c2g * (vy - surroundings.goal[1, 1])
    return (
        (p.c1a * fx, p.c1a * fy, 0.0),
        (p.c2a * cx, p.c2a * cy, 0.0),
        (p.c1b * bx, p.c1b * by, 0.0),
        (p.c2b * ex, p.c2b * ey, 0.0),
        (gx, gy, 0.0),
    )


@compiled
def answer(me, sums, points, surroundings, p):
    """u_i = u_i^alpha + u_i^beta + u_i^gamma (19)."""
    perceive(me, points, surroundings, p)
    f, c, b, e, g = terms(me, sums, points, surroundings, p)
    return Decision(f[0] + c[0] + b[0] + e[0] + g[0], f[1] + c[1] + b[1] + e[1] + g[1], 0.0)


around = sums_around(4, term)


@compiled
def explain(me, near, surroundings, p, out):
    """The terms of (19) one by one."""
    points = points_of(near)
    perceive(me, points, surroundings, p)
    write_forces(terms(me, around(me, near, p), points, surroundings, p), out)


RULE = Rule(
    name="boundary-points",
    title="Boundary-point flocking",
    summary="Agents that follow a gamma agent go round obstacles of any shape, of which they "
    "perceive only boundary points: these push, and tow along the boundary.",
    equation=r"u_i = \sum_{j \in \mathcal{N}_i^\alpha} \big[c_1^\alpha \eta(d_{ij}) \phi_\alpha "
    r"n_{ij} + c_2^\alpha a_{ij} (p_j - p_i)\big] + \sum_{k \in \mathcal{N}_i^\beta} \big[c_1^\beta"
    r" \eta(d_{ik}) \phi_\alpha n_{ik} + c_2^\beta b_{ik} \big(\tfrac{\hat q_i - q_i}{\Delta t} - "
    r"p_i\big)\big] - c_1^\gamma (q_i - q_\gamma) - c_2^\gamma (p_i - p_\gamma)",
    source="Wu et al. 2023, (12) to (19), table 2",
    checked="{wu2023-fig5#2}; {wu2023-fig5#3} (`flockscope paper wu2023-fig5`)",
    tags=("robotics", "obstacles", "maze", "control", "swarm"),
    parameters=BoundaryPoints,
    **of_pairs(4, term, answer, sees_points=True),
    wish="acceleration",
    dimensions=(2,),
    memory=MEMORY,
    units={"split": "m", "rejoin": "m", "aim": "m", "phase": "rad"},
    words={
        "following": "along a boundary?",
        "blocked": "obstacle in its way?",
        "split": "left its way at",
        "rejoin": "came back at",
        "aim": "expects to be at",
        "phase": "direction of that",
        "scenario": "case of table 2",
    },
    places=("split", "rejoin", "aim"),
    places_while="following",
    weigh=weigh,
    forces=FORCES,
    explain=explain,
    sees_obstacles=True,
    sifts=True,
    led=False,
    tries=(
        LessonStep(
            "Take the pull of the gamma agent away.",
            "Nobody makes for the goal: the flock drifts apart into a dozen groups and more.",
            {"c1g": 0.0, "c2g": 0.0},
            LessonCheck("groups", "above", 8, 400),
            anew=True,
        ),
        LessonStep(
            "Take the forces between agents away.",
            "Nobody keeps a distance any more: they go through each other on their way to the "
            "goal.",
            {"c1a": 0.0},
            LessonCheck("nearest-neighbour", "below", 0.5, 400),
            anew=True,
        ),
        LessonStep(
            "Let nobody go faster than 2 m/s.",
            "At tick 400 they are still on their way, in one direction; at 5 m/s they are "
            "among the obstacles by then, going all ways round.",
            {"p_max": 2.0},
            LessonCheck("polarisation", "above", 0.85, 400),
            anew=True,
        ),
    ),
)
