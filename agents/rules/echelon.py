"""Echelons: Couzin's zones, and a bird that seeks the upwash slot beside one ahead of it.

The zones are those of Couzin et al. 2002. Added is what the thesis speaks of and does not have: a
slot is the place `step` spans behind a bird, at its height, with wing tips at the spacing at which
its upwash saves most (thesis 2.3). Birds line up slot by slot into echelons and Vs.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision
from agents.models.declare import Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.couzin import missed
from agents.rules.terms.potential_field import push
from agents.rules.terms.slots import closing_up, nearest_slot
from agents.rules.terms.zone_sums import ALL_ROUND, edge_of, weigh_zones, zone_sums
from agents.rules.zones import REPELLED_ALL_ROUND, Zones
from worlds.compilation import compiled


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
def in_length(me, x, y, z, length):
    """The vector brought to a length; without a direction along the heading."""
    now = math.sqrt(x * x + y * y + z * z)
    if now < 1e-12:
        return Decision(length * me.ux, length * me.uy, length * me.uz)
    return Decision(length * x / now, length * y / now, length * z / now)


@compiled
def levelled(x, y, z, climb):
    """The third component of a direction that is to be no steeper than `climb` (deg)."""
    most = math.tan(math.radians(climb)) * math.sqrt(x * x + y * y)
    return min(max(z, -most), most)


@compiled
def decide(me, near, surroundings, p):
    """Repulsion first; else by weight w the slot, or dropping back if none is free, and the zones.

    A bird that sees nobody ahead leads and follows the zones alone. Obstacles push as in the
    thesis's model 2.
    """
    s = zone_sums(me, near, p.d_r, p.d_o, p.d_a, ALL_ROUND, edge_of(p.alpha))
    close = s.n_r > 0.0
    to = Decision(s.rx, s.ry, s.rz) if close else Decision(s.ox + s.ax, s.oy + s.ay, s.oz + s.az)
    to = in_length(me, to.x, to.y, to.z, p.v0)
    if p.w > 0.0 and not close:
        slot = nearest_slot(me, near, p)
        if slot.seen:
            x, y, z = s.ox + me.ux, s.oy + me.uy, s.oz + me.uz
            other = in_length(me, x, y, z, p.drop * p.v0)
            if slot.ahead >= 0:
                x, y, z = closing_up(near, slot, p)
                other = Decision(x, y, z)
            q = 1.0 - p.w
            to = Decision(
                q * to.x + p.w * other.x, q * to.y + p.w * other.y, q * to.z + p.w * other.z
            )
    pace = math.sqrt(to.x * to.x + to.y * to.y + to.z * to.z)
    to = missed(me, to.x, to.y, to.z, p.sigma)
    z = levelled(to.x, to.y, to.z, p.climb)
    fx, fy, fz = push(me, surroundings, p)
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
    checked="formations save power: {formation-echelon#1} (`uv run flockscope paper "
    "formation-echelon`)",
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
            LessonCheck("drag-saved", "below", 15, 600),
            anew=True,
        ),
    ),
)
