"""The step of an agent that is nearest to its wish and leaves it a way out."""

from __future__ import annotations

import math
from typing import NamedTuple

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
    overlap,
    own_ball,
    reserved_ball,
    turn_of,
)
from worlds.compiled import compiled

EIGHTH = 0.25 * math.pi
"""Headings and sides of escapes are tried in eight directions."""
SIDES, PACES, HEADINGS = 8, 2, 9
"""How many sides to escape to, speeds and headings are tried."""
TRIES = SIDES * PACES * HEADINGS
"""Steps that are tried; the last resort comes on top of them."""


class Step(NamedTuple):
    """A step, and the ball that the agent reserves after it."""

    u: Direction
    """The new heading."""
    speed: float
    ball: ReservedBall


class Choice(NamedTuple):
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
def eighths(k):
    """Cosine and sine of the k-th of 0, 45, -45, 90, -90, 135, -135, 180 degrees."""
    angle = EIGHTH * ((k + 1) // 2) * (1.0 if k % 2 == 1 else -1.0)
    return math.cos(angle), math.sin(angle)


@compiled
def leaves(flat, k):
    """Whether the k-th of eight directions leads out of the plane of a flat world."""
    return flat and 0 < k < SIDES - 1


@compiled
def about(u, n, k):
    """The unit vector n turned about the unit vector u, at right angles to it, to `eighths(k)`."""
    c, s = eighths(k)
    return Direction(
        c * n.x + s * (u.y * n.z - u.z * n.y),
        c * n.y + s * (u.z * n.x - u.x * n.z),
        c * n.z + s * (u.x * n.y - u.y * n.x),
    )


@compiled
def towards(u, n, angle):
    """The heading u turned by an angle (rad) towards n, at right angles to it."""
    c, s = math.cos(angle), math.sin(angle)
    return Direction(c * u.x + s * n.x, c * u.y + s * n.y, c * u.z + s * n.z)


@compiled
def choice(me, wish, pace, p):
    """What the agent can do that wishes for a heading `wish` and a speed `pace`."""
    u = Direction(me.ux, me.uy, me.uz)
    most = turn_of(p)
    along = min(1.0, max(-1.0, wish.x * u.x + wish.y * u.y + wish.z * u.z))
    fast = nearer(me.speed, min(max(pace, p.v_min), p.v_max), p)
    slow = nearer(me.speed, p.v_min, p)
    return Choice(
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
def tried(me, of, number, p):
    """The step of a number from 0 to TRIES - 1: the nearest to the wish, and to its escape, first.

    For each heading the wanted speed comes before slowing down, and for each speed the escapes to
    the sides near the present one before the others.
    """
    side = number % SIDES
    slows = number // SIDES % PACES == 1
    u = heading_tried(me, of, number // (SIDES * PACES))
    n = about(u, beside(u, of.out), side)
    speed = of.slow if slows else of.fast
    d = speed * p.tau
    at = Direction(me.x + d * u.x, me.y + d * u.y, me.z + d * u.z)
    return Step(u, speed, reserved_ball(at, u, n, of.slow_way if slows else of.fast_way))


@compiled
def onward(me, of, own):
    """The last resort, to go on with the escape: the ball stays."""
    return Step(towards(Direction(me.ux, me.uy, me.uz), of.out, of.most), of.slow, own)


@compiled
def safe_step(me, near, surroundings, wish, pace, p):
    """The first safe step for an agent that wishes a heading (unit vector) and a speed.

    If none is safe, which happens only while reserved balls overlap as a run starts, the least
    unsafe. Without the guard (p.guard) the step that is wished, safe or not.
    """
    of = choice(me, wish, pace, p)
    own = own_ball(me)
    best = onward(me, of, own)
    least = math.inf
    for number in range(TRIES + 1):
        aside = number // (SIDES * PACES) - 1
        if number < TRIES and (leaves(of.flat, number % SIDES) or leaves(of.flat, aside)):
            continue
        step = tried(me, of, number, p) if number < TRIES else onward(me, of, own)
        over = overlap(me, near, surroundings, own, step.ball, p)
        if over < least:
            least, best = over, step
        if over == 0.0 or p.guard == 0.0:
            break
    return best
