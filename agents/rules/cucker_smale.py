"""Flocking of Cucker and Smale 2007: each agent takes on the velocities of all others.

Cucker and Smale 2007, "Emergent behavior in flocks", IEEE Transactions on Automatic Control 52,
852-862. How much an agent listens falls with the distance as a power, and never to nothing. Up to
beta = 1/2 that is slow enough for every flock to agree on a velocity; above, a flock that flies
apart too fast never does.

There is no limit to the distance in the paper. An engine of cells needs one: `r` is it, and as long
as no two agents are further apart than r the equation is the paper's, to the last bit.
"""

from __future__ import annotations

from agents.engine.block import Decision, is_neighbour, neighbour_of
from agents.engine.noise import exp, log
from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.sums import of_pairs, sums_around
from worlds.compilation import compiled

FORCES = ("alignment",)
"""The one term of the acceleration."""


class CuckerSmale(Parameters):
    """Parameters of Cucker and Smale's flocking."""

    r: float = parameter(
        1000.0,
        "Distance beyond which agents do not hear each other; the paper has none, so keep it above "
        "the diameter of the flock",
        words="Range of hearing",
        symbol="r",
        unit="m",
        low=0.1,
        high=1e6,
        proposed=(1.0, 10000.0),
        step=10.0,
        source="added to Cucker and Smale 2007",
    )
    K: float = parameter(
        0.05,
        "Strength of the alignment",
        words="Alignment",
        symbol="K",
        unit="1/s",
        low=0.0,
        high=100.0,
        proposed=(0.001, 10.0),
        step=0.01,
        source="Cucker and Smale 2007, (1); value chosen here",
    )
    sigma: float = parameter(
        1.0,
        "Distance from which on agents are listened to less",
        words="Distance of the near",
        symbol="\\sigma",
        unit="m",
        low=0.01,
        high=100.0,
        step=0.1,
        source="Cucker and Smale 2007, (1); value chosen here",
    )
    beta: float = parameter(
        0.4,
        "How fast that falls with the distance; up to 1/2 every flock comes to one velocity",
        words="Fall with the distance",
        symbol="\\beta",
        low=0.0,
        high=5.0,
        step=0.05,
        source="Cucker and Smale 2007, (1) and theorem 2; value chosen here",
    )


@compiled
def communication(d2, p):
    """a_ij = K / (sigma^2 + |x_i - x_j|^2)^beta (1), 1/s, from the square of the distance."""
    return p.K * exp(-p.beta * log(p.sigma * p.sigma + d2))


@compiled
def term(me, other, p):
    """a_ij (v_j - v_i) (2), m/s^2."""
    a = is_neighbour(other, p.r) * communication(other.d2, p)
    return (
        a * (other.speed * other.ux - me.speed * me.ux),
        a * (other.speed * other.uy - me.speed * me.uy),
        a * (other.speed * other.uz - me.speed * me.uz),
    )


@compiled
def answer(me, sums, surroundings, p):
    """dv_i/dt (2)."""
    x, y, z = sums
    return Decision(x, y, z)


around = sums_around(3, term)


@compiled
def explain(me, near, surroundings, p, out):
    """The acceleration, which is one term."""
    out[0, 0], out[0, 1], out[0, 2] = around(me, near, p)


@compiled
def weigh(me, near, p, out):
    """a_ij over what it is of two in one place: 1 next to an agent, and falling."""
    for j in range(near.n):
        other = neighbour_of(me, near, j)
        share = exp(-p.beta * log(1.0 + other.d2 / (p.sigma * p.sigma)))
        out[j] = share if is_neighbour(other, p.r) else 0.0


RULE = Rule(
    name="cucker-smale",
    title="Cucker-Smale flocking",
    summary="Agents take on the velocities of all others, of those far away less: by a power of "
    "the distance that decides whether every flock comes to one velocity.",
    equation=r"\dot v_i = \sum_{j} a_{ij} (v_j - v_i), \qquad "
    r"a_{ij} = \frac{K}{\big(\sigma^2 + |x_i - x_j|^2\big)^{\beta}}",
    source="Cucker and Smale 2007, (1), (2)",
    tags=("physics", "mathematics", "consensus", "emergence"),
    parameters=CuckerSmale,
    **of_pairs(3, term, answer),
    wish="acceleration",
    weigh=weigh,
    forces=FORCES,
    explain=explain,
    led=False,
    checked="what two agents that fly apart lose of their speed is the integral of the weight: "
    "beta = {cucker-smale2007#5}; beyond beta = 1/2 it depends on the start, beta = "
    "{cucker-smale2007#4}; up to 1/2 and below the critical speed flocks of 20 agree as fast as "
    "the bound says, beta = {cucker-smale2007#6} (`flockscope paper cucker-smale2007`)",
    tries=(
        LessonStep(
            "Let agents listen less to those far away: beta = 2.",
            "The flock comes apart before it agrees: beyond beta = 1/2 nothing promises that "
            "it will.",
            {"beta": 2.0},
            LessonCheck("polarisation", "below", 0.65, 500),
            anew=True,
        ),
        LessonStep(
            "Let them listen ten times as strongly.",
            "By tick 100 all have one velocity, to the last digit.",
            {"K": 0.5},
            LessonCheck("velocity-spread", "below", 1e-06, 100),
            anew=True,
        ),
        LessonStep(
            "Let nobody hear further than 1 m.",
            "Small groups agree among themselves and part: word of the others no longer gets "
            "through.",
            {"r": 1.0},
            LessonCheck("groups", "above", 12, 200),
            anew=True,
        ),
    ),
)
