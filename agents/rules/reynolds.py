"""Boids: separation, alignment, cohesion, and steering clear of what is ahead.

Reynolds 1987, "Flocks, herds, and schools: a distributed behavioral model", SIGGRAPH, and Reynolds
1999, "Steering behaviors for autonomous characters", GDC. The steering forces are weighted and
summed, one of the ways that Reynolds names; the body cuts the sum at max_force.

Reynolds 1999 advises to normalise the forces before they are weighted. Here each is divided by a
scale of its own instead and cut at length 1, so that a boid that has what it wants is not shaken by
the direction of a tiny force. The papers give no numbers: weights and radii are chosen here.
"""

from __future__ import annotations

import math

from agents.engine.block import Decision, neighbour_of
from agents.engine.vector_lanes import where
from agents.models.declare import Parameters, Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.terms.sums import of_pairs, sums_around
from worlds.compilation import compiled
from worlds.queries.surroundings import surface_within

# Steering without neighbours: around surfaces ahead, and to a goal (Reynolds 1999).

PROBES = 5
"""Points at which a boid looks for surfaces, evenly spaced from its own place to look_ahead."""
SLIGHT = 1e-6
"""A component of a unit vector that is as good as none: head-on if it is that across the heading,
along the surface if it is that of the heading along the normal."""


@compiled
def clip_to_unit(x, y, z):
    """The vector, at most 1 long."""
    length = math.sqrt(x * x + y * y + z * z)
    share = 1.0 / length if length > 1.0 else 1.0
    return share * x, share * y, share * z


@compiled
def sideways(me):
    """A unit vector across the heading, to the left in the plan: where to turn when head-on."""
    length = math.sqrt(me.ux * me.ux + me.uy * me.uy)
    if length < SLIGHT:
        return 1.0, 0.0, 0.0
    return -me.uy / length, me.ux / length, 0.0


@compiled
def avoidance(me, surroundings, p):
    """Across the heading, away from the first surface that the way ahead comes too close to.

    The part of the surface normal across the heading (Reynolds 1999, containment), as a unit
    vector times an urgency that falls linearly with the distance of the probe; nothing where the
    way leads away from the surface.
    """
    for k in range(PROBES):
        distance = p.look_ahead * k / (PROBES - 1)
        at = surface_within(
            surroundings,
            me.x + distance * me.ux,
            me.y + distance * me.uy,
            me.z + distance * me.uz,
            p.clearance,
        )
        towards = at.nx * me.ux + at.ny * me.uy + at.nz * me.uz
        if at.distance < p.clearance and towards <= SLIGHT:
            x, y, z = at.nx - towards * me.ux, at.ny - towards * me.uy, at.nz - towards * me.uz
            length = math.sqrt(x * x + y * y + z * z)
            urgency = 1.0 - k / PROBES
            if length < SLIGHT:
                x, y, z = sideways(me)
                length = 1.0
            return urgency * x / length, urgency * y / length, urgency * z / length
    return 0.0, 0.0, 0.0


@compiled
def seek(me, surroundings, p):
    """Towards the goal at full speed: the wanted change of velocity over max_speed, at most 1."""
    if surroundings.route.shape[0] == 0:
        return 0.0, 0.0, 0.0
    dx = surroundings.goal[0, 0] - me.x
    dy = surroundings.goal[0, 1] - me.y
    dz = surroundings.goal[0, 2] - me.z
    d = math.sqrt(dx * dx + dy * dy + dz * dz)
    d = d if d > 0.0 else 1.0
    v = me.speed / p.max_speed
    return clip_to_unit(dx / d - v * me.ux, dy / d - v * me.uy, dz / d - v * me.uz)


FORCES = ("separation", "alignment", "cohesion", "avoidance", "seek")
"""The steering forces, as accelerations, length/s^2."""


SUMS = 11
"""How many numbers `term` has."""


class Boids(Parameters):
    """Parameters of Reynolds' boids."""

    r: float = parameter(
        5.0,
        "Distance within which boids and surfaces are noticed; the other radii count up to it",
        words="Vision radius",
        symbol="r",
        unit="length",
        low=0.1,
        high=100.0,
        proposed=(0.5, 15.0),
        step=0.1,
        source="Reynolds 1999, neighbourhood; value chosen here",
    )
    fov: float = parameter(
        270.0,
        "Field of view: boids behind, outside of this angle about the heading, are not seen",
        words="Field of view",
        symbol="\\phi",
        unit="deg",
        low=1.0,
        high=360.0,
        proposed=(10.0, 360.0),
        step=5.0,
        source="Reynolds 1987, 1999, neighbourhood; value chosen here",
    )
    r_separation: float = parameter(
        1.5,
        "Distance within which others are too close",
        words="Radius of separation",
        symbol="r_s",
        unit="length",
        low=0.01,
        high=100.0,
        proposed=(0.1, 10.0),
        step=0.1,
        source="Reynolds 1999, separation; value chosen here",
    )
    r_alignment: float = parameter(
        4.0,
        "Distance within which velocities are matched",
        words="Radius of alignment",
        symbol="r_a",
        unit="length",
        low=0.01,
        high=100.0,
        proposed=(0.2, 10.0),
        step=0.1,
        source="Reynolds 1999, alignment; value chosen here",
    )
    r_cohesion: float = parameter(
        5.0,
        "Distance within which the centre of the others attracts",
        words="Radius of cohesion",
        symbol="r_c",
        unit="length",
        low=0.01,
        high=100.0,
        proposed=(0.2, 10.0),
        step=0.1,
        source="Reynolds 1999, cohesion; value chosen here",
    )
    w_separation: float = parameter(
        2.0,
        "Weight of separation, in units of max_force",
        words="Weight of separation",
        symbol="w_s",
        low=0.0,
        high=10.0,
        proposed=(0.0, 8.0),
        step=0.1,
        source="Reynolds 1999, flocking; value chosen here",
    )
    w_alignment: float = parameter(
        2.0,
        "Weight of alignment, in units of max_force",
        words="Weight of alignment",
        symbol="w_a",
        low=0.0,
        high=10.0,
        proposed=(0.0, 8.0),
        step=0.1,
        source="Reynolds 1999, flocking; value chosen here",
    )
    w_cohesion: float = parameter(
        0.6,
        "Weight of cohesion, in units of max_force",
        words="Weight of cohesion",
        symbol="w_c",
        low=0.0,
        high=10.0,
        proposed=(0.0, 8.0),
        step=0.1,
        source="Reynolds 1999, flocking; value chosen here",
    )
    w_avoidance: float = parameter(
        4.0,
        "Weight of steering clear of surfaces ahead, in units of max_force",
        words="Weight of avoidance",
        symbol="w_o",
        low=0.0,
        high=20.0,
        proposed=(0.0, 10.0),
        step=0.1,
        source="Reynolds 1999, containment; value chosen here",
    )
    look_ahead: float = parameter(
        4.0,
        "How far ahead surfaces are looked for",
        words="Look ahead",
        symbol="l",
        unit="length",
        low=0.01,
        high=100.0,
        proposed=(0.2, 10.0),
        step=0.1,
        source="Reynolds 1999, obstacle avoidance; value chosen here",
    )
    clearance: float = parameter(
        1.0,
        "Distance to surfaces that the way ahead must keep",
        words="Clearance",
        symbol="d",
        unit="length",
        low=0.01,
        high=20.0,
        step=0.1,
        source="Reynolds 1999, obstacle avoidance (bounding radius); value chosen here",
    )
    w_seek: float = parameter(
        0.5,
        "Weight of seeking the goal, in a world that has one, in units of max_force",
        words="Weight of the goal",
        symbol="w_g",
        low=0.0,
        high=10.0,
        proposed=(0.0, 5.0),
        step=0.1,
        source="Reynolds 1999, seek; value chosen here",
    )


@compiled
def edge_of_view(p):
    """Cosine of half the field of view; less than any cosine if a boid sees all around."""
    return where(p.fov < 360.0, math.cos(0.5 * math.radians(p.fov)), -2.0)


@compiled
def is_in_view(me, other, edge):
    """Whether it is another boid in the field of view."""
    forward = other.dx * me.ux + other.dy * me.uy + other.dz * me.uz
    return (other.d2 > 0.0) & (forward >= edge * math.sqrt(other.d2))


@compiled
def term(me, other, p):
    """What another boid adds to the sums of `flocking`: eleven numbers."""
    is_seen = is_in_view(me, other, edge_of_view(p))
    is_too_near = is_seen & (other.d2 <= min(p.r, p.r_separation) ** 2)
    s = is_too_near * (1.0 / where(is_too_near, other.d2, 1.0))
    a = is_seen & (other.d2 <= min(p.r, p.r_alignment) ** 2)
    c = is_seen & (other.d2 <= min(p.r, p.r_cohesion) ** 2)
    return (
        -s * other.dx,
        -s * other.dy,
        -s * other.dz,
        a * (other.speed * other.ux),
        a * (other.speed * other.uy),
        a * (other.speed * other.uz),
        a,
        c * other.dx,
        c * other.dy,
        c * other.dz,
        c,
    )


@compiled
def flocking(me, sums, p):
    """Separation, alignment and cohesion, each at most 1 long: nine numbers.

    Separation: r_s times the sum of the unit vectors away from each neighbour over its distance.
    Alignment: mean velocity minus one's own, over max_speed. Cohesion: towards the mean position,
    over r_c.
    """
    sx, sy, sz, ax, ay, az, aligned, cx, cy, cz, cohering = sums
    sx, sy, sz = clip_to_unit(p.r_separation * sx, p.r_separation * sy, p.r_separation * sz)
    n = max(1.0, aligned)
    v = me.speed if aligned > 0.0 else 0.0
    ax, ay, az = clip_to_unit(
        (ax / n - v * me.ux) / p.max_speed,
        (ay / n - v * me.uy) / p.max_speed,
        (az / n - v * me.uz) / p.max_speed,
    )
    n = max(1.0, cohering) * p.r_cohesion
    cx, cy, cz = clip_to_unit(cx / n, cy / n, cz / n)
    return sx, sy, sz, ax, ay, az, cx, cy, cz


@compiled
def answer(me, sums, surroundings, p):
    """The weighted sum of the steering forces, length/s^2; the body cuts it at max_force."""
    sx, sy, sz, ax, ay, az, cx, cy, cz = flocking(me, sums, p)
    ox, oy, oz = avoidance(me, surroundings, p)
    gx, gy, gz = seek(me, surroundings, p)
    s, a, c, o, g = p.w_separation, p.w_alignment, p.w_cohesion, p.w_avoidance, p.w_seek
    return Decision(
        p.max_force * (s * sx + a * ax + c * cx + o * ox + g * gx),
        p.max_force * (s * sy + a * ay + c * cy + o * oy + g * gy),
        p.max_force * (s * sz + a * az + c * cz + o * oz + g * gz),
    )


around = sums_around(SUMS, term)


@compiled
def explain(me, near, surroundings, p, out):
    """The steering forces with their weights, length/s^2, in the order of FORCES."""
    sx, sy, sz, ax, ay, az, cx, cy, cz = flocking(me, around(me, near, p), p)
    out[0, 0], out[0, 1], out[0, 2] = sx, sy, sz
    out[1, 0], out[1, 1], out[1, 2] = ax, ay, az
    out[2, 0], out[2, 1], out[2, 2] = cx, cy, cz
    out[3, 0], out[3, 1], out[3, 2] = avoidance(me, surroundings, p)
    out[4, 0], out[4, 1], out[4, 2] = seek(me, surroundings, p)
    for k in range(3):
        out[0, k] *= p.w_separation * p.max_force
        out[1, k] *= p.w_alignment * p.max_force
        out[2, k] *= p.w_cohesion * p.max_force
        out[3, k] *= p.w_avoidance * p.max_force
        out[4, k] *= p.w_seek * p.max_force


@compiled
def weigh(me, near, p, out):
    """1 for those in view within the largest of the radii, 0 for others."""
    edge = edge_of_view(p)
    largest2 = min(p.r, max(p.r_separation, max(p.r_alignment, p.r_cohesion))) ** 2
    for j in range(near.n):
        other = neighbour_of(me, near, j)
        out[j] = 1.0 if is_in_view(me, other, edge) & (other.d2 <= largest2) else 0.0


REYNOLDS = Rule(
    name="reynolds",
    title="Reynolds' boids",
    summary="Boids keep apart, match velocities and stay together with those that they see, and "
    "steer clear of what is ahead.",
    equation=r"a_i = F\,\big(w_s s_i + w_a a_i + w_c c_i + w_o o_i + w_g g_i\big), \qquad "
    r"s_i = \Big[r_s\sum_j \frac{x_i - x_j}{|x_i - x_j|^2}\Big]_1,\quad "
    r"a_i = \Big[\frac{\bar v - v_i}{v_{max}}\Big]_1,\quad "
    r"c_i = \Big[\frac{\bar x - x_i}{r_c}\Big]_1",
    source="Reynolds 1987; Reynolds 1999",
    checked="{reynolds1987#1}; {reynolds1987#3} (`flockscope paper reynolds1987`)",
    tags=(
        "biology",
        "classroom",
        "boids",
        "flocking",
        "birds",
        "obstacles",
        "emergence",
        "computer graphics",
    ),
    parameters=Boids,
    **of_pairs(SUMS, term, answer),
    wish="acceleration",
    weigh=weigh,
    forces=FORCES,
    explain=explain,
    sees_obstacles=True,
    led=False,
    tries=(
        LessonStep(
            "Take alignment away.",
            "Boids stay together and keep clear of each other, but mill about like gnats: what "
            "each does no longer fits what the others do.",
            {"w_alignment": 0.0},
            LessonCheck("velocity-spread", "above", 1.88, 400),
        ),
        LessonStep(
            "Take separation away.",
            "Boids draw together until they fly in one another.",
            {"w_separation": 0.0},
            LessonCheck("nearest-neighbour", "below", 0.05, 400),
        ),
        LessonStep(
            "Have all seek the goal ten times as strongly.",
            "They press round the star and go along with it.",
            {"w_seek": 5.0},
            LessonCheck("goal-distance", "below", 1.5, 400),
        ),
    ),
)
