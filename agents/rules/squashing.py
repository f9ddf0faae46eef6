"""Cars that follow an injected car: every other car is a vector, squashed to a bounded pull.

Jacobs and Koessler, "Flocking Cars: Dynamic Behavior in Simulation & Implementation", (2) and (3).
The injected car, which is controlled precisely in code, is the goal of the world's mission. The
paper leaves the squashing function unbounded in words ("very large and negative"); its (3) is
bounded, sigma(0) = -beta C, and so it is here.
"""

from __future__ import annotations

import math
from typing import Literal

from agents.bodies.tracking import Tracking, error_of, stale_error
from agents.engine.block import Decision, adjacent
from agents.models.declare import Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.pulls import (
    ERROR_X,
    ERROR_Y,
    HUNTS,
    OWN,
    chase,
    hearing_limit2,
    is_heard,
    is_hunter,
    is_plain,
    own_chase,
    pull_to_injected,
    pulls,
    sense_cars,
)
from worlds.compilation import compiled

LAST_X, LAST_Y, KNOWN, RATE_X, RATE_Y, SUM_X, SUM_Y = 0, 1, 2, 3, 4, 5, 6
"""The rule's memory: D of the tick before, whether there was one, how fast D changes, 1/s, and what
it has added up to, s."""
FORCES = ("cars", "injected car", "predators", "alignment", "derivative", "integral")
"""The terms of D."""
PAPER = "Jacobs and Koessler (3)"


class Squashing(Tracking):
    """Parameters of the squashing rule."""

    beta: float = parameter(
        2.0,
        "Scale of the squashing function; cars that steer go by the direction only",
        words="Scale",
        symbol="\\beta",
        low=0.0,
        high=20.0,
        proposed=(0.0, 10.0),
        step=0.1,
        source=PAPER,
    )
    C: float = parameter(
        0.7,
        "Share of the pull that is taken off: the function is 0 at C gamma / (1 - C)",
        words="Share taken off",
        symbol="C",
        low=0.0,
        high=5.0,
        proposed=(0.0, 2.0),
        step=0.01,
        source=PAPER,
    )
    gamma: float = parameter(
        0.214,
        "Distance at which the pull has risen to a half",
        words="Distance of half the pull",
        symbol="\\gamma",
        unit="m",
        low=0.001,
        high=10.0,
        proposed=(0.02, 2.0),
        step=0.001,
        source=PAPER,
    )
    power: float = parameter(
        1.0,
        "Shape of the squashing function: above 1 it is flat near 0, below 1 steep; the distance "
        "at which cars do not affect each other stays",
        words="Shape",
        symbol="n",
        low=0.2,
        high=6.0,
        step=0.1,
        source="the paper's future work: other characteristics; 1 in the paper",
    )
    soft: float = parameter(
        0.0,
        "Softness of the squashing function: distances count as so much larger, so that near cars "
        "repel less; the distance at which cars do not affect each other stays",
        words="Softness",
        symbol="s",
        unit="m",
        low=0.0,
        high=5.0,
        proposed=(0.0, 2.0),
        step=0.05,
        source="the paper's future work: a smaller slope near 0; 0 in the paper",
    )
    r: float = parameter(
        20.0,
        "Distance up to which cars notice each other",
        words="Vision radius",
        symbol="r",
        unit="m",
        low=0.1,
        high=200.0,
        proposed=(0.5, 50.0),
        step=0.1,
        source="ours: the computer of the paper knows where all cars are",
    )
    k: float = parameter(
        0.0,
        "How many of the nearest cars a car hears; 0 for all. The injected car is always heard",
        words="Cars heard",
        symbol="k",
        low=0.0,
        high=20.0,
        step=1.0,
        source="the paper's future work: limit information to the cars",
    )
    c_goal: float = parameter(
        1.0,
        "Weight of the injected car: it counts as so many cars",
        words="Weight of the injected car",
        symbol="c_{inj}",
        low=0.0,
        high=20.0,
        step=0.1,
        source="1 in the paper",
    )
    c_align: float = parameter(
        0.0,
        "Weight of the headings of the cars that are heard",
        words="Weight of headings",
        symbol="c_{align}",
        low=0.0,
        high=10.0,
        proposed=(0.0, 2.0),
        step=0.05,
        source="the paper's abstract has heading alignment, its equations have none",
    )
    derivative: float = parameter(
        0.0,
        "Derivative term: D is taken as far ahead as this time",
        words="Derivative term",
        symbol="T_D",
        unit="s",
        low=0.0,
        high=2.0,
        proposed=(0.0, 1.0),
        step=0.01,
        source="the paper's future work: integral and derivative terms",
    )
    integral: float = parameter(
        0.0,
        "Integral term: what D has added up to counts so much",
        words="Integral term",
        symbol="K_I",
        unit="1/s",
        low=0.0,
        high=10.0,
        proposed=(0.0, 2.0),
        step=0.05,
        source="the paper's future work: integral and derivative terms",
    )
    windup: float = parameter(
        1.0,
        "The most that D adds up to: a longer sum is cut to this length",
        words="Largest sum",
        symbol="I_{max}",
        unit="s",
        low=0.01,
        high=100.0,
        step=0.1,
        source="ours: else cars that cannot follow add up without end",
    )
    sensing: Literal["tracking", "own"] = parameter(
        "tracking",
        "Whether cars know what the cameras track, or only what each measures itself: who is "
        "within r and in its field of view, the injected car too",
        words="Sensing",
        symbol="sens",
        source="the paper's future work: distributed processing, cars that locate their neighbours",
    )
    alpha_s: float = parameter(
        360.0,
        "Field of view of a car's own sensors: the full angle about its heading",
        words="Field of view of the sensors",
        symbol="\\alpha_s",
        unit="deg",
        low=10.0,
        high=360.0,
        proposed=(10.0, 360.0),
        step=10.0,
        source="the paper's future work, without a value",
    )
    noise_range: float = parameter(
        0.0,
        "Noise of a car's own sensors: standard deviation of all its distances, as a share",
        words="Noise of distances",
        symbol="\\sigma_r",
        low=0.0,
        high=1.0,
        proposed=(0.0, 0.5),
        step=0.01,
        source="ours",
        noise=True,
    )
    noise_bearing: float = parameter(
        0.0,
        "Noise of a car's own sensors: standard deviation of all its bearings",
        words="Noise of bearings",
        symbol="\\sigma_\\phi",
        unit="rad",
        low=0.0,
        high=1.0,
        proposed=(0.0, 0.5),
        step=0.01,
        source="ours",
        noise=True,
    )
    predators: float = parameter(
        0.0,
        "Predators: so many cars, those with the first numbers, chase the nearest other car",
        words="Predators",
        symbol="n_p",
        low=0.0,
        high=10.0,
        step=1.0,
        source="the paper's future work",
    )
    beta_p: float = parameter(
        0.6,
        "Scale of the squashing function for a predator",
        words="Scale for predators",
        symbol="\\beta_p",
        low=0.0,
        high=20.0,
        proposed=(0.0, 5.0),
        step=0.05,
        source="ours: with C above 1 it never fades, so that its scale has to be small",
    )
    C_p: float = parameter(
        1.2,
        "C for a predator: above 1 it repels at every distance",
        words="Share for predators",
        symbol="C_p",
        low=0.0,
        high=5.0,
        proposed=(0.0, 3.0),
        step=0.05,
        source="the paper's future work: C greater than 1",
    )


@compiled
def wish_of_predator(me, near, p):
    """What a predator wants, by the tracking or by its own sensors."""
    return own_chase(me, near, p) if p.sensing == OWN else chase(me, near, p)


@compiled
def desired(me, near, surroundings, p):
    """D of (2) without its derivative and its integral."""
    if is_hunter(me, p):
        return wish_of_predator(me, near, p)
    cx, cy, px, py, ax, ay = pulls(me, near, p)
    ix, iy = pull_to_injected(me, surroundings, p)
    return cx + ix + px + ax, cy + iy + py + ay


@compiled
def perceive(me, near, surroundings, p):
    """How fast D changes, by its value of the tick before, and what it has added up to."""
    if p.integral > 0.0:
        x, y = desired(me, near, surroundings, p)
        x, y = me.memory[SUM_X] + p.dt * x, me.memory[SUM_Y] + p.dt * y
        length = math.sqrt(x * x + y * y)
        share = p.windup / length if length > p.windup else 1.0
        me.memory[SUM_X], me.memory[SUM_Y] = share * x, share * y
    if p.derivative > 0.0:
        x, y = desired(me, near, surroundings, p)
        is_known = me.memory[KNOWN]
        me.memory[RATE_X] = is_known * (x - me.memory[LAST_X]) / p.dt
        me.memory[RATE_Y] = is_known * (y - me.memory[LAST_Y]) / p.dt
        me.memory[LAST_X], me.memory[LAST_Y], me.memory[KNOWN] = x, y, 1.0
    else:
        me.memory[KNOWN] = 0.0


@compiled
def decide(me, near, surroundings, p):
    """D of (2), with the derivative and the integral term if there are any."""
    x, y = desired(me, near, surroundings, p)
    if p.derivative > 0.0:
        x += p.derivative * me.memory[RATE_X]
        y += p.derivative * me.memory[RATE_Y]
    if p.integral > 0.0:
        x += p.integral * me.memory[SUM_X]
        y += p.integral * me.memory[SUM_Y]
    return Decision(x, y, 0.0)


@compiled
def explain(me, near, surroundings, p, out):
    """The terms of D, in the order of FORCES; the chase of a predator is its pull by cars."""
    out[:, :] = 0.0
    if is_hunter(me, p):
        out[0, 0], out[0, 1] = wish_of_predator(me, near, p)
    else:
        out[0, 0], out[0, 1], out[2, 0], out[2, 1], out[3, 0], out[3, 1] = pulls(me, near, p)
        out[1, 0], out[1, 1] = pull_to_injected(me, surroundings, p)
    if p.derivative > 0.0:
        out[4, 0] = p.derivative * me.memory[RATE_X]
        out[4, 1] = p.derivative * me.memory[RATE_Y]
    if p.integral > 0.0:
        out[5, 0] = p.integral * me.memory[SUM_X]
        out[5, 1] = p.integral * me.memory[SUM_Y]


@compiled
def show(me, p, out):
    """The signals that others receive: the tracked position, and whether it is a predator."""
    out[ERROR_X], out[ERROR_Y] = error_of(me, p, me.signal[ERROR_X], me.signal[ERROR_Y])
    out[HUNTS] = 1.0 if is_hunter(me, p) else 0.0


@compiled
def remember(me, near, p, out):
    """How far a car that is not seen in the next frame will be from where it is taken to be."""
    x, y = me.signal[ERROR_X], me.signal[ERROR_Y]
    out[ERROR_X], out[ERROR_Y] = stale_error(me, p, x, y)


@compiled
def weigh(me, near, p, out):
    """1 for the cars that are heard and for predators."""
    if not is_plain(p):
        sense_cars(me, near, p)
        for j in range(near.n):
            out[j] = max(near.spare[2, j], near.spare[3, j])
        return
    hunts = near.signal[HUNTS]
    limit = hearing_limit2(me, near, p)
    for j in range(near.n):
        flees = adjacent(me, near, j, p.r) * hunts[j]
        out[j] = max(is_heard(me, near, j, limit, p), flees)


SQUASHING = Rule(
    name="squashing",
    title="The squashing rule",
    summary="Cars follow an injected one. Each goes by the sum of the vectors to it and to all "
    "other cars, squashed so that those nearer than half a metre repel and all others attract, "
    "the far ones no more than the near.",
    equation=r"D_i = \sum_{j \neq i} \sigma(d_{ij}), \quad "
    r"\sigma(v) = \beta \frac{v}{|v|} \Big(-C + \frac{|v|}{|v| + \gamma}\Big)",
    source="Jacobs and Koessler, (2) and (3)",
    checked="figure 3, {jacobs-fig3#1}; figure 11, {jacobs-fig11#1} (`flockscope paper "
    "jacobs-fig3`, `jacobs-fig11`)",
    tags=("robotics", "cars", "vehicles", "traffic", "motion capture", "predator"),
    parameters=Squashing,
    decide=decide,
    wish="velocity",
    dimensions=(2,),
    signals=("error_x", "error_y", "predator"),
    hunters="predator",
    show=show,
    remember=remember,
    memory=("last_x", "last_y", "known", "rate_x", "rate_y", "sum_x", "sum_y"),
    units={"error": "m", "rate": "1/s", "sum": "s"},
    words={
        "error": "error of its place",
        "predator": "hunts the others?",
        "last": "last wish",
        "known": "last wish known?",
        "rate": "change of its wish",
        "sum": "sum of its wishes",
    },
    perceive=perceive,
    weigh=weigh,
    forces=FORCES,
    explain=explain,
    tries=(
        LessonStep(
            "Lower C to 0.3.",
            "The distance at which cars neither attract nor repel shrinks, and they come close "
            "together.",
            {"C": 0.3},
            LessonCheck("nearest-neighbour", "below", 0.2, 1500),
        ),
        LessonStep(
            "Raise C to 1.5.",
            "Repulsion at every distance: each flees all others, and the injected car too.",
            {"C": 1.5},
            LessonCheck("nearest-neighbour", "above", 5, 1500),
        ),
        LessonStep(
            "Take the injected car's weight away.",
            "The four settle into a square and stand.",
            {"c_goal": 0.0},
            LessonCheck("polarisation", "below", 0.2, 1500),
        ),
    ),
)
