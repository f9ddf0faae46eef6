"""Active Brownian particles that push each other off: the bridge from flocks to physics.

Nobody aligns with anybody. Each particle is driven along its heading, which diffuses on its own
(the body does that), and discs that overlap push each other apart as springs do: Fily and
Marchetti 2012, "Athermal phase separation of self-propelled particles with no alignment", Physical
Review Letters 108, 235702. A free one follows the closed form of Bechinger et al. 2016, "Active
particles in complex and crowded environments", Reviews of Modern Physics 88, 045006.

Crowded, they slow each other down; where they are fast and turn slowly that is enough for them to
come together in dense clusters, without any attraction.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision, is_neighbour, neighbour_of
from agents.engine.vector_lanes import where
from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.sums import of_pairs, sums_around
from worlds.compilation import compiled

FORCES = ("self-propulsion", "repulsion")
"""The terms of the velocity."""


class ActiveBrownian(Parameters):
    """Parameters of active Brownian particles."""

    d: float = parameter(
        1.0,
        "Diameter: particles nearer to each other than this push each other off",
        words="Diameter",
        symbol="d",
        unit="length",
        low=0.05,
        high=10.0,
        step=0.05,
        source="Fily and Marchetti 2012; value chosen here",
    )
    v0: float = parameter(
        1.0,
        "Speed of a free particle",
        words="Speed",
        symbol="v_0",
        unit="length/s",
        low=0.0,
        high=20.0,
        step=0.1,
        source="Fily and Marchetti 2012, (1); value chosen here",
    )
    k: float = parameter(
        50.0,
        "Stiffness: force per length by which two overlap",
        words="Stiffness",
        symbol="k",
        unit="force/length",
        low=0.0,
        high=1000.0,
        step=1.0,
        source="Fily and Marchetti 2012, (1); value chosen here",
    )
    mu: float = parameter(
        1.0,
        "Mobility: speed per force; 0: particles do not feel each other",
        words="Mobility",
        symbol="\\mu",
        unit="length/(s force)",
        low=0.0,
        high=10.0,
        step=0.1,
        source="Fily and Marchetti 2012, (1); value chosen here",
    )


@compiled
def term(me, other, p):
    """F_ij = k (d - r_ij) away from j, within d (1)."""
    touching = is_neighbour(other, p.d)
    r = math.sqrt(where(touching, other.d2, 1.0))
    push = touching * (p.k * (p.d - r) / r)
    return -push * other.dx, -push * other.dy, -push * other.dz


@compiled
def answer(me, sums, surroundings, p):
    """dr_i/dt = v0 u_i + mu sum_j F_ij (1)."""
    x, y, z = sums
    return Decision(p.v0 * me.ux + p.mu * x, p.v0 * me.uy + p.mu * y, p.v0 * me.uz + p.mu * z)


around = sums_around(3, term)


@compiled
def explain(me, near, surroundings, p, out):
    """The terms of the velocity one by one, in the order of FORCES."""
    out[0, 0], out[0, 1], out[0, 2] = p.v0 * me.ux, p.v0 * me.uy, p.v0 * me.uz
    x, y, z = around(me, near, p)
    out[1, 0], out[1, 1], out[1, 2] = p.mu * x, p.mu * y, p.mu * z


@compiled
def weigh(me, near, p, out):
    """How far each overlaps, of the diameter."""
    for j in range(near.n):
        other = neighbour_of(me, near, j)
        overlap = 1.0 - math.sqrt(other.d2) / p.d
        out[j] = overlap if is_neighbour(other, p.d) else 0.0


RULE = Rule(
    name="active-brownian",
    title="Active Brownian particles",
    summary="Driven discs whose headings diffuse and that only push each other off: crowded they "
    "slow down, and come together in clusters without any attraction.",
    equation=r"\dot r_i = v_0 u_i + \mu \sum_{r_{ij} < d} k\,(d - r_{ij})\, \hat r_{ji} + "
    r"\sqrt{2 D_t}\, \xi_i, \qquad \dot\theta_i = \sqrt{2 D_r}\, \eta_i",
    source="Fily and Marchetti 2012, (1); Bechinger et al. 2016",
    tags=(
        "physics",
        "MIPS",
        "motility-induced phase separation",
        "active matter",
        "bacteria",
        "phase transition",
    ),
    parameters=ActiveBrownian,
    **of_pairs(3, term, answer),
    wish="velocity",
    reach="d",
    weigh=weigh,
    forces=FORCES,
    explain=explain,
    led=False,
    checked="the closed form of the mean square displacement of free particles, over which D is "
    "measured: {bechinger2016-msd#10} (`flockscope paper bechinger2016-msd`); crowded ones "
    "lose speed in proportion to the packing, by the slope times it; at packing "
    "{fily2012-speed#5} (`flockscope paper fily2012-speed`)",
    tries=(
        LessonStep(
            "Let particles forget their heading 500 times as fast.",
            "The clusters melt: who turns away again at once does not stay where it is crowded.",
            {"D_r": 5.0},
            LessonCheck("largest-group", "below", 100, 3000),
        ),
        LessonStep(
            "Let particles not feel each other.",
            "They pass through one another, and there are no more clusters than chance makes.",
            {"mu": 0.0},
            LessonCheck("nearest-neighbour", "below", 0.3, 3000),
        ),
        LessonStep(
            "Take 300 particles instead of 1000.",
            "There is room to get out of each other's way, and no large cluster comes about.",
            {"agents": 300},
            LessonCheck("largest-group", "below", 40, 3000),
            anew=True,
        ),
    ),
)
