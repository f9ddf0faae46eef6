"""Echelons: Couzin's zones, and a bird that seeks the upwash slot beside one ahead of it.

The zones are those of Couzin et al. 2002. Added is what the thesis speaks of and does not have: a
slot is the place `step` spans behind a bird, at its height, with wing tips at the spacing at which
its upwash saves most (thesis 2.3). Birds line up slot by slot into echelons and Vs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from agents.engine.block import Decision
from agents.models.declare import Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.couzin import miss_direction
from agents.rules.terms.potential_field import obstacle_force
from agents.rules.terms.zone_sums import ALL_ROUND, edge_of, weigh_zones, zone_sums
from agents.rules.zones import REPELLED_ALL_ROUND, Zones
from worlds.compilation import compiled

# The upwash slots beside the birds ahead, and how a bird closes up to one.
#
# A slot is the place `step` spans behind a bird, on its line of flight's height, where the wing
# tips are at the spacing `tip` (thesis, 2.3).

CLOSE, LONG = 0.6, 4.0
"""How near to a slot a bird takes it, and how far behind a bird its downwash spoils it, spans."""
PARALLEL = math.cos(math.radians(45.0))
"""Least cosine of the angle to the heading of a bird that is followed."""
LEVEL = 1e-12
"""Square of the level part of a heading from which on it has a left and a right."""


class Slot(NamedTuple):
    """The slot that a bird goes for, and the bird ahead beside which it is."""

    ahead: int
    """Its place in the block; -1 for no slot."""
    seen: bool
    """Whether there is a bird ahead at all."""
    x: float
    """From this bird to the slot."""
    y: float
    z: float


@compiled
def is_free(me, near, ahead, x, y, z, apart2, b):
    """Whether the slot at (x, y, z) beside the bird `ahead` is free for this one.

    It is taken by a bird within 0.6 spans `b` of it that is nearer to it than this one (`apart2` is
    the square of this one's distance). It is spoilt by the downwash of a bird if it lies straight
    behind that one: within 4 spans, and less than 0.6 spans off its line of flight.
    """
    close2 = (CLOSE * b) ** 2
    against = 0.0
    for k in range(near.n):
        ex, ey, ez = x - near.x[k], y - near.y[k], z - near.z[k]
        mx, my, mz = me.x - near.x[k], me.y - near.y[k], me.z - near.z[k]
        d2 = ex * ex + ey * ey + ez * ez
        lag = -(ex * near.ux[k] + ey * near.uy[k] + ez * near.uz[k])
        other = (mx * mx + my * my + mz * mz > 0.0) & (k != ahead)
        is_taken = (d2 < close2) & (d2 < apart2)
        spoilt = (lag > 0.0) & (lag < LONG * b) & (d2 - lag * lag < close2)
        against += 1.0 if other & (is_taken | spoilt) else 0.0
    return against == 0.0


@compiled
def nearest_slot(me, near, p):
    """The nearest free slot beside a bird ahead that is seen and flies about the same way.

    Ahead is where that bird is further on along its own heading; slots are to its left and right.
    """
    edge = edge_of(p.alpha)
    side_step, back_step = (1.0 + p.tip) * p.b, p.step * p.b
    best = math.inf
    ahead, seen = -1, False
    x = y = z = 0.0
    for j in range(near.n):
        ux, uy, uz = near.ux[j], near.uy[j], near.uz[j]
        dx, dy, dz = near.x[j] - me.x, near.y[j] - me.y, near.z[j] - me.z
        d2 = dx * dx + dy * dy + dz * dz
        level2 = ux * ux + uy * uy
        followed = (
            (d2 > 0.0)
            & (d2 <= p.d_a * p.d_a)
            & (dx * ux + dy * uy + dz * uz > 0.0)
            & (ux * me.ux + uy * me.uy + uz * me.uz >= PARALLEL)
            & (dx * me.ux + dy * me.uy + dz * me.uz >= edge * math.sqrt(d2))
            & (level2 > LEVEL)
        )
        if followed:
            seen = True
            level = math.sqrt(level2)
            for side in (-1.0, 1.0):
                sx = dx - back_step * ux + side * side_step * uy / level
                sy = dy - back_step * uy - side * side_step * ux / level
                sz = dz - back_step * uz
                a2 = sx * sx + sy * sy + sz * sz
                if a2 < best and is_free(me, near, j, me.x + sx, me.y + sy, me.z + sz, a2, p.b):
                    best, ahead, x, y, z = a2, j, sx, sy, sz
    return Slot(ahead, seen, x, y, z)


@compiled
def approach_slot(near, slot, p):
    """Velocity wished for: that of the bird ahead, and towards the slot, slower once it is near."""
    pace = near.speed[slot.ahead]
    distance = math.sqrt(slot.x * slot.x + slot.y * slot.y + slot.z * slot.z)
    rate = min(1.0 / p.t_c, p.c / max(distance, 1e-12))
    return (
        pace * near.ux[slot.ahead] + rate * slot.x,
        pace * near.uy[slot.ahead] + rate * slot.y,
        pace * near.uz[slot.ahead] + rate * slot.z,
    )


class Echelon(Zones):
    """Parameters of the zones, of the field round obstacles, and of the search for a slot."""

    d_r: float = parameter(
        1.8,
        "Outer radius of the zone of repulsion, all round",
        words="Zone of repulsion",
        symbol="d_r",
        unit="length",
        low=0.05,
        high=30.0,
        step=0.05,
        source="ours: less than the distance of a slot",
    )
    d_o: float = parameter(
        12.0,
        "Outer radius of the zone of orientation",
        words="Zone of orientation",
        symbol="d_o",
        unit="length",
        low=0.05,
        high=100.0,
        proposed=(0.5, 40.0),
        step=0.1,
        source="ours",
    )
    d_a: float = parameter(
        20.0,
        "Outer radius of the zone of attraction, and how far off slots are noticed",
        words="Zone of attraction",
        symbol="d_a",
        unit="length",
        low=0.05,
        high=100.0,
        proposed=(1.0, 60.0),
        step=0.1,
        source="ours: as far as the end of an arm of nine birds",
    )
    alpha: float = parameter(
        200.0,
        "Field of view: agents outside of this full angle about the heading are not seen",
        words="Field of view",
        symbol="\\alpha",
        unit="deg",
        low=0.0,
        high=360.0,
        step=5.0,
        source="ours: less than twice the 133 deg off its heading at which followers fly",
    )
    sigma: float = parameter(
        0.01,
        "Error of movement: standard deviation of the angle by which the direction is missed",
        words="Error of movement",
        symbol="\\sigma",
        unit="rad",
        low=0.0,
        high=2.0,
        proposed=(0.0, 0.5),
        step=0.01,
        source="as in Couzin et al. 2002; value ours",
        noise=True,
    )
    climb: float = parameter(
        15.0,
        "Steepest climb or dive that is wished for",
        words="Steepest climb",
        symbol="\\gamma",
        unit="deg",
        low=0.0,
        high=90.0,
        proposed=(0.0, 60.0),
        step=1.0,
        source="ours: wings are of use to others only if they are about level",
    )
    w: float = parameter(
        1.0,
        "Weight of the slot beside the zones; 0: the zones alone",
        words="Weight of the slot",
        symbol="w",
        low=0.0,
        high=1.0,
        step=0.05,
        source="ours",
    )
    tip: float = parameter(
        -0.137,
        "Wing-tip spacing of a slot, in spans; negative where wings overlap",
        words="Wing-tip spacing",
        symbol="WTS / b",
        low=-0.5,
        high=3.0,
        proposed=(-0.5, 1.0),
        step=0.01,
        source="where a vortex pair with cores of 0.04 b saves most; -0.107 in the thesis, (2.8)",
    )
    drop: float = parameter(
        0.94,
        "Speed at which a bird drops back that sees birds ahead but no free slot, of v_0",
        words="Speed of dropping back",
        symbol="v_b / v_0",
        low=0.1,
        high=1.0,
        step=0.01,
        source="ours",
    )
    step: float = parameter(
        0.8,
        "How far behind the other a slot is, in spans",
        words="Distance of a slot",
        symbol="\\ell / b",
        low=0.1,
        high=4.0,
        step=0.05,
        source="ours",
    )
    t_c: float = parameter(
        1.5,
        "Time in which a bird wishes to close up to its slot",
        words="Time to close up",
        symbol="t_c",
        unit="s",
        low=0.1,
        high=20.0,
        step=0.1,
        source="ours",
    )
    c: float = parameter(
        1.5,
        "Largest speed at which it wishes to close up",
        words="Speed of closing up",
        symbol="c",
        unit="length/s",
        low=0.0,
        high=20.0,
        step=0.1,
        source="ours",
    )


@compiled
def scale_to_length(me, x, y, z, length):
    """The vector brought to a length; without a direction along the heading."""
    current_length = math.sqrt(x * x + y * y + z * z)
    if current_length < 1e-12:
        return Decision(length * me.ux, length * me.uy, length * me.uz)
    return Decision(
        length * x / current_length, length * y / current_length, length * z / current_length
    )


@compiled
def limit_climb(x, y, z, climb):
    """The third component of a direction that is to be no steeper than `climb` (deg)."""
    steepest = math.tan(math.radians(climb)) * math.sqrt(x * x + y * y)
    return min(max(z, -steepest), steepest)


@compiled
def decide(me, near, surroundings, p):
    """Repulsion first; else by weight w the slot, or dropping back if none is free, and the zones.

    A bird that sees nobody ahead leads and follows the zones alone. Obstacles push as in the
    thesis's model 2.
    """
    s = zone_sums(me, near, p.d_r, p.d_o, p.d_a, ALL_ROUND, edge_of(p.alpha))
    has_repulsion = s.n_r > 0.0
    to = (
        Decision(s.rx, s.ry, s.rz)
        if has_repulsion
        else Decision(s.ox + s.ax, s.oy + s.ay, s.oz + s.az)
    )
    to = scale_to_length(me, to.x, to.y, to.z, p.v0)
    if p.w > 0.0 and not has_repulsion:
        slot = nearest_slot(me, near, p)
        if slot.seen:
            x, y, z = s.ox + me.ux, s.oy + me.uy, s.oz + me.uz
            other = scale_to_length(me, x, y, z, p.drop * p.v0)
            if slot.ahead >= 0:
                x, y, z = approach_slot(near, slot, p)
                other = Decision(x, y, z)
            q = 1.0 - p.w
            to = Decision(
                q * to.x + p.w * other.x, q * to.y + p.w * other.y, q * to.z + p.w * other.z
            )
    pace = math.sqrt(to.x * to.x + to.y * to.y + to.z * to.z)
    to = miss_direction(me, to.x, to.y, to.z, p.sigma)
    z = limit_climb(to.x, to.y, to.z, p.climb)
    fx, fy, fz = obstacle_force(me, surroundings, p)
    share = p.tau / p.m
    return Decision(pace * to.x + share * fx, pace * to.y + share * fy, pace * z + share * fz)


@compiled
def weigh(me, near, p, out):
    """1 for those of the zones that count; beside a slot 1 - w, and w for the bird ahead."""
    edge = edge_of(p.alpha)
    weigh_zones(me, near, p.d_r, p.d_o, p.d_a, ALL_ROUND, edge, out)
    s = zone_sums(me, near, p.d_r, p.d_o, p.d_a, ALL_ROUND, edge)
    if s.n_r == 0.0:
        slot = nearest_slot(me, near, p)
        if slot.ahead >= 0:
            for j in range(near.n):
                out[j] *= 1.0 - p.w
            out[slot.ahead] += p.w


ECHELON = Rule(
    name="echelon",
    title="Echelons",
    summary="Couzin's zones for birds that also seek the slot beside one ahead, where its upwash "
    "carries them: they line up into echelons and Vs and save energy.",
    equation=r"v_i = (1 - w)\, v_0 \hat d_i + w \Big(v_j + \min\Big(\frac{1}{t_c}, "
    r"\frac{c}{|s_i|}\Big) s_i\Big), \qquad s_i = x_j - \ell\, u_j \pm (b + WTS)\, r_j - x_i",
    source="Couzin et al. 2002, (1) to (3); slots after the thesis, 2.3; their search is ours",
    checked="formations save power: {formation-echelon#1} (`flockscope paper formation-echelon`)",
    tags=("biology", "birds", "geese", "V formation", "energy", "migration"),
    parameters=Echelon,
    decide=decide,
    wish="velocity",
    reach="range",
    together="d_a",
    weigh=weigh,
    zones=REPELLED_ALL_ROUND,
    view="alpha",
    sees_obstacles=True,
    led=False,
    tries=(
        LessonStep(
            "Let nobody seek a slot.",
            "They still fly one way, but in each other's downwash: drag is lost instead of saved.",
            {"w": 0.0},
            LessonCheck("drag-saved", "below", 0, 600),
            anew=True,
        ),
        LessonStep(
            "Put the slots a whole span further out.",
            "The lines are wide, and save less: beside the wing tip the upwash is best.",
            {"tip": 1.0},
            LessonCheck("drag-saved", "below", 18, 600),
            anew=True,
        ),
        LessonStep(
            "Let everybody miss its direction by half a radian.",
            "Nobody stays in the slot: most of the saving is lost.",
            {"sigma": 0.5},
            LessonCheck("drag-saved", "below", 20, 600),
            anew=True,
        ),
    ),
)
