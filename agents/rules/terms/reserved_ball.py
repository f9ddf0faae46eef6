"""The ball that an agent reserves for itself, so that it always has a way out.

An aircraft that cannot stop can slow down and circle. Its *escape* is to turn by theta_max to one
side in every tick while its speed goes to v_min, and then to go round in that circle for ever. Its
*reserved ball*, round the centre of that last circle, holds the whole of the escape; round it there
must be space for the body. Every agent tells the others where its ball is.

Between two balls lies a plane, at right angles to the line through their centres and halfway
between their surfaces. An agent only makes a step after which its next ball lies on its own side of
the planes to all others, and clear of what is solid. The others do the same, so the next balls are
apart again even if all decide at once; and there always is such a step, since going on with the
escape leaves the ball where it is. So from the moment when all balls are apart no two bodies ever
touch, and none touches what is solid, whatever the agents wish.

Cells between planes are those of van den Berg et al. 2011 and Zhou et al. 2017 (buffered Voronoi
cells), who need agents that can stop; a circle in place of a stop is the loiter of Schouwenaars et
al. 2004, and to reserve it the reserved disc of Pallottino et al. 2007. That the escape comes
nearer to its last centre all the time is the theorem of Tait and Kneser on curves whose curvature
grows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from worlds.compilation import compiled
from worlds.queries.surroundings import signed_distance

OUT_X, OUT_Y, OUT_Z, RADIUS = range(4)
"""Rows of `near.signal`: from an agent to the centre of its reserved ball; the radius of that."""
SKIN = 0.01
"""Air that is kept around bodies, length."""
ENOUGH = 1e-9
"""An overlap that rounding may make, length."""
SHARPEST = 0.5 * math.pi
"""Most of a turn in one tick that an escape makes, rad."""


class Direction(NamedTuple):
    """A unit vector; or a place."""

    x: float
    y: float
    z: float


class ReservedBall(NamedTuple):
    """A ball that an agent can stay in: centre and radius, length."""

    x: float
    y: float
    z: float
    radius: float


class Escape(NamedTuple):
    """Where an escape ends, seen from where it begins, length."""

    along: float
    """From the agent to the centre of the last circle, along its heading."""
    across: float
    """The same at right angles to it, to the side of the turn."""
    radius: float
    """The largest distance of the escape from that centre."""


@compiled
def turn_of(p):
    """The turn of an escape in one tick, rad."""
    return min(math.radians(p.theta_max) * p.tau, SHARPEST)


@compiled
def nearer(speed, to, p):
    """The speed after a tick in which the body brings it towards `to`."""
    change = p.a_max * p.tau
    return speed + min(max(to - speed, -change), change)


@compiled
def spiral(speed, last, change, theta, tau):
    """The escape from a speed to the speed `last`, by `change` in every tick of length tau.

    Its circle is a polygon with sides v tau that turn by theta (rad) each. From a corner, with the
    side before it behind, the centre lies r cos(theta / 2) to the side of the turn and
    r sin(theta / 2) back, r = v tau / (2 sin(theta / 2)).
    """
    c, s = math.cos(theta), math.sin(theta)
    ux, uy = 1.0, 0.0
    x = y = 0.0
    v = speed
    while v != last and change > 0.0:
        v += min(max(last - v, -change), change)
        ux, uy = c * ux - s * uy, s * ux + c * uy
        x, y = x + v * tau * ux, y + v * tau * uy
    r = 0.5 * v * tau / math.sin(0.5 * theta)
    side, back = r * math.cos(0.5 * theta), r * math.sin(0.5 * theta)
    x, y = x - side * uy - back * ux, y + side * ux - back * uy
    return Escape(x, y, max(math.sqrt(x * x + y * y), r))


@compiled
def escape(speed, p):
    """The escape of an agent at a speed."""
    return spiral(speed, p.v_min, p.a_max * p.tau, turn_of(p), p.tau)


@compiled
def ball_after_escape(at, u, n, escape_path):
    """The ball reserved by an agent at a place with heading u and an escape to the side n.

    n is a unit vector at right angles to u.
    """
    return ReservedBall(
        at.x + escape_path.along * u.x + escape_path.across * n.x,
        at.y + escape_path.along * u.y + escape_path.across * n.y,
        at.z + escape_path.along * u.z + escape_path.across * n.z,
        escape_path.radius,
    )


@compiled
def own_ball(me):
    """The reserved ball that an agent has sent to the others."""
    return ReservedBall(
        me.x + me.signal[OUT_X],
        me.y + me.signal[OUT_Y],
        me.z + me.signal[OUT_Z],
        me.signal[RADIUS],
    )


@compiled
def side_direction(u, v):
    """The unit vector at right angles to the heading u nearest to a vector v, or any if v is along.

    Where u and v are in the plane z = 0, so is it.
    """
    along = v.x * u.x + v.y * u.y + v.z * u.z
    x, y, z = v.x - along * u.x, v.y - along * u.y, v.z - along * u.z
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-9:
        x, y, z = -u.y, u.x, 0.0
        length = math.sqrt(x * x + y * y)
        if length < 1e-9:
            x, length = 1.0, 1.0
    return Direction(x / length, y / length, z / length)


@compiled
def note_planes(me, near, own, farthest, p):
    """Note the planes between the ball `own` and those of others in `near.spare`; how many.

    Rows: the unit vector from the centre to the other centre (x, y, z), and how far a ball may
    reach beyond `own` on that side, length. Those farther than `farthest`, which no
    ball reaches, are left out.
    """
    least_distance = own.radius + p.body + 2.0 * SKIN
    out_x, out_y, out_z = near.signal[OUT_X], near.signal[OUT_Y], near.signal[OUT_Z]
    radius = near.signal[RADIUS]
    x, y, z, room = near.spare[0], near.spare[1], near.spare[2], near.spare[3]
    n = 0
    for j in range(near.n):
        dx = near.x[j] - me.x
        dy = near.y[j] - me.y
        dz = near.z[j] - me.z
        d2 = dx * dx + dy * dy + dz * dz
        ex = near.x[j] + out_x[j] - own.x
        ey = near.y[j] + out_y[j] - own.y
        ez = near.z[j] + out_z[j] - own.z
        x[n], y[n], z[n], room[n] = ex, ey, ez, least_distance + radius[j]
        reach = room[n] + 2.0 * farthest
        n += 1 if (d2 > 0.0) & (ex * ex + ey * ey + ez * ez < reach * reach) else 0
    for k in range(n):
        e2 = x[k] * x[k] + y[k] * y[k] + z[k] * z[k]
        e = math.sqrt(e2 if e2 > 0.0 else 1.0)
        x[k], y[k], z[k], room[k] = x[k] / e, y[k] / e, z[k] / e, 0.5 * (e - room[k])
    return n


@compiled
def overlap(near, planes, surroundings, own, ball, p):
    """By how much a ball is over the planes around the ball `own`, and in solids; length.

    The sum over the `planes` that `note_planes` has noted, and the nearest surface. 0: the step to
    it is safe. Nobody beyond reach is in the way, see
    `agents.rules.guarded_zones.GuardedZones.range`.
    """
    vx, vy, vz = ball.x - own.x, ball.y - own.y, ball.z - own.z
    growth = ball.radius - own.radius
    plane = near.spare
    total = 0.0
    for j in range(planes):
        reach = vx * plane[0, j] + vy * plane[1, j] + vz * plane[2, j] + growth
        over = reach - plane[3, j]
        total += over if over > ENOUGH else 0.0
    clearance = (
        signed_distance(surroundings, ball.x, ball.y, ball.z) - ball.radius - 0.5 * p.body - SKIN
    )
    return total - (clearance if clearance < -ENOUGH else 0.0)
