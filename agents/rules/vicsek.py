"""VEM and VEM-A: the Vicsek model, without and with an information UAV.

Vicsek et al. 1995; Liu et al. 2021 (6). Every agent takes the mean heading of all agents within r,
itself among them. VEM-A is the same rule in a flock with an information agent, whom nobody weighs
more than any other.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision, is_neighbour
from agents.engine.vector_lanes import where
from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.neighbour_choice import Nearest
from agents.rules.terms.sums import of_pairs
from worlds.compilation import compiled


class Vicsek(Parameters):
    """Parameters that the whole Vicsek family shares."""

    r: float = parameter(
        1.0,
        "Interaction radius: agents within it are neighbours",
        words="Vision radius",
        symbol="r",
        unit="length",
        low=0.05,
        high=5.0,
        step=0.05,
        source="Liu et al. 2021, (6)",
    )
    eta: float = parameter(
        0.0,
        "Noise intensity: full width of the angle added to the heading (angular noise, rad), or "
        "length of the random vector added to the mean heading (vectorial noise)",
        words="Noise",
        symbol="\\eta",
        unit="rad",
        low=0.0,
        high=round(2 * math.pi, 4),
        proposed=(0.0, 6.2832),
        step=0.05,
        source="Liu et al. 2021, (6); vectorial: Grégoire and Chaté 2004",
        noise=True,
    )


class VicsekAmong(Nearest, Vicsek):
    """Parameters of the rules of the family that leave open who the neighbours are."""


@compiled
def term(me, other, p):
    """a_ij u_j and a_ij (11), of those that are heard."""
    a = is_neighbour(other, p.r) & other.heard
    return a * other.ux, a * other.uy, a * other.uz, a


@compiled
def answer(me, sums, surroundings, p):
    """Mean heading over the neighbours and itself: (6), with obstacles (18)."""
    x, y, z, n = sums
    b = me.own_weight
    n = n + b
    n = where(n == 0.0, 1.0, n)
    return Decision((x + b * me.ux) / n, (y + b * me.uy) / n, (z + b * me.uz) / n)


OF_PAIRS = of_pairs(4, term, answer, by_lanes=True)

EQUATION = (
    r"\theta_i(k+1) = \operatorname{atan2}\Big(\sum_{j \in \mathcal{N}_i \cup \{i\}} \sin\theta_j, "
    r"\sum_{j \in \mathcal{N}_i \cup \{i\}} \cos\theta_j\Big) + \Delta\theta_i"
)

VEM = Rule(
    name="vem",
    title="Vicsek model",
    summary="Each agent takes the mean heading of all agents within r, itself among them.",
    equation=EQUATION,
    source="Vicsek et al. 1995; Liu et al. 2021, (6)",
    checked="time to align at N = 100 {liu2021-table1/vem/100/k_con}, at 200 "
    "{liu2021-table1/vem/200/k_con}: `flockscope paper liu2021-table1`",
    tags=("physics", "classroom", "phase transition", "consensus", "swarm", "emergence"),
    parameters=VicsekAmong,
    **OF_PAIRS,
    tries=(
        LessonStep(
            "Raise the noise to 5.5 rad, nearly a full turn.",
            "The flock that went one way becomes a crowd: every heading is there, and the "
            "polarisation falls to about 0.1.",
            {"eta": 5.5},
            LessonCheck("polarisation", "below", 0.25, 150),
        ),
        LessonStep(
            "Take ten times as many agents, as close together as before.",
            "Patches of one heading each, which join only slowly: at tick 60 a hundred agents "
            "have long agreed, a thousand have not.",
            {"agents": 1000},
            LessonCheck("polarisation", "falls", 0.1, 60),
            anew=True,
        ),
        LessonStep(
            "Let agents notice each other only within 0.3.",
            "Several groups, each with a heading of its own; they only come together where "
            "their ways happen to cross.",
            {"r": 0.3},
            LessonCheck("groups", "rises", 2, 150),
            anew=True,
        ),
    ),
)

VEM_A = Rule(
    name="vem-a",
    title="Vicsek model with an information UAV",
    summary="The Vicsek model in a flock where one agent knows the heading to take and never "
    "turns; nobody weighs it more than any other.",
    equation=EQUATION,
    source="Liu et al. 2021, (6) and section 3.1.2",
    checked="time to align at N = 100 {liu2021-table1/vem-a/100/k_con}, at 200 "
    "{liu2021-table1/vem-a/200/k_con}: `flockscope paper liu2021-table1`; success on a "
    "mission of 50 UAVs {liu2021-table2/VEM-A/50/success}: `flockscope paper "
    "liu2021-table2`",
    tags=("robotics", "UAV", "leader", "consensus", "swarm"),
    parameters=VicsekAmong,
    **OF_PAIRS,
    informed=1,
    converges=True,
    tries=(
        LessonStep(
            "Have twenty information agents instead of one.",
            "Everybody has one near by: at tick 60 all have their heading, "
            "where the single one still pulls at the flock.",
            {"informed": 20},
            LessonCheck("consistency", "above", 0.999, 60),
            anew=True,
        ),
        LessonStep(
            "Take ten times as many agents, as close together as before.",
            "The single agent that knows the way drowns: at tick 60 there are patches of every "
            "heading.",
            {"agents": 1000},
            LessonCheck("polarisation", "falls", 0.1, 60),
            anew=True,
        ),
        LessonStep(
            "Raise the noise to 5.5 rad, nearly a full turn.",
            "The flock becomes a crowd: every heading is there, that of the information agent "
            "no more than others.",
            {"eta": 5.5},
            LessonCheck("polarisation", "below", 0.25, 150),
        ),
    ),
)
