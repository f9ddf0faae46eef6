"""Leadership without signals: some agents know where to go, and nobody knows who they are.

Couzin, Krause, Franks and Levin 2005, Effective leadership and decision-making in animal groups on
the move, Nature 433, 513 to 516. Agents keep apart; with nobody too near they go to those around
and align with them. An informed agent adds the direction that it prefers, with a weight. Agents are
informed by their own numbers: give a kind of agents, or each of them, an `omega` above 0 and a `g`.

Here the sum over headings is over the others alone, and who is too near to somebody goes by nothing
else, its preferred direction neither.
"""

from __future__ import annotations

import math

from agents.engine.noise import cos_sin
from agents.engine.vector_lanes import where
from agents.models.declare import Parameters, Rule, Zone, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.couzin import miss_direction
from agents.rules.terms.sums import of_pairs
from agents.rules.terms.zone_sums import ALL_ROUND, weigh_zones
from worlds.compilation import compiled


class InformedGroups(Parameters):
    """Parameters of Couzin et al. 2005."""

    alpha: float = parameter(
        1.0,
        "Distance within which agents turn away from each other, and do nothing else",
        words="Zone of repulsion",
        symbol="\\alpha",
        unit="length",
        low=0.05,
        high=10.0,
        step=0.05,
        source="Couzin et al. 2005",
    )
    rho: float = parameter(
        6.0,
        "Distance within which agents go to each other and align",
        words="Range of interaction",
        symbol="\\rho",
        unit="length",
        low=0.05,
        high=30.0,
        proposed=(0.5, 15.0),
        step=0.1,
        source="Couzin et al. 2005",
    )
    omega: float = parameter(
        0.0,
        "Weight of the preferred direction beside that of all others, which is 1; 0: the agent is "
        "not informed",
        words="Weight of the preference",
        symbol="\\omega",
        low=0.0,
        high=10.0,
        proposed=(0.0, 2.0),
        step=0.05,
        source="Couzin et al. 2005",
    )
    g: float = parameter(
        0.0,
        "Preferred direction of who is informed, anticlockwise from the x axis",
        words="Preferred direction",
        symbol="g",
        unit="deg",
        low=-360.0,
        high=360.0,
        proposed=(-180.0, 180.0),
        step=5.0,
        source="Couzin et al. 2005",
    )
    sigma: float = parameter(
        0.01,
        "Error: standard deviation of the angle by which the direction is missed",
        words="Error of movement",
        symbol="\\sigma",
        unit="rad",
        low=0.0,
        high=2.0,
        proposed=(0.0, 0.5),
        step=0.01,
        source="Couzin et al. 2005",
        noise=True,
    )

    @property
    def range(self) -> float:
        """The largest distance at which agents notice each other, length."""
        return max(self.alpha, self.rho)


@compiled
def term(me, other, p):
    """Away from those too near; towards and along those within rho: the sums of the paper's d_i."""
    dx, dy = other.dx, other.dy
    is_other = other.d2 > 0.0
    d = math.sqrt(where(is_other, other.d2, 1.0))
    is_close = is_other & (d < p.alpha)
    is_far = is_other & (d >= p.alpha) & (d <= p.rho)
    inverse = 1.0 / d
    away = is_close * inverse
    to = is_far * inverse
    return (
        -away * dx,
        -away * dy,
        to * dx + is_far * other.ux,
        to * dy + is_far * other.uy,
        is_close,
    )


@compiled
def answer(me, sums, surroundings, p):
    """Repulsion first; else the unit vector of the social wish, plus omega times that of g."""
    rx, ry, sx, sy, n = sums
    is_crowded = n > 0.0
    length = math.sqrt(sx * sx + sy * sy)
    is_alone = length < 1e-12
    length = where(is_alone, 1.0, length)
    gx, gy = cos_sin(math.radians(p.g))
    x = where(is_alone, me.ux, sx / length) + p.omega * gx
    y = where(is_alone, me.uy, sy / length) + p.omega * gy
    return miss_direction(me, where(is_crowded, rx, x), where(is_crowded, ry, y), 0.0, p.sigma)


@compiled
def weigh(me, near, p, out):
    """1 for those that count: those too near alone if there are any, else all within rho."""
    weigh_zones(me, near, p.alpha, p.rho, p.rho, ALL_ROUND, ALL_ROUND, out)


RULE = Rule(
    name="leadership",
    title="Leadership of Couzin et al. 2005",
    summary="Agents keep apart, else go to those around and align with them. Those who are "
    "informed add a direction that they prefer; nobody knows who they are, and yet they lead.",
    equation=r"d_i = \begin{cases} -\sum_{|r_{ij}| < \alpha} \hat r_{ij} & \text{if there are any} "
    r"\\ \sum_{|r_{ij}| \le \rho} \big(\hat r_{ij} + u_j\big) & \text{else} \end{cases} \qquad "
    r"d_i' = \hat d_i + \omega_i\, \hat g_i",
    source="Couzin et al. 2005",
    checked="{couzin2005-leadership#2}; two opinions: {couzin2005-leadership#4}; "
    "{couzin2005-leadership#6} (`flockscope paper couzin2005-leadership`)",
    tags=("biology", "classroom", "leaders", "decision", "consensus", "informed", "swarm"),
    parameters=InformedGroups,
    **of_pairs(5, term, answer, by_lanes=True),
    reach="range",
    dimensions=(2,),
    weigh=weigh,
    zones=(
        Zone("repulsion", lambda p: p.alpha, all_round=True),
        Zone("attraction and alignment", lambda p: p.rho, all_round=True),
    ),
    led=False,
    symmetries=("shift",),
    tries=(
        LessonStep(
            "Let everybody be informed: give the preference a weight of 2.",
            "The swarm becomes a group that goes the preferred way, to the right.",
            {"omega": 2.0},
            LessonCheck("polarisation", "above", 0.9, 400),
        ),
        LessonStep(
            "Let agents interact only within 2.",
            "The group comes apart into small ones: nobody is drawn to who is further off.",
            {"rho": 2.0},
            LessonCheck("groups", "above", 4, 400),
            anew=True,
        ),
        LessonStep(
            "Widen the zone of repulsion to 4.",
            "The group blows up: everybody is always too near to somebody.",
            {"alpha": 4.0},
            LessonCheck("gyration-radius", "above", 8, 400),
        ),
    ),
)
