"""Prey that swarm: the minimal model of Chen and Kolokolnikov 2014.

Chen and Kolokolnikov 2014, "A minimal model of predator-swarm interactions", Journal of the Royal
Society Interface 11, 20131208. Prey push each other off as charges in the plane do and attract each
other in proportion to their distance. Alone they fill a disc evenly. They have no inertia.

A predator is a kind of agents beside the prey (`agents.kinds`): they flee from it as b / d, and it
chases them by weight / d^(p - 1), where its weight is the paper's c over the number of prey.

There is no limit to the distance in the paper. An engine of cells needs one: `r` is it, and as long
as no two are further apart than r the equation is the paper's.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision, is_neighbour, neighbour_of
from agents.engine.vector_lanes import where
from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.sums import of_pairs, sums_around
from worlds.compilation import compiled

FORCES = ("repulsion", "attraction")
"""The terms of the velocity."""


class PreySwarm(Parameters):
    """Parameters of swarming prey. The strength of their repulsion is 1: it sets the length."""

    r: float = parameter(
        1000.0,
        "Distance beyond which prey do not notice each other; the paper has none, so keep it above "
        "the diameter of the swarm",
        words="Range",
        symbol="r",
        unit="length",
        low=0.1,
        high=1e6,
        proposed=(1.0, 10000.0),
        step=10.0,
        source="added to Chen and Kolokolnikov 2014",
    )
    a: float = parameter(
        1.0,
        "Attraction: velocity per distance to another, over the number of prey; the swarm alone is "
        "a disc of the radius 1 / sqrt(a)",
        words="Attraction",
        symbol="a",
        unit="1/s",
        low=0.0,
        high=100.0,
        proposed=(0.1, 10.0),
        step=0.1,
        source="Chen and Kolokolnikov 2014; value chosen here",
    )


@compiled
def force_terms(me, other, p):
    """Repulsion and attraction of another, and 1 for each: seven numbers, 0 beyond the range."""
    is_near = is_neighbour(other, p.r)
    push = is_near * (-1.0 / where(is_near, other.d2, 1.0))
    pull = is_near * p.a
    return (
        push * other.dx,
        push * other.dy,
        push * other.dz,
        pull * other.dx,
        pull * other.dy,
        pull * other.dz,
        is_near,
    )


@compiled
def term(me, other, p):
    """(x_i - x_k) / |x_i - x_k|^2 - a (x_i - x_k), and 1: for another prey within the range."""
    is_near = is_neighbour(other, p.r)
    share = is_near * (p.a - 1.0 / where(is_near, other.d2, 1.0))
    return share * other.dx, share * other.dy, share * other.dz, is_near


@compiled
def answer(me, sums, surroundings, p):
    """The sum of these over the number N of prey, oneself among them."""
    x, y, z, n = sums
    return Decision(x / (n + 1.0), y / (n + 1.0), z / (n + 1.0))


around = sums_around(7, force_terms)


@compiled
def explain(me, near, surroundings, p, out):
    """The terms of the velocity one by one, in the order of FORCES."""
    rx, ry, rz, ax, ay, az, n = around(me, near, p)
    out[0, 0], out[0, 1], out[0, 2] = rx / (n + 1.0), ry / (n + 1.0), rz / (n + 1.0)
    out[1, 0], out[1, 1], out[1, 2] = ax / (n + 1.0), ay / (n + 1.0), az / (n + 1.0)


@compiled
def weigh(me, near, p, out):
    """How strong repulsion and attraction of each are together, as x / (1 + x)."""
    for j in range(near.n):
        other = neighbour_of(me, near, j)
        x, y, z, _ = term(me, other, p)
        size = math.sqrt(x * x + y * y + z * z)
        out[j] = size / (1.0 + size)


RULE = Rule(
    name="prey-swarm",
    title="Swarm of prey",
    summary="Agents without inertia push each other off as charges do, and attract each other the "
    "more the further apart they are: they fill a disc evenly, or a ring around a predator.",
    equation=r"\dot x_j = \frac{1}{N} \sum_{k \ne j} \left[ \frac{x_j - x_k}{|x_j - x_k|^2} - "
    r"a\, (x_j - x_k) \right]",
    source="Chen and Kolokolnikov 2014",
    tags=("biology", "predator", "prey", "hunting", "aggregation", "ring"),
    parameters=PreySwarm,
    **of_pairs(4, term, answer),
    wish="velocity",
    dimensions=(2,),
    weigh=weigh,
    forces=FORCES,
    explain=explain,
    led=False,
    checked="the mean square radius of the ring about a predator, which is exact (off, in "
    "parts per million), and the strengths of the predator between which the ring stays: "
    "{chen2014-predator#1}; {chen2014-predator#7}; {chen2014-predator#10} "
    "(`flockscope paper chen2014-predator`)",
    tries=(
        LessonStep(
            "Make the attraction four times as strong.",
            "The disc shrinks to half its radius, 1 / sqrt(a), and stays evenly filled.",
            {"a": 4.0},
            LessonCheck("gyration-radius", "below", 0.37, 500),
        ),
        LessonStep(
            "Take the attraction away.",
            "Nothing holds the swarm: it gets wider and wider, and slower.",
            {"a": 0.0},
            LessonCheck("gyration-radius", "above", 2.0, 1000),
        ),
        LessonStep(
            "Take four times as many prey.",
            "The disc stays as it is; only the prey stand closer, at half the distance.",
            {"agents": 400},
            LessonCheck("nearest-neighbour", "below", 0.1, 1000),
            anew=True,
        ),
    ),
)
