"""The thesis's zones made safe: repulsion all round, and of those about to come near.

What was added to the thesis's rule (`agents.rules.zones`): repulsion is felt all round, as in
Couzin et al. 2002; a neighbour that is about to come close counts as one in the zone of repulsion;
repulsion weighs the more the more urgent it is; and it is added to orientation and attraction
instead of silencing them. Obstacles push as in the thesis.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision
from agents.models.declare import Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.couzin import miss_direction
from agents.rules.terms.neighbour_choice import Nearest
from agents.rules.terms.potential_field import obstacle_force
from agents.rules.terms.zone_sums import edge_of, zone_sums
from agents.rules.zones import REPELLED_ALL_ROUND, Zones
from worlds.compilation import compiled

MOST = 10.0
"""Largest weight of a neighbour: one in the same place, or due there within 0.1 s."""


class SafeZones(Nearest, Zones):
    """Parameters of the safe zones: the thesis's, and those of anticipation."""

    d_s: float = parameter(
        5.0,
        "Distance within which approaches are foreseen",
        words="Distance of foresight",
        symbol="d_s",
        unit="length",
        low=0.0,
        high=30.0,
        proposed=(0.0, 20.0),
        step=0.1,
        source="ours",
    )
    t_s: float = parameter(
        1.5,
        "How far ahead approaches are foreseen",
        words="Time of foresight",
        symbol="t_s",
        unit="s",
        low=0.0,
        high=10.0,
        proposed=(0.0, 5.0),
        step=0.1,
        source="ours",
    )
    miss: float = parameter(
        1.1,
        "Foreseen distance below which an approach counts",
        words="Distance that is too near",
        symbol="d_m",
        unit="length",
        low=0.0,
        high=10.0,
        step=0.05,
        source="ours",
    )
    g: float = parameter(
        1.0,
        "Weight of the direction of orientation and attraction beside repulsion",
        words="Weight beside repulsion",
        symbol="g",
        low=0.0,
        high=10.0,
        step=0.1,
        source="ours",
    )

    @property
    def range(self) -> float:
        """The largest distance at which agents notice each other, length."""
        return max(self.d_r, self.d_o, self.d_a, self.d_s)


@compiled
def avoidance(me, near, p):
    """Away from those that are too near, and from those that are about to be, by urgency.

    Weights are 10 (1 - D / d_r) within d_r; and 1 / t_c, at most 10, for those within d_s that come
    nearer than d_m at a time t_c in (0, t_s], all keeping their velocities.
    """
    speed = near.speed
    vx, vy, vz = me.speed * me.ux, me.speed * me.uy, me.speed * me.uz
    x = y = z = 0.0
    for j in range(near.n):
        dx = near.x[j] - me.x
        dy = near.y[j] - me.y
        dz = near.z[j] - me.z
        d2 = dx * dx + dy * dy + dz * dz
        d = math.sqrt(d2) if d2 > 0.0 else 1.0
        wx = speed[j] * near.ux[j] - vx
        wy = speed[j] * near.uy[j] - vy
        wz = speed[j] * near.uz[j] - vz
        w2 = wx * wx + wy * wy + wz * wz
        t = -(dx * wx + dy * wy + dz * wz) / (w2 if w2 > 1e-12 else 1.0)
        cx, cy, cz = dx + t * wx, dy + t * wy, dz + t * wz
        missed2 = cx * cx + cy * cy + cz * cz
        is_other = d2 > 0.0
        closeness = MOST * (1.0 - d / p.d_r) if is_other & (d < p.d_r) else 0.0
        meets_soon = is_other & (d <= p.d_s) & (w2 > 1e-12) & (t > 0.0) & (t <= p.t_s)
        meets_soon = meets_soon & (missed2 < p.miss * p.miss)
        weight = closeness + (1.0 / max(t, 1.0 / MOST) if meets_soon else 0.0)
        x -= weight * dx / d
        y -= weight * dy / d
        z -= weight * dz / d
    return x, y, z


@compiled
def decide(me, near, surroundings, p):
    """Avoidance, and g times the direction of orientation and attraction."""
    s = zone_sums(me, near, p.d_r, p.d_o, p.d_a, edge_of(p.alpha), edge_of(p.alpha))
    fx, fy, fz = s.ox + s.ax, s.oy + s.ay, s.oz + s.az
    length = math.sqrt(fx * fx + fy * fy + fz * fz)
    share = p.g / length if length > 1e-12 else 0.0
    x, y, z = avoidance(me, near, p)
    bx, by, bz = obstacle_force(me, surroundings, p)
    field = p.tau / (p.m * max(p.v0, 1e-6))
    x, y, z = x + share * fx + field * bx, y + share * fy + field * by, z + share * fz + field * bz
    to = miss_direction(me, x, y, z, p.sigma)
    return Decision(p.v0 * to.x, p.v0 * to.y, p.v0 * to.z)


@compiled
def weigh(me, near, p, out):
    """1 for those in the zone of repulsion, and for those that are seen in the others."""
    edge = edge_of(p.alpha)
    for j in range(near.n):
        dx, dy, dz = near.x[j] - me.x, near.y[j] - me.y, near.z[j] - me.z
        d = math.sqrt(dx * dx + dy * dy + dz * dz)
        is_visible = dx * me.ux + dy * me.uy + dz * me.uz >= edge * d
        out[j] = 1.0 if 0.0 < d < p.d_r or (is_visible and p.d_r <= d <= max(p.d_o, p.d_a)) else 0.0


SAFE = Rule(
    name="safe",
    title="Zones of the thesis, made safe",
    summary="The thesis's zones for bodies that stay solid. Added to the thesis: repulsion is felt "
    "all round and weighs by urgency, a neighbour about to come close counts as one that is close, "
    "and flocking goes on beside it.",
    equation=r"v_i = -10 \sum_{D_{ij} < d_r} \Big(1 - \frac{D_{ij}}{d_r}\Big) \hat r_{ij} - "
    r"\sum_{\text{soon}} \min\Big(10, \frac{1}{t_c}\Big) \hat r_{ij} + g \, "
    r"\frac{\sum_{zoo} \hat v_j + \sum_{zoa} \hat r_{ij}}{|\cdot|}",
    source="thesis, (3.6) to (3.12), (4.1), (4.2); repulsion is ours",
    checked="table 5.1, no crash later on, {thesis-table5.1#4} (`flockscope paper "
    "thesis-table5.1`)",
    tags=("robotics", "birds", "flapping wings", "field of view", "collisions", "swarm"),
    parameters=SafeZones,
    decide=decide,
    wish="velocity",
    reach="range",
    bound="d_a",
    together="d_a",
    weigh=weigh,
    zones=REPELLED_ALL_ROUND,
    view="alpha",
    sees_obstacles=True,
    led=False,
    tries=(
        LessonStep(
            "Let nobody look ahead.",
            "Many crash: who only keeps clear of those that are near already comes too late.",
            {"t_s": 0.0},
            LessonCheck("crashes", "above", 10, 300),
            anew=True,
        ),
        LessonStep(
            "Let them avoid each other, and nothing else.",
            "The flock scatters into a dozen groups and more.",
            {"g": 0.0},
            LessonCheck("groups", "above", 9, 300),
            anew=True,
        ),
        LessonStep(
            "Let them see 270 degrees instead of 90.",
            "They find together into one to three close groups.",
            {"alpha": 270.0},
            LessonCheck("mean-neighbours", "above", 17, 300),
            anew=True,
        ),
    ),
)
