"""IVEM and IVEM-A: turn to the middle of the two most different neighbours (Liu et al. 2021).

Angles are raw, in [0, 2 pi), and are not wrapped: 350 and 10 degrees are far apart. 2-D only.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision, adjacent
from agents.engine.neighbour_search import search_layers
from agents.models.declare import Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.vicsek import VicsekAmong
from worlds.compilation import compiled

ANGLE, LAYER = 0, 1
FULL = 2.0 * math.pi


class ImprovedVicsekInformed(VicsekAmong):
    """Parameters of IVEM-A."""

    k_iu: float = parameter(
        100.0,
        "Weight of an information UAV for those in direct contact with it; others weigh 1",
        words="Weight of the information UAV",
        symbol="k_{IU}",
        low=0.0,
        high=1000.0,
        proposed=(1.0, 1000.0),
        step=1.0,
        source="Liu et al. 2021, section 3.1.2",
    )


@compiled
def show(me, p, out):
    """The signal that neighbours receive: the heading as an angle in [0, 2 pi)."""
    angle = math.atan2(me.uy, me.ux)
    out[ANGLE] = angle + FULL if angle < 0.0 else angle


@compiled
def extreme_angles(me, near, p):
    """Least and largest angle among the neighbours, (inf, -inf) without any."""
    smallest, largest = math.inf, -math.inf
    for j in range(near.n):
        if adjacent(me, near, j, p.r) * near.heard[j] > 0.0:
            smallest = min(smallest, near.signal[ANGLE, j])
            largest = max(largest, near.signal[ANGLE, j])
    return smallest, largest


@compiled
def decide(me, near, surroundings, p):
    """theta_i + lambda (max - min) / 2: (30), (31)."""
    theta = me.signal[ANGLE]
    smallest, largest = extreme_angles(me, near, p)
    if smallest > largest:
        return Decision(0.0, 0.0, 0.0)
    if theta <= smallest:
        theta += (largest - smallest) / 2.0
    elif theta >= largest:
        theta -= (largest - smallest) / 2.0
    return Decision(math.cos(theta), math.sin(theta), 0.0)


@compiled
def decide_informed(me, near, surroundings, p):
    """In direct contact with an information UAV: the weighted mean; else as IVEM."""
    x = y = total = contact = 0.0
    for j in range(near.n):
        a = adjacent(me, near, j, p.r) * near.heard[j]
        knows = a if near.signal[LAYER, j] == 1.0 else 0.0
        h = a - knows + p.k_iu * knows
        x += h * near.ux[j]
        y += h * near.uy[j]
        total += h
        contact += knows
    if contact == 0.0 or total == 0.0:
        return decide(me, near, surroundings, p)
    return Decision(x / total, y / total, 0.0)


@compiled
def prepare(flock, space, grid, slots, p, tick):
    """Mark the information UAVs: layer 1."""
    search_layers(flock, space, grid, slots, p.r, LAYER, 1)


@compiled
def weigh(me, near, p, out):
    """Only the two extremes count: weight 1."""
    smallest, largest = extreme_angles(me, near, p)
    for j in range(near.n):
        angle = near.signal[ANGLE, j]
        is_heard = adjacent(me, near, j, p.r) * near.heard[j]
        out[j] = is_heard if angle in (smallest, largest) else 0.0


@compiled
def weigh_informed(me, near, p, out):
    """In contact with an information UAV: k_IU for it and 1 for others; else as IVEM."""
    contact = 0.0
    for j in range(near.n):
        out[j] = adjacent(me, near, j, p.r) * near.heard[j]
        if near.signal[LAYER, j] == 1.0:
            contact += out[j]
            out[j] *= p.k_iu
    if contact == 0.0:
        weigh(me, near, p, out)


EQUATION = (
    r"\theta_i(k+1) = \theta_i(k) + \lambda\, \frac{\max_j\theta_j - \min_j\theta_j}{2}, \qquad "
    r"\lambda = \begin{cases} 1 & \theta_i \le \min_j\theta_j \\ 0 & \text{between} \\ "
    r"-1 & \theta_i \ge \max_j\theta_j \end{cases}"
)

IVEM = Rule(
    name="ivem",
    title="Improved Vicsek model",
    summary="An agent at the edge of its neighbours' headings turns to the middle of the two most "
    "different ones; an agent between them keeps its heading.",
    equation=EQUATION,
    source="Liu et al. 2021, (30), (31)",
    checked="time to align at N = 100 {liu2021-table1/ivem/100/k_con}, at 200 "
    "{liu2021-table1/ivem/200/k_con}: `flockscope paper liu2021-table1`",
    tags=("robotics", "UAV", "consensus", "swarm"),
    parameters=VicsekAmong,
    decide=decide,
    sifts=True,
    dimensions=(2,),
    signals=("angle",),
    units={"angle": "rad"},
    words={"angle": "heading as it tells it"},
    show=show,
    weigh=weigh,
    symmetries=("shift", "mirror"),  # angles are compared as numbers in [0, 2 pi)
    tries=(
        LessonStep(
            "Raise the noise to 3 rad.",
            "The polarisation falls to about 0.4. The Vicsek model keeps about 0.6 at the same "
            "noise: a mean of all neighbours averages more away than the two most different "
            "ones do.",
            {"eta": 3.0},
            LessonCheck("polarisation", "below", 0.52, 150),
        ),
        LessonStep(
            "Take ten times as many agents, as close together as before.",
            "At tick 60 a thousand agree nearly as well as a hundred; of the Vicsek model they "
            "would still be in patches.",
            {"agents": 1000},
            LessonCheck("polarisation", "above", 0.95, 60),
            anew=True,
        ),
        LessonStep(
            "Let agents notice each other only within 0.3.",
            "A dozen groups and more, each on a way of its own.",
            {"r": 0.3},
            LessonCheck("groups", "rises", 8, 150),
            anew=True,
        ),
    ),
)

IVEM_A = Rule(
    name="ivem-a",
    title="Improved Vicsek model with an information UAV",
    summary="IVEM, but an agent in direct contact with the information UAV listens to it most.",
    equation=EQUATION,
    source="Liu et al. 2021, section 3.1.2",
    checked="time to align at N = 100 {liu2021-table1/ivem-a/100/k_con}, at 200 "
    "{liu2021-table1/ivem-a/200/k_con}: `flockscope paper liu2021-table1`; success on a "
    "mission of 50 UAVs {liu2021-table2/IVEM-A/50/success}: `flockscope paper "
    "liu2021-table2`",
    tags=("robotics", "UAV", "leader", "consensus", "swarm"),
    parameters=ImprovedVicsekInformed,
    decide=decide_informed,
    dimensions=(2,),
    signals=("angle", "layer"),
    units={"angle": "rad"},
    words={"angle": "heading as it tells it", "layer": "layer (leader: 1)"},
    show=show,
    prepare=prepare,
    weigh=weigh_informed,
    informed=1,
    converges=True,
    symmetries=("shift", "mirror"),
    tries=(
        LessonStep(
            "Let the information agent weigh no more than anybody else.",
            "The flock still agrees, but not on the heading of the agent that knows it: word "
            "of it hardly gets through.",
            {"k_iu": 1.0},
            LessonCheck("consistency", "falls", 0.02, 300),
            anew=True,
        ),
        LessonStep(
            "Have twenty information agents instead of one.",
            "Everybody meets one soon, and the flock goes their way as one.",
            {"informed": 20},
            LessonCheck("polarisation", "above", 0.99, 150),
            anew=True,
        ),
        LessonStep(
            "Raise the noise to 3 rad.",
            "The order is gone: headings of all kinds, and a polarisation of about 0.2.",
            {"eta": 3.0},
            LessonCheck("polarisation", "below", 0.45, 150),
        ),
    ),
)
