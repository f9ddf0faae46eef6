"""Self-propelled particles in each other's Morse potential: D'Orsogna et al. 2006.

D'Orsogna, Chuang, Bertozzi and Chayes 2006, "Self-propelled particles with soft-core interactions:
patterns, stability, and collapse", Physical Review Letters 96, 104302. Each particle is driven to
the speed sqrt(alpha / beta), pushed off by those near it and pulled to those farther away. What a
swarm becomes follows from C = C_r / C_a and l = l_r / l_a: where C l^2 > 1 (in the plane, with C >
1 and l < 1) the potential is H-stable and each particle keeps its room however many there are;
where C l^2 < 1 it is catastrophic: more of them have less room each, and swarms mill.

The paper has no limit to the distance. Here the force ends at RANGE times the longer of the two
lengths, where it is less than 1e-13 of what it is near by.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision, neighbour_of
from agents.engine.noise import exp
from agents.engine.vector_lanes import where
from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.sums import of_pairs, sums_around
from worlds.compilation import compiled

FORCES = ("self-propulsion", "repulsion", "attraction")
"""The terms of the force."""
RANGE = 30.0
"""How many times the longer length the force reaches."""
VALUE = "D'Orsogna et al. 2006, (2); value chosen here"


class DOrsogna(Parameters):
    """Parameters of D'Orsogna's particles."""

    alpha: float = parameter(
        0.8,
        "Self-propulsion: what a particle at rest gains of its speed in a second",
        words="Self-propulsion",
        symbol="\\alpha",
        unit="1/s",
        low=0.0,
        high=100.0,
        step=0.1,
        source="D'Orsogna et al. 2006, (1); value chosen here",
    )
    beta: float = parameter(
        0.5,
        "Friction: a free particle comes to the speed sqrt(alpha / beta)",
        words="Friction",
        symbol="\\beta",
        unit="s/m^2",
        low=0.0,
        high=100.0,
        step=0.1,
        source="D'Orsogna et al. 2006, (1); value chosen here",
    )
    C_r: float = parameter(
        1.0,
        "Strength of the repulsion",
        words="Repulsion",
        symbol="C_r",
        unit="m^2/s^2",
        low=0.0,
        high=100.0,
        step=0.1,
        source=VALUE,
    )
    l_r: float = parameter(
        0.4,
        "Length over which the repulsion falls to 1/e",
        words="Length of the repulsion",
        symbol="l_r",
        unit="m",
        low=0.05,
        high=20.0,
        step=0.05,
        source=VALUE,
    )
    C_a: float = parameter(
        1.0,
        "Strength of the attraction",
        words="Attraction",
        symbol="C_a",
        unit="m^2/s^2",
        low=0.0,
        high=100.0,
        step=0.1,
        source=VALUE,
    )
    l_a: float = parameter(
        1.0,
        "Length over which the attraction falls to 1/e",
        words="Length of the attraction",
        symbol="l_a",
        unit="m",
        low=0.05,
        high=20.0,
        step=0.05,
        source=VALUE,
    )

    @property
    def range(self) -> float:
        """Where the force ends, length."""
        return RANGE * max(self.l_r, self.l_a)


@compiled
def force_terms(me, other, p):
    """Repulsion and attraction of another, -grad U (2): six numbers, 0 beyond the range."""
    is_in_range = (other.d2 > 0.0) & (other.d2 <= (RANGE * max(p.l_r, p.l_a)) ** 2)
    d = math.sqrt(where(is_in_range, other.d2, 1.0))
    push = is_in_range * (-p.C_r / p.l_r * exp(-d / p.l_r) / d)
    pull = is_in_range * (p.C_a / p.l_a * exp(-d / p.l_a) / d)
    return (
        push * other.dx,
        push * other.dy,
        push * other.dz,
        pull * other.dx,
        pull * other.dy,
        pull * other.dz,
    )


@compiled
def term(me, other, p):
    """The force of another, -grad U (2): along the line between the two."""
    is_in_range = (other.d2 > 0.0) & (other.d2 <= (RANGE * max(p.l_r, p.l_a)) ** 2)
    d = math.sqrt(where(is_in_range, other.d2, 1.0))
    push = p.C_r / p.l_r * exp(-d / p.l_r)
    pull = p.C_a / p.l_a * exp(-d / p.l_a)
    force = is_in_range * ((pull - push) / d)
    return force * other.dx, force * other.dy, force * other.dz


@compiled
def drive(me, p):
    """(alpha - beta |v|^2) v, the self-propulsion with its friction (1)."""
    gain = (p.alpha - p.beta * me.speed * me.speed) * me.speed
    return gain * me.ux, gain * me.uy, gain * me.uz


@compiled
def answer(me, sums, surroundings, p):
    """m dv/dt = (alpha - beta |v|^2) v - grad U (1)."""
    x, y, z = drive(me, p)
    fx, fy, fz = sums
    return Decision(x + fx, y + fy, z + fz)


around = sums_around(6, force_terms)


@compiled
def explain(me, near, surroundings, p, out):
    """The terms of (1) one by one, in the order of FORCES."""
    out[0, 0], out[0, 1], out[0, 2] = drive(me, p)
    rx, ry, rz, ax, ay, az = around(me, near, p)
    out[1, 0], out[1, 1], out[1, 2] = rx, ry, rz
    out[2, 0], out[2, 1], out[2, 2] = ax, ay, az


@compiled
def weigh(me, near, p, out):
    """How strong the force of each is, over that of the strongest of the two at no distance."""
    strongest = max(p.C_r / p.l_r, p.C_a / p.l_a)
    for j in range(near.n):
        fx, fy, fz = term(me, neighbour_of(me, near, j), p)
        size = math.sqrt(fx * fx + fy * fy + fz * fz)
        out[j] = size / strongest if strongest > 0.0 else 0.0


RULE = Rule(
    name="dorsogna",
    title="D'Orsogna's particles",
    summary="Driven particles that push each other off near by and pull each other from farther "
    "away: they mill, form rings, or keep a lattice, by the shape of the potential.",
    equation=r"m \dot v_i = (\alpha - \beta |v_i|^2)\, v_i - \nabla_i \sum_{j \ne i} "
    r"\Big[C_r e^{-|x_i - x_j| / l_r} - C_a e^{-|x_i - x_j| / l_a}\Big]",
    source="D'Orsogna et al. 2006, (1), (2)",
    tags=("physics", "biology", "milling", "vortex", "fish", "swarm", "Morse potential"),
    parameters=DOrsogna,
    **of_pairs(3, term, answer),
    wish="acceleration",
    reach="range",
    weigh=weigh,
    forces=FORCES,
    explain=explain,
    led=False,
    checked="a catastrophic swarm keeps its radius R, an H-stable one its spacing d: "
    "{dorsogna2006-size#1}; {dorsogna2006-size#4} (`flockscope paper dorsogna2006-size`); "
    "mills where C l^2 < 1: {dorsogna2006#1} (`flockscope paper dorsogna2006`)",
    tries=(
        LessonStep(
            "Give the particles three times the drive.",
            "They are faster, and the ring in which they go round gets wider by a third.",
            {"alpha": 2.4},
            LessonCheck("gyration-radius", "rises", 0.12, 1500),
        ),
        LessonStep(
            "Take the attraction away.",
            "Nothing holds them: they fly apart, each straight on.",
            {"C_a": 0.0},
            LessonCheck("gyration-radius", "above", 20, 1500),
        ),
        LessonStep(
            "Halve the repulsion.",
            "The ring shrinks to about a third.",
            {"C_r": 0.5},
            LessonCheck("gyration-radius", "below", 0.3, 1500),
        ),
    ),
)
