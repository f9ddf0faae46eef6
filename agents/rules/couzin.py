"""Couzin's zones: repulsion from agents too near, else alignment and attraction.

Couzin, Krause, James, Ruxton and Franks 2002, Collective memory and spatial sorting in animal
groups, J. theor. Biol. 218, 1 to 11. Repulsion is felt all round; orientation and attraction only
in the field of view.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision
from agents.engine.noise import cos_sin, normal, uniform
from agents.engine.own_parameters import may_be_positive
from agents.engine.vector_lanes import where
from agents.models.declare import Parameters, Rule, Zone, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.neighbour_choice import Nearest
from agents.rules.terms.sums import of_pairs
from agents.rules.terms.zone_sums import ALL_ROUND, ZONE_SUMS, edge_of, weigh_zones, zone_terms
from worlds.compilation import compiled

MISS, ROLL = 4, 6
"""Draws of the rule's own noise, of which the first takes two."""


class Couzin(Parameters):
    """Parameters of Couzin's zones."""

    r_r: float = parameter(
        1.0,
        "Radius of the zone of repulsion",
        words="Zone of repulsion",
        symbol="r_r",
        unit="length",
        low=0.05,
        high=10.0,
        step=0.05,
        source="Couzin et al. 2002, table 1",
    )
    dr_o: float = parameter(
        3.0,
        "Width of the zone of orientation, beyond that of repulsion",
        words="Width of orientation",
        symbol="\\Delta r_o",
        unit="length",
        low=0.0,
        high=30.0,
        proposed=(0.0, 15.0),
        step=0.1,
        source="Couzin et al. 2002, table 1",
    )
    dr_a: float = parameter(
        10.0,
        "Width of the zone of attraction, beyond that of orientation",
        words="Width of attraction",
        symbol="\\Delta r_a",
        unit="length",
        low=0.0,
        high=30.0,
        step=0.1,
        source="Couzin et al. 2002, table 1",
    )
    alpha: float = parameter(
        270.0,
        "Field of view: agents outside of this full angle about the heading are not seen",
        words="Field of view",
        symbol="\\alpha",
        unit="deg",
        low=0.0,
        high=360.0,
        step=5.0,
        source="Couzin et al. 2002, table 1",
    )
    sigma: float = parameter(
        0.05,
        "Error of movement: standard deviation of the angle by which the direction is missed",
        words="Error of movement",
        symbol="\\sigma",
        unit="rad",
        low=0.0,
        high=2.0,
        proposed=(0.0, 0.5),
        step=0.01,
        source="Couzin et al. 2002, table 1",
        noise=True,
    )

    @property
    def range(self) -> float:
        """Outer radius r_a of the zone of attraction, length."""
        return self.r_r + self.dr_o + self.dr_a


class CouzinAmong(Nearest, Couzin):
    """The same, and who the neighbours are."""


@compiled
def term(me, other, p):
    """The terms of (1), (2) and (3): away from those too near, headings, towards those far off."""
    r_o = p.r_r + p.dr_o
    return zone_terms(me, other, p.r_r, r_o, r_o + p.dr_a, ALL_ROUND, edge_of(p.alpha))


@compiled
def miss_direction(me, x, y, z, sigma):
    """The direction turned by a normal angle of deviation sigma (rad), to any side."""
    length = math.sqrt(x * x + y * y + z * z)
    is_zero = length < 1e-12
    length = where(is_zero, 1.0, length)
    x, y, z = (
        where(is_zero, me.ux, x / length),
        where(is_zero, me.uy, y / length),
        where(is_zero, me.uz, z / length),
    )
    if not may_be_positive(sigma):
        return Decision(x, y, z)
    # An orthonormal pair across the direction (Duff et al. 2017), and a side by chance.
    sign = where(z < 0.0, -1.0, 1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    cr, sr = cos_sin(2.0 * math.pi * uniform(me.key, me.id, ROLL))
    sx, sy, sz = (
        cr * (1.0 + sign * x * x * a) + sr * b,
        cr * sign * b + sr * (sign + y * y * a),
        -cr * sign * x - sr * y,
    )
    flat = (z == 0.0) & (me.uz == 0.0)
    sx, sy, sz = where(flat, -y, sx), where(flat, x, sy), where(flat, 0.0, sz)
    c, s = cos_sin(sigma * normal(me.key, me.id, MISS))
    return Decision(c * x + s * sx, c * y + s * sy, c * z + s * sz)


@compiled
def answer(me, sums, surroundings, p):
    """Repulsion first (1); else orientation (2), attraction (3) or the mean of both."""
    rx, ry, rz, ox, oy, oz, ax, ay, az, n_r, _, _ = sums
    has_repulsion = n_r > 0.0
    x, y, z = (
        where(has_repulsion, rx, ox + ax),
        where(has_repulsion, ry, oy + ay),
        where(has_repulsion, rz, oz + az),
    )
    return miss_direction(me, x, y, z, p.sigma)


@compiled
def weigh(me, near, p, out):
    """1 for those that count: the zone of repulsion alone if anyone is in it, else the others."""
    r_o = p.r_r + p.dr_o
    weigh_zones(me, near, p.r_r, r_o, r_o + p.dr_a, ALL_ROUND, edge_of(p.alpha), out)


COUZIN = Rule(
    name="couzin",
    title="Couzin's zones",
    summary="Agents keep away from those in the zone of repulsion; with nobody there they align "
    "with those in the zone of orientation and go to those in the zone of attraction.",
    equation=r"d_i = \begin{cases} -\sum_{j \in Z_r} \hat{r}_{ij} & n_r > 0 \\ "
    r"\sum_{j \in Z_o} u_j + \sum_{j \in Z_a} \hat{r}_{ij} & "
    r"\text{else} \end{cases}",
    source="Couzin et al. 2002, (1) to (3)",
    checked="{couzin2002-phases#2}; {couzin2002-phases#5} (`flockscope paper couzin2002-phases`)",
    tags=(
        "biology",
        "classroom",
        "fish",
        "school",
        "shoal",
        "milling",
        "vortex",
        "collective memory",
        "swarm",
    ),
    form="fish",
    parameters=CouzinAmong,
    **of_pairs(ZONE_SUMS, term, answer, by_lanes=True),
    sifts=True,
    reach="range",
    bound="dr_a",
    weigh=weigh,
    zones=(
        Zone("repulsion", lambda p: p.r_r, all_round=True),
        Zone("orientation", lambda p: p.r_r + p.dr_o),
        Zone("attraction", lambda p: p.range),
    ),
    view="alpha",
    tries=(
        LessonStep(
            "Take the zone of orientation away.",
            "A swarm: agents stay together and go nowhere, with every heading among them.",
            {"dr_o": 0.0},
            LessonCheck("polarisation", "below", 0.33, 400),
            anew=True,
        ),
        LessonStep(
            "Widen the zone of orientation to 9.",
            "The group goes straight on as one: highly parallel.",
            {"dr_o": 9.0},
            LessonCheck("polarisation", "above", 0.97, 400),
        ),
        LessonStep(
            "Widen the zone of repulsion to 4.",
            "The group blows up: everybody is always too near to somebody, and no heading lasts.",
            {"r_r": 4.0},
            LessonCheck("gyration-radius", "above", 10, 400),
        ),
    ),
)
