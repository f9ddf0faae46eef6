"""The step of an agent that is nearest to its wish and leaves it a way out."""

from __future__ import annotations

import math
from typing import NamedTuple

from agents.engine.noise import cos_sin
from agents.rules.terms.reserved_ball import (
    OUT_X,
    OUT_Y,
    OUT_Z,
    Direction,
    Escape,
    ReservedBall,
    beside,
    escape,
    nearer,
    note_planes,
    overlap,
    own_ball,
    reserved_ball,
    turn_of,
)
from worlds.compilation import compiled

HALF = math.sqrt(0.5)
COSINES = (1.0, HALF, HALF, 0.0, 0.0, -HALF, -HALF, -1.0)
SINES = (0.0, HALF, -HALF, 1.0, -1.0, HALF, -HALF, 0.0)
"""Of 0, 45, -45, 90, -90, 135, -135, 180 degrees: headings and sides of escapes that are tried."""
SIDES, PACES, HEADINGS = 8, 2, 9
"""How many sides to escape to, speeds and headings are tried."""


class GuardedStep(NamedTuple):
    """A step, and the ball that the agent reserves after it."""

    u: Direction
    """The new heading."""
    speed: float
    ball: ReservedBall


class StepOptions(NamedTuple):
    """What an agent chooses from: a heading, a speed, and the escape from there."""

    toward: Direction
    """The side to which it wants to turn."""
    angle: float
    """By how much it wants to turn, rad."""
    most: float
    """By how much it can, rad."""
    fast: float
    """The speed that it wants, as near as it can get to it in a tick."""
    slow: float
    """The speed if it slows down."""
    fast_way: Escape
    slow_way: Escape
    out: Direction
    """The side to which it would escape now."""
    flat: bool
    """Whether it lives in the plane z = 0."""


@compiled
def leaves(flat, k):
    """Whether the k-th of eight directions leads out of the plane of a flat world."""
    return flat and 0 < k < SIDES - 1


@compiled
def about(u, n, k):
    """The unit vector n turned by the k-th angle about u, a unit vector at right angles to it."""
    c, s = COSINES[k], SINES[k]
    return Direction(
        c * n.x + s * (u.y * n.z - u.z * n.y),
        c * n.y + s * (u.z * n.x - u.x * n.z),
        c * n.z + s * (u.x * n.y - u.y * n.x),
    )


@compiled
def towards(u, n, angle):
    """The heading u turned by an angle (rad) towards n, at right angles to it."""
    c, s = cos_sin(angle)
    return Direction(c * u.x + s * n.x, c * u.y + s * n.y, c * u.z + s * n.z)


@compiled
def choice(me, wish, pace, p):
    """What the agent can do that wishes for a heading `wish` and a speed `pace`."""
    u = Direction(me.ux, me.uy, me.uz)
    most = turn_of(p)
    along = min(1.0, max(-1.0, wish.x * u.x + wish.y * u.y + wish.z * u.z))
    fast = nearer(me.speed, min(max(pace, p.v_min), p.v_max), p)
    slow = nearer(me.speed, p.v_min, p)
    return StepOptions(
        beside(u, wish),
        min(math.acos(along), most),
        most,
        fast,
        slow,
        escape(fast, p),
        escape(slow, p),
        beside(u, Direction(me.signal[OUT_X], me.signal[OUT_Y], me.signal[OUT_Z])),
        (me.z == 0.0) & (me.uz == 0.0),
    )


@compiled
def heading_tried(me, of, k):
    """The k-th heading: the wanted one, straight on, then full turns to seven other sides."""
    u = Direction(me.ux, me.uy, me.uz)
    if k == 0:
        return towards(u, of.toward, of.angle)
    if k == 1:
        return u
    return towards(u, about(u, of.toward, k - 1), of.most)


@compiled
def onward(me, of, own):
    """The last resort, to go on with the escape: the ball stays."""
    return GuardedStep(towards(Direction(me.ux, me.uy, me.uz), of.out, of.most), of.slow, own)


@compiled
def beyond(speed, way, p):
    """How far from an agent the ball reaches that it reserves after a step, at most; length."""
    return speed * p.tau + math.sqrt(way.along**2 + way.across**2) + way.radius


@compiled
def farthest(me, of, own, p):
    """How far beyond the ball `own` any ball can reach that is tried, at most; length."""
    to = math.sqrt((own.x - me.x) ** 2 + (own.y - me.y) ** 2 + (own.z - me.z) ** 2)
    reach = max(beyond(of.fast, of.fast_way, p), beyond(of.slow, of.slow_way, p))
    return max(to + reach - own.radius, 0.0)


@compiled
def safe_step(me, near, surroundings, wish, pace, p):
    """The first safe step for an agent that wishes a heading (unit vector) and a speed.

    Those nearest to the wish, and to the present escape, come first: for each heading the wanted
    speed before slowing down, and for each speed the escapes to the sides near the present one
    before the others; at last the present escape. If none is safe, which happens only while
    reserved balls overlap as a run starts, the least unsafe. Without the guard (p.guard) the step
    that is wished, safe or not.
    """
    of = choice(me, wish, pace, p)
    own = own_ball(me)
    planes = note_planes(me, near, own, farthest(me, of, own, p), p)
    best = last = onward(me, of, own)
    least = math.inf
    for heading in range(HEADINGS):
        if leaves(of.flat, heading - 1):
            continue
        u = heading_tried(me, of, heading)
        side = beside(u, of.out)
        for slows in range(PACES):
            speed, way = (of.slow, of.slow_way) if slows else (of.fast, of.fast_way)
            d = speed * p.tau
            at = Direction(me.x + d * u.x, me.y + d * u.y, me.z + d * u.z)
            for k in range(SIDES):
                if leaves(of.flat, k):
                    continue
                ball = reserved_ball(at, u, about(u, side, k), way)
                over = overlap(near, planes, surroundings, own, ball, p)
                if over == 0.0 or p.guard == 0.0:
                    return GuardedStep(u, speed, ball)
                if over < least:
                    least, best = over, GuardedStep(u, speed, ball)
    return last if overlap(near, planes, surroundings, own, own, p) < least else best
