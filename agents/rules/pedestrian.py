"""Pedestrians under social forces: towards their aim, away from each other's steps and from walls.

Helbing and Molnar 1995, "Social force model for pedestrian dynamics", Physical Review E 51, 4282.
Their repulsion goes by an ellipse about the other's place now and that where its step ends, and it
counts less from behind.

As the paper writes it, a step leads along the direction that the other desires, which it therefore
tells, at the speed that it has. Read here: the largest speed bounds the velocity itself. Left out:
attraction to friends and shop windows, and the fluctuations, to which the paper gives no size.
"""

from __future__ import annotations

import math
from typing import Literal

from agents.engine.block import Decision, adjacent
from agents.engine.eight_others import across, is_there, sums_over_others
from agents.engine.neighbour_search import UNKNOWN
from agents.engine.noise import exp, normal
from agents.engine.vector_lanes import where
from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from worlds.compilation import compiled
from worlds.queries.surroundings import solids_around, surface

PAPER = "Helbing and Molnar 1995"
FORCES = ("drive", "pedestrians", "walls", "limit")
"""The terms of the acceleration, m/s^2; the last is what keeps it below its largest speed."""
WAY_X, WAY_Y = 0, 1
"""Where the signals have the desired direction."""
KNOWN, DEVIATION, AIM_X, AIM_Y = 0, 1, 2, 3
"""Where the memory has whether the desired speed is known, by how many deviations it is off, and
the direction to the goal: 0, 0 while none is known."""
TWO, GOAL = 0.0, 2.0
"""`ways` as compiled code has it."""
DRAW = 4
"""The draws of a rule's own, of which the desired speed takes two."""
SLOWEST = 0.1
"""Of the mean desired speed: nobody desires less."""
THIN = 1e-9
"""Half axis below which an ellipse is its own line, m; on it nothing says to which side to go."""


class Pedestrians(Parameters):
    """Parameters of the social force model."""

    r: float = parameter(
        5.0,
        "Distance beyond which others and walls are not minded",
        words="Vision radius",
        symbol="r",
        unit="m",
        low=0.1,
        high=50.0,
        step=0.5,
        source="ours: beyond it the repulsion is below 0.001 m/s^2",
    )
    ways: Literal["two", "own", "goal"] = parameter(
        "two",
        "Where they want to go: along +x or -x, whichever is nearer to the heading at the start; "
        "along that heading itself; or to the goal of the world, where there is one",
        words="Ways",
        symbol="e",
        source="Helbing and Molnar 1995, figure 2: a walkway; (1): a goal; the other is ours",
    )
    v0: float = parameter(
        1.34,
        "Mean desired speed",
        words="Desired speed",
        symbol="v^0",
        unit="m/s",
        low=0.1,
        high=10.0,
        proposed=(0.2, 4.0),
        step=0.05,
        source=PAPER,
    )
    spread: float = parameter(
        0.26,
        "Standard deviation of the desired speeds, which are normal; nobody desires less than a "
        "tenth of the mean",
        words="Spread of the speeds",
        symbol="\\sqrt{\\theta}",
        unit="m/s",
        low=0.0,
        high=2.0,
        proposed=(0.0, 1.0),
        step=0.02,
        source=PAPER,
        noise=True,
    )
    haste: float = parameter(
        1.3,
        "Largest speed of a pedestrian, over its desired speed",
        words="Largest speed over desired",
        symbol="v^{max} / v^0",
        low=1.0,
        high=5.0,
        proposed=(1.0, 3.0),
        step=0.05,
        source=PAPER,
    )
    tau: float = parameter(
        0.5,
        "Relaxation time: in which the velocity comes near to the desired one",
        words="Relaxation time",
        symbol="\\tau",
        unit="s",
        low=0.05,
        high=10.0,
        step=0.05,
        source="Helbing and Molnar 1995, (2)",
    )
    repulsion: float = parameter(
        2.1,
        "Repulsive potential of others at the line of their step",
        words="Repulsion of others",
        symbol="V^0",
        unit="m^2/s^2",
        low=0.0,
        high=50.0,
        step=0.1,
        source="Helbing and Molnar 1995, (3)",
    )
    sigma: float = parameter(
        0.3,
        "Half axis over which that potential falls to 1/e",
        words="Reach of that repulsion",
        symbol="\\sigma",
        unit="m",
        low=0.05,
        high=5.0,
        step=0.05,
        source="Helbing and Molnar 1995, (3)",
    )
    step_time: float = parameter(
        2.0,
        "Time of a step: where others will be then is minded too",
        words="Time of a step",
        symbol="\\Delta t",
        unit="s",
        low=0.0,
        high=5.0,
        step=0.1,
        source="Helbing and Molnar 1995, (4)",
    )
    border: float = parameter(
        10.0,
        "Repulsive potential of walls at their surface",
        words="Repulsion of walls",
        symbol="U^0",
        unit="m^2/s^2",
        low=0.0,
        high=100.0,
        step=0.5,
        source="Helbing and Molnar 1995, (5)",
    )
    r_border: float = parameter(
        0.2,
        "Distance over which that potential falls to 1/e",
        words="Reach of the walls",
        symbol="R",
        unit="m",
        low=0.05,
        high=5.0,
        step=0.05,
        source="Helbing and Molnar 1995, (5)",
    )
    fov: float = parameter(
        200.0,
        "Field of view: the angle about the desired direction in which others count in full",
        words="Field of view",
        symbol="2 \\varphi",
        unit="deg",
        low=0.0,
        high=360.0,
        step=5.0,
        source="Helbing and Molnar 1995, (8)",
    )
    c: float = parameter(
        0.5,
        "Weight of others outside of the field of view",
        words="Weight of those not seen",
        symbol="c",
        low=0.0,
        high=1.0,
        step=0.05,
        source="Helbing and Molnar 1995, (8)",
    )


@compiled
def show(me, p, out):
    """The desired direction e_a: from the heading at the start, or to the goal, as it was seen in
    the tick before."""
    if me.signal[WAY_X] == UNKNOWN:
        two = p.ways == TWO
        side = 1.0 if me.ux >= 0.0 else -1.0
        out[WAY_X] = side if two else me.ux
        out[WAY_Y] = 0.0 if two else me.uy
    if p.ways == GOAL and (me.memory[AIM_X] != 0.0 or me.memory[AIM_Y] != 0.0):
        out[WAY_X], out[WAY_Y] = me.memory[AIM_X], me.memory[AIM_Y]


@compiled
def perceive(me, near, surroundings, p):
    """The desired speed, once, and the direction to the goal: e_a of (1)."""
    if me.memory[KNOWN] == 0.0:
        me.memory[KNOWN], me.memory[DEVIATION] = 1.0, normal(me.key, me.id, DRAW)
    if p.ways == GOAL and surroundings.route.shape[0] > 0:
        x, y = surroundings.goal[0, 0] - me.x, surroundings.goal[0, 1] - me.y
        away = math.sqrt(x * x + y * y)
        if away > 0.0:
            me.memory[AIM_X], me.memory[AIM_Y] = x / away, y / away


@compiled
def desired_speed(me, p):
    """v_a^0, m/s: normal about the mean."""
    return max(SLOWEST * p.v0, p.v0 + p.spread * me.memory[DEVIATION])


@compiled
def drive(me, p):
    """F_a^0 = (v_a^0 e_a - v_a) / tau (2)."""
    v = desired_speed(me, p)
    x = (v * me.signal[WAY_X] - me.speed * me.ux) / p.tau
    y = (v * me.signal[WAY_Y] - me.speed * me.uy) / p.tau
    return x, y


@compiled
def repulsion_from(me, near, j, p):
    """f_ab = -grad V(b) of agent j, V = V^0 exp(-b / sigma) (3).

    b is half the minor axis of the ellipse through a whose foci are the place of b and that where
    its step ends, s = v_b dt further on along e_b: 2 b = sqrt((|r| + |r - s e_b|)^2 - s^2) (4).
    0 for whoever is beyond r, for itself, and on the line of a step.
    """
    rx, ry = me.x - near.x[j], me.y - near.y[j]
    step_length = p.step_time * near.speed[j]
    qx, qy = rx - step_length * near.signal[WAY_X, j], ry - step_length * near.signal[WAY_Y, j]
    d, q = math.sqrt(rx * rx + ry * ry), math.sqrt(qx * qx + qy * qy)
    b = 0.5 * math.sqrt(max((d + q) * (d + q) - step_length * step_length, 0.0))
    pushes = is_there(j) & (d <= p.r) & (d > 0.0) & (b >= THIN) & (q > 0.0)
    # What divides is 1 where nothing pushes: plain Python refuses to divide by 0.
    d, q, b = where(pushes, d, 1.0), where(pushes, q, 1.0), where(pushes, b, 1.0)
    push = p.repulsion / p.sigma * exp(-b / p.sigma) * (d + q) / (4.0 * b)
    fx, fy = push * (rx / d + qx / q), push * (ry / d + qy / q)
    return where(pushes, fx, 0.0), where(pushes, fy, 0.0)


@compiled
def weight(me, fx, fy, p):
    """w(e_a, -f): 1 if what pushes is in the field of view, else c (8)."""
    forward = -(me.signal[WAY_X] * fx + me.signal[WAY_Y] * fy)
    edge = math.cos(0.5 * math.radians(p.fov))
    return where(forward >= edge * math.sqrt(fx * fx + fy * fy), 1.0, p.c)


@compiled
def weighted_repulsion(me, near, j, p):
    """w(e_a, -f_ab) f_ab of agent j, or of eight."""
    fx, fy = repulsion_from(me, near, j, p)
    w = weight(me, fx, fy, p)
    return w * fx, w * fy


repulsions = sums_over_others(2, weighted_repulsion)


@compiled
def pedestrians(me, near, p):
    """The sum of w(e_a, -f_ab) f_ab (9) over the others."""
    x, y = repulsions(me, near, p)
    return across(x), across(y)


@compiled
def wall_forces(me, surroundings, p):
    """F_aB = -grad U(r) of every solid, r to its nearest place, U = U^0 exp(-r / R) (5)."""
    x = y = 0.0
    nearby = solids_around(surroundings, me.x, me.y)
    for k in range(nearby.number):
        at = surface(surroundings, nearby, k, me.x, me.y, me.z)
        if at.distance <= p.r:
            push = p.border / p.r_border * math.exp(-max(at.distance, 0.0) / p.r_border)
            x += push * at.nx
            y += push * at.ny
    return x, y


@compiled
def limit_speed(me, x, y, p):
    """What takes off the acceleration so much that |v| <= v^max = 1.3 v^0 after the tick."""
    h = p.dt / p.m
    vx, vy = me.speed * me.ux + h * x, me.speed * me.uy + h * y
    speed_limit, speed = p.haste * desired_speed(me, p), math.sqrt(vx * vx + vy * vy)
    if speed <= speed_limit:
        return 0.0, 0.0
    share = (speed_limit / speed - 1.0) / h
    return share * vx, share * vy


@compiled
def decide(me, near, surroundings, p):
    """The sum (9) of the social forces, bounded by the largest speed (10)."""
    x, y = drive(me, p)
    px, py = pedestrians(me, near, p)
    wx, wy = wall_forces(me, surroundings, p)
    x, y = x + px + wx, y + py + wy
    lx, ly = limit_speed(me, x, y, p)
    return Decision(x + lx, y + ly, 0.0)


@compiled
def explain(me, near, surroundings, p, out):
    """The forces, m/s^2, in the order of FORCES."""
    out[:, :] = 0.0
    out[0, 0], out[0, 1] = drive(me, p)
    out[1, 0], out[1, 1] = pedestrians(me, near, p)
    out[2, 0], out[2, 1] = wall_forces(me, surroundings, p)
    x, y = out[0, 0] + out[1, 0] + out[2, 0], out[0, 1] + out[1, 1] + out[2, 1]
    out[3, 0], out[3, 1] = limit_speed(me, x, y, p)


@compiled
def weigh(me, near, p, out):
    """How much each of the others is minded: 1 in the field of view, c outside of it, 0 far off."""
    for j in range(near.n):
        out[j] = 0.0
        if adjacent(me, near, j, p.r) > 0.0:
            fx, fy = repulsion_from(me, near, j, p)
            out[j] = weight(me, fx, fy, p)


RULE = Rule(
    name="pedestrian",
    title="Pedestrians under social forces",
    summary="Everybody has a speed and a direction to go by, and is pushed away from the steps of "
    "others and from walls; those who go the same way end up behind each other, in lanes.",
    equation=r"\dot v_\alpha = \frac{v^0_\alpha e_\alpha - v_\alpha}{\tau} - \sum_\beta "
    r"w(e_\alpha, -f_{\alpha\beta})\, \nabla V^0 e^{-b_{\alpha\beta} / \sigma} - \sum_B \nabla U^0 "
    r"e^{-r_{\alpha B} / R}, \qquad 2 b_{\alpha\beta} = \sqrt{\big(|r_{\alpha\beta}| + "
    r"|r_{\alpha\beta} - v_\beta \Delta t\, e_\beta|\big)^2 - (v_\beta \Delta t)^2}",
    source="Helbing and Molnar 1995",
    tags=(
        "crowds",
        "classroom",
        "pedestrians",
        "people",
        "evacuation",
        "traffic",
        "social force",
        "lanes",
    ),
    parameters=Pedestrians,
    decide=decide,
    wish="acceleration",
    dimensions=(2,),
    signals=("way_x", "way_y"),
    show=show,
    memory=("known", "deviation", "goal_x", "goal_y"),
    written=("goal_x", "goal_y"),
    words={
        "way": "desired direction",
        "known": "desired speed known?",
        "deviation": "speed off the mean by",
        "goal": "direction to the goal",
    },
    perceive=perceive,
    weigh=weigh,
    forces=FORCES,
    explain=explain,
    sees_obstacles=True,
    led=False,
    symmetries=("shift", "mirror"),
    checked="people who walk both ways along a walkway form lanes (Helbing and Molnar 1995, "
    "figure 2); lane order after 100 s, beside people who do not mind each other: "
    "{helbing1995-lanes#2} (`flockscope paper helbing1995-lanes`)",
    tries=(
        LessonStep(
            "Let nobody mind the others.",
            "People walk through one another, and no lanes come about.",
            {"repulsion": 0.0},
            LessonCheck("lane-order", "below", 0.24, 1500),
            anew=True,
        ),
        LessonStep(
            "Let everybody want to go at the same speed.",
            "Nobody overtakes, and the lanes get much clearer.",
            {"spread": 0.0},
            LessonCheck("lane-order", "above", 0.28, 1500),
            anew=True,
        ),
        LessonStep(
            "Let everybody want to go the way they look at the start.",
            "Crossing streams: no two ways any more, and the crowd comes apart into groups.",
            {"ways": "own"},
            LessonCheck("groups", "above", 2, 1500),
            anew=True,
        ),
    ),
)
