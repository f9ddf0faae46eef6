"""The mechanics of a car: a bicycle that turns about its rear axle, a rectangle that others stop.

Angles in rad, to the left positive; lengths in m; times in s. A speed below 0 is backwards.
"""

from __future__ import annotations

import math

from worlds.compilation import compiled
from worlds.queries.crossing import is_crossed
from worlds.queries.surroundings import signed_distance


@compiled
def wheelbase(p):
    """L_eff = R tan(delta_max) of a car whose turning circle has the diameter 2 R, m."""
    return 0.5 * p.circle * math.tan(math.radians(p.wheel_max))


@compiled
def rolled(x, y, ux, uy, speed, wheel, length, dt):
    """Place and heading after rolling for dt with the front wheels held: an arc, exactly.

    The yaw rate is speed tan(wheel) / length; (x, y) is the middle of the rear axle.
    """
    turn = speed * math.tan(wheel) / length * dt
    half = 0.5 * turn
    chord = speed * dt * (math.sin(half) / half if math.fabs(half) > 1e-9 else 1.0)
    ch, sh = math.cos(half), math.sin(half)
    x += chord * (ch * ux - sh * uy)
    y += chord * (sh * ux + ch * uy)
    c, s = math.cos(turn), math.sin(turn)
    vx, vy = c * ux - s * uy, s * ux + c * uy
    size = math.sqrt(vx * vx + vy * vy)
    return x, y, vx / size, vy / size


@compiled
def separation(dx, dy, ux, uy, vx, vy, length, width):
    """How far apart two rectangles are, m: below 0 if they overlap, by how much.

    (dx, dy) is from one centre to the other; they lie along (ux, uy) and (vx, vy). It is the widest
    gap along one of the four sides, at most the true distance and equal to it where a side faces.
    """
    a, b = 0.5 * length, 0.5 * width
    c, s = math.fabs(ux * vx + uy * vy), math.fabs(ux * vy - uy * vx)
    along, across = a + a * c + b * s, b + a * s + b * c
    return max(
        max(math.fabs(dx * ux + dy * uy) - along, math.fabs(dy * ux - dx * uy) - across),
        max(math.fabs(dx * vx + dy * vy) - along, math.fabs(dy * vx - dx * vy) - across),
    )


@compiled
def nearest_car(me, near, x, y, ux, uy, p):
    """Separation (m) of the nearest other car from this one at (x, y) along (ux, uy); or inf.

    The block holds this car too, and knows it by its place and heading: of several that share both,
    all but one are others.
    """
    least = math.inf
    alike = 0
    for j in range(near.n):
        ex, ey = near.x[j] - me.x, near.y[j] - me.y
        same = (ex * ex + ey * ey == 0.0) & (near.ux[j] == me.ux) & (near.uy[j] == me.uy)
        alike += 1 if same else 0
        gap = separation(
            near.x[j] - x, near.y[j] - y, ux, uy, near.ux[j], near.uy[j], p.length, p.width
        )
        least = min(least, math.inf if same else gap)
    if alike > 1:
        gap = separation(me.x - x, me.y - y, ux, uy, me.ux, me.uy, p.length, p.width)
        least = min(least, gap)
    return least


@compiled
def nearest_solid(surroundings, x, y, ux, uy, p):
    """Least signed distance (m) of the corners of a car at (x, y) from what is solid, or inf."""
    if surroundings.solids == 0:
        return math.inf
    ax, ay = 0.5 * p.length * ux, 0.5 * p.length * uy
    bx, by = -0.5 * p.width * uy, 0.5 * p.width * ux
    return min(
        min(
            signed_distance(surroundings, x + ax + bx, y + ay + by, 0.0),
            signed_distance(surroundings, x + ax - bx, y + ay - by, 0.0),
        ),
        min(
            signed_distance(surroundings, x - ax + bx, y - ay + by, 0.0),
            signed_distance(surroundings, x - ax - bx, y - ay - by, 0.0),
        ),
    )


@compiled
def is_stopped(me, near, surroundings, x, y, ux, uy, p):
    """Whether a car or something solid stops the car from going on to (x, y) along (ux, uy).

    It does where they would overlap, and more than they do already: a car can always get away. And
    it does where the car's middle would go through a wall too thin for the corners to meet it.
    """
    gap = nearest_car(me, near, x, y, ux, uy, p)
    if gap <= 0.0 and gap < nearest_car(me, near, me.x, me.y, me.ux, me.uy, p):
        return True
    gap = nearest_solid(surroundings, x, y, ux, uy, p)
    if gap <= 0.0 and gap < nearest_solid(surroundings, me.x, me.y, me.ux, me.uy, p):
        return True
    return is_crossed(surroundings, me.x, me.y, 0.0, x, y, 0.0)
