"""The zones of the thesis, its models 1 and 2: repulsion, orientation, attraction, all in view.

Bachelor's thesis on self-organised flocks of flapping-wing aircraft, sections 3.2 (model 1) and 4.2
(model 2: obstacles). Repulsion is felt only in the field of view, unlike in Couzin et al. 2002.
"""

from __future__ import annotations

from agents.engine.block import Decision
from agents.models.declare import Parameters, Rule, Zone, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.couzin import miss_direction
from agents.rules.terms.neighbour_choice import Nearest
from agents.rules.terms.potential_field import bend_around_obstacles
from agents.rules.terms.zone_sums import edge_of, weigh_zones, zone_sums
from worlds.compilation import compiled


class Zones(Parameters):
    """Parameters of the thesis's zones and of its field round obstacles."""

    d_r: float = parameter(
        1.34,
        "Outer radius of the zone of repulsion",
        words="Zone of repulsion",
        symbol="d_r",
        unit="length",
        low=0.05,
        high=30.0,
        proposed=(0.1, 8.0),
        step=0.02,
        source="thesis, table 5.1",
    )
    d_o: float = parameter(
        2.5,
        "Outer radius of the zone of orientation",
        words="Zone of orientation",
        symbol="d_o",
        unit="length",
        low=0.05,
        high=30.0,
        proposed=(0.1, 10.0),
        step=0.1,
        source="thesis, table 5.1",
    )
    d_a: float = parameter(
        5.0,
        "Outer radius of the zone of attraction",
        words="Zone of attraction",
        symbol="d_a",
        unit="length",
        low=0.05,
        high=30.0,
        proposed=(0.2, 20.0),
        step=0.1,
        source="thesis, table 5.1",
    )
    alpha: float = parameter(
        90.0,
        "Field of view: agents outside of this full angle about the heading are not seen",
        words="Field of view",
        symbol="\\alpha",
        unit="deg",
        low=0.0,
        high=360.0,
        step=5.0,
        source="thesis, table 5.1",
    )
    sigma: float = parameter(
        0.0,
        "Noise: standard deviation of the angle by which the direction is missed",
        words="Noise",
        symbol="\\sigma",
        unit="rad",
        low=0.0,
        high=2.0,
        proposed=(0.0, 1.0),
        step=0.01,
        source="the thesis has none; as in Couzin et al. 2002",
    )
    gain: float = parameter(
        10.0,
        "Gain of the field round obstacles",
        words="Field round obstacles",
        symbol="\\eta",
        unit="mass length^4/s^2",
        low=0.0,
        high=1000.0,
        step=0.5,
        source="thesis (4.1), which gives no value; this one works",
    )
    Q: float = parameter(
        5.0,
        "Range of the field round obstacles",
        words="Range of that field",
        symbol="Q^*",
        unit="length",
        low=0.05,
        high=30.0,
        proposed=(0.2, 15.0),
        step=0.1,
        source="thesis (4.1), which gives no value; this one works",
    )
    m: float = parameter(
        1.0,
        "Mass of an agent",
        words="Mass",
        symbol="m",
        unit="mass",
        low=0.01,
        high=100.0,
        step=0.1,
        source="thesis (4.2), which gives no value",
    )

    @property
    def range(self) -> float:
        """The largest distance at which agents notice each other, length."""
        return max(self.d_r, self.d_o, self.d_a)

    @property
    def sight(self) -> float:
        """The largest distance at which obstacles are noticed, length."""
        return self.Q + 0.5 * getattr(self, "body", 0.0)


class ZonesAmong(Nearest, Zones):
    """The same, and who the neighbours are."""


@compiled
def decide(me, near, surroundings, p):
    """Repulsion first (3.9); else orientation (3.10), attraction (3.11) or their mean (3.12)."""
    edge = edge_of(p.alpha)
    s = zone_sums(me, near, p.d_r, p.d_o, p.d_a, edge, edge)
    if s.n_r > 0.0:
        to = miss_direction(me, s.rx, s.ry, s.rz, p.sigma)
    else:
        to = miss_direction(me, s.ox + s.ax, s.oy + s.ay, s.oz + s.az, p.sigma)
    x, y, z = bend_around_obstacles(me, to.x, to.y, to.z, surroundings, p)
    return Decision(x, y, z)


@compiled
def weigh(me, near, p, out):
    """1 for those that count: the zone of repulsion alone if anyone is in it, else the others."""
    edge = edge_of(p.alpha)
    weigh_zones(me, near, p.d_r, p.d_o, p.d_a, edge, edge, out)


REPELLED_ALL_ROUND = (
    Zone("repulsion", lambda p: p.d_r, all_round=True),
    Zone("orientation", lambda p: p.d_o),
    Zone("attraction", lambda p: p.d_a),
)
"""The zones of the rules that feel repulsion all round, as Couzin et al. 2002 do."""

ZONES = Rule(
    name="thesis",
    title="Zones of the thesis",
    summary="Flapping-wing aircraft keep away from those in the zone of repulsion, else align with "
    "those in the zone of orientation and go to those in the zone of attraction, all as far as "
    "they see them; obstacles ahead push them off. As in the thesis bodies are only looked at as "
    "the run starts: later ones fly through each other.",
    equation=r"v_i = \begin{cases} -\sum_{j \in zor} \hat{r}_{ij} & n_r > 0 \\ "
    r"\tfrac12\big(\sum_{j \in zoo} \tfrac{v_j}{|v_j|} + \sum_{j \in zoa} \hat{r}_{ij}\big) & "
    r"\text{else} \end{cases} \quad v_i' = v_0 \frac{v_i}{|v_i|} + \frac{\tau}{m} \sum_k "
    r"-\nabla \tfrac{\eta}{2} \Big(\frac1{D_k} - \frac1{Q^*}\Big)^2",
    source="thesis, (3.6) to (3.12), (4.1), (4.2)",
    checked="figure 5.4, {thesis-fig5.4#1}; {thesis-fig5.4#4} (`flockscope paper thesis-fig5.4`)",
    tags=("robotics", "biology", "birds", "flapping wings", "field of view", "swarm"),
    parameters=ZonesAmong,
    decide=decide,
    wish="velocity",
    reach="range",
    bound="d_a",
    together="d_a",
    weigh=weigh,
    zones=(
        Zone("repulsion", lambda p: p.d_r),
        Zone("orientation", lambda p: p.d_o),
        Zone("attraction", lambda p: p.d_a),
    ),
    view="alpha",
    sees_obstacles=True,
    led=False,
    tries=(
        LessonStep(
            "Let them see all round.",
            "They keep apart, since now they also notice who comes from behind, and are one "
            "flock or two.",
            {"alpha": 360.0},
            LessonCheck("nearest-neighbour", "above", 0.25, 300),
        ),
        LessonStep(
            "Let bodies be solid all the time.",
            "Most of the flock crashes: what the thesis counts at the start only goes on all "
            "along.",
            {"contact": "always"},
            LessonCheck("crashes", "above", 25, 300),
            anew=True,
        ),
        LessonStep(
            "Take the zone of attraction away.",
            "Nothing brings them back together: some thirty groups of one or a few.",
            {"d_a": 2.5},
            LessonCheck("groups", "above", 18, 300),
            anew=True,
        ),
    ),
)
