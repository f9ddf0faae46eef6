"""What pulls at a car by the squashing rule: other cars, predators, the injected car, and prey.

Jacobs and Koessler, "Flocking Cars: Dynamic Behavior in Simulation & Implementation", (2) and (3).
"""

from __future__ import annotations

import math

from agents.bodies.tracking import normal_pair
from agents.engine.block import adjacent
from agents.engine.noise import cos_sin
from worlds.compilation import compiled

ERROR_X, ERROR_Y, HUNTS = 0, 1, 2
"""The rule's signals: the error of the tracked position (m), and 1.0 for a predator."""
OWN = 1.0
"""Index of `own` among the choices of `sensing`."""
RANGE, BEARING = 10, 11
"""Draws of a car's own sensors."""


@compiled
def squash(r, beta, c, gamma):
    """sigma(v) of (3) for a vector of length r (m), along it: below 0 it repels."""
    return beta * (-c + r / (r + gamma))


@compiled
def shaped_squash(r, beta, c, gamma, p):
    """sigma of (3) with another slope near 0, for a vector of length r (m), along it.

    r + soft to the power takes the place of r. What it is halved at is such that the zero stays
    at C gamma / (1 - C); where there is none, for C = 0 or C >= 1, it is gamma as before.
    """
    half = gamma**p.power
    if 0.0 < c < 1.0:
        half = (c * gamma / (1.0 - c) + p.soft) ** p.power * (1.0 - c) / c
    stretched = (r + p.soft) ** p.power
    share = (
        stretched / (stretched + half) if stretched > 0.0 else 0.0
    )  # both are 0 at r = 0 if c is next to 0
    return beta * (-c + share)


@compiled
def is_plain(p):
    """Whether it is the paper's function and the paper's tracking."""
    return (p.power == 1.0) & (p.soft == 0.0) & (p.sensing != OWN)


@compiled
def is_hunter(me, p):
    """Whether this car is a predator: the first `predators` numbers are, from 1 on."""
    return float(me.id) <= p.predators


@compiled
def tracked_offset(me, near, j):
    """The vector to car j as the tracking has it, m."""
    error_x, error_y = near.signal[ERROR_X], near.signal[ERROR_Y]
    dx = (near.x[j] + error_x[j]) - (me.x + me.signal[ERROR_X])
    dy = (near.y[j] + error_y[j]) - (me.y + me.signal[ERROR_Y])
    return dx, dy


@compiled
def is_heard(me, near, j, limit, p):
    """1.0 if car j is one that is heard, see `hearing_limit2`, and no predator; else 0.0."""
    dx, dy = tracked_offset(me, near, j)
    is_near_enough = 1.0 if dx * dx + dy * dy <= limit else 0.0
    return is_near_enough * adjacent(me, near, j, p.r) * (1.0 - near.signal[HUNTS][j])


@compiled
def hearing_limit2(me, near, p):
    """Square of the distance (m^2) up to which cars are heard: that of the k-th nearest."""
    hunts = near.signal[HUNTS]
    limit, count = -1.0, 0.0
    while count < p.k:
        following = math.inf
        for j in range(near.n):
            dx, dy = tracked_offset(me, near, j)
            d2 = dx * dx + dy * dy
            counts = (adjacent(me, near, j, p.r) * (1.0 - hunts[j]) > 0.0) & (d2 > limit)
            following = d2 if counts & (d2 < following) else following
        if following == math.inf:
            return math.inf
        limit = following
        count = 0.0
        for j in range(near.n):
            count += is_heard(me, near, j, limit, p)
    return limit if p.k > 0.0 else math.inf


@compiled
def own_error(me, p):
    """What a car's own sensors are off by in this tick: a factor of distances, and a turn (c, s).

    It is the same for all that the car sees.
    """
    if p.sensing != OWN:
        return 1.0, 1.0, 0.0
    n, m = normal_pair(me.key, me.id, RANGE, BEARING)
    c, s = cos_sin(p.noise_bearing * m)
    return 1.0 + p.noise_range * n, c, s


@compiled
def is_sighted(me, dx, dy, p):
    """1.0 if what is at (dx, dy) from the car, m, is within r and in its field of view, else 0.0.

    By the tracking all that is within r is.
    """
    d = math.sqrt(dx * dx + dy * dy)
    is_ahead = me.ux * dx + me.uy * dy >= math.cos(0.5 * math.radians(p.alpha_s)) * d
    return 1.0 if (d <= p.r) & (is_ahead | (p.sensing != OWN)) else 0.0


@compiled
def apply_sensor_error(x, y, error):
    """A vector as sensors tell it that are off by `error`, see `own_error`."""
    factor, c, s = error
    return factor * (c * x - s * y), factor * (s * x + c * y)


@compiled
def sense_cars(me, near, p):
    """The vectors to all cars as this car knows them, in the rows 0 and 1 of `near.spare`, m.

    Row 2 is 1.0 for those that are heard and row 3 for predators that it notices. Heard are the k
    nearest that it notices, or all; predators are not among them.
    """
    error = own_error(me, p)
    spare, hunts = near.spare, near.signal[HUNTS]
    for j in range(near.n):
        dx, dy = near.x[j] - me.x, near.y[j] - me.y
        is_noticed = is_sighted(me, dx, dy, p) * adjacent(me, near, j, p.r)
        if p.sensing == OWN:
            dx, dy = apply_sensor_error(dx, dy, error)
        else:
            dx, dy = tracked_offset(me, near, j)
        spare[0, j], spare[1, j] = dx, dy
        spare[2, j] = is_noticed * (1.0 - hunts[j])
        spare[3, j] = is_noticed * hunts[j]
    if p.k > 0.0:
        limit = kth_nearest2(near, p.k)
        for j in range(near.n):
            d2 = spare[0, j] ** 2 + spare[1, j] ** 2
            spare[2, j] = spare[2, j] if d2 <= limit else 0.0


@compiled
def kth_nearest2(near, k):
    """Square of the distance (m^2) of the k-th nearest of those in row 2 of `near.spare`."""
    spare = near.spare
    limit, count = -1.0, 0.0
    while count < k:
        following = math.inf
        for j in range(near.n):
            d2 = spare[0, j] ** 2 + spare[1, j] ** 2
            following = d2 if (spare[2, j] > 0.0) & (limit < d2 < following) else following
        if following == math.inf:
            return math.inf
        limit = following
        count = 0.0
        for j in range(near.n):
            d2 = spare[0, j] ** 2 + spare[1, j] ** 2
            count += spare[2, j] if d2 <= limit else 0.0
    return limit


@compiled
def pulls_of_variants(me, near, p):
    """The sums of `pulls` with another function or with a car's own sensors."""
    sense_cars(me, near, p)
    spare = near.spare
    cx = cy = px = py = ax = ay = 0.0
    for j in range(near.n):
        dx, dy = spare[0, j], spare[1, j]
        r = math.sqrt(dx * dx + dy * dy)
        over = (1.0 if r > 0.0 else 0.0) / (r if r > 0.0 else 1.0)
        pull = spare[2, j] * shaped_squash(r, p.beta, p.C, p.gamma, p) * over
        push = spare[3, j] * shaped_squash(r, p.beta_p, p.C_p, p.gamma, p) * over
        cx += pull * dx
        cy += pull * dy
        px += push * dx
        py += push * dy
        ax += spare[2, j] * p.c_align * near.ux[j]
        ay += spare[2, j] * p.c_align * near.uy[j]
    return cx, cy, px, py, ax, ay


@compiled
def pulls(me, near, p):
    """The sums of sigma over the cars that are heard and over predators, and of headings: six."""
    if not is_plain(p):
        return pulls_of_variants(me, near, p)
    hunts = near.signal[HUNTS]
    limit = hearing_limit2(me, near, p)
    cx = cy = px = py = ax = ay = 0.0
    for j in range(near.n):
        dx, dy = tracked_offset(me, near, j)
        r = math.sqrt(dx * dx + dy * dy)
        is_counted = is_heard(me, near, j, limit, p)
        flees = adjacent(me, near, j, p.r) * hunts[j]
        over = (1.0 if r > 0.0 else 0.0) / (r if r > 0.0 else 1.0)
        pull = is_counted * squash(r, p.beta, p.C, p.gamma) * over
        push = flees * squash(r, p.beta_p, p.C_p, p.gamma) * over
        cx += pull * dx
        cy += pull * dy
        px += push * dx
        py += push * dy
        ax += is_counted * p.c_align * near.ux[j]
        ay += is_counted * p.c_align * near.uy[j]
    return cx, cy, px, py, ax, ay


@compiled
def pull_to_injected(me, surroundings, p):
    """sigma of the injected car; (0, 0) in a world without one.

    Where it is, is known without error, but to cars that know only what they see themselves.
    """
    if surroundings.route.shape[0] == 0:
        return 0.0, 0.0
    if not is_plain(p):
        return pull_to_injected_of_variants(me, surroundings, p)
    dx = surroundings.goal[0, 0] - (me.x + me.signal[ERROR_X])
    dy = surroundings.goal[0, 1] - (me.y + me.signal[ERROR_Y])
    r = math.sqrt(dx * dx + dy * dy)
    pull = p.c_goal * squash(r, p.beta, p.C, p.gamma) / r if r > 0.0 else 0.0
    return pull * dx, pull * dy


@compiled
def pull_to_injected_of_variants(me, surroundings, p):
    """The same with another function or with a car's own sensors."""
    dx, dy = surroundings.goal[0, 0] - me.x, surroundings.goal[0, 1] - me.y
    is_noticed = 1.0
    if p.sensing == OWN:
        is_noticed = is_sighted(me, dx, dy, p)
        dx, dy = apply_sensor_error(dx, dy, own_error(me, p))
    else:
        dx, dy = dx - me.signal[ERROR_X], dy - me.signal[ERROR_Y]
    r = math.sqrt(dx * dx + dy * dy)
    pull = is_noticed * p.c_goal * shaped_squash(r, p.beta, p.C, p.gamma, p) / r if r > 0.0 else 0.0
    return pull * dx, pull * dy


@compiled
def own_chase(me, near, p):
    """The same by the predator's own sensors."""
    sense_cars(me, near, p)
    nearest2 = math.inf
    x = y = 0.0
    for j in range(near.n):
        dx, dy = near.spare[0, j], near.spare[1, j]
        d2 = dx * dx + dy * dy
        if near.spare[2, j] > 0.0 and d2 < nearest2:
            nearest2, x, y = d2, dx, dy
    r = math.sqrt(x * x + y * y)
    pull = squash(r, p.beta, 0.0, p.gamma) / r if r > 0.0 else 0.0
    return pull * x, pull * y


@compiled
def chase(me, near, p):
    """What a predator wants: sigma with C = 0 of the nearest car that is none."""
    hunts = near.signal[HUNTS]
    nearest2 = math.inf
    x = y = 0.0
    for j in range(near.n):
        dx, dy = tracked_offset(me, near, j)
        d2 = dx * dx + dy * dy
        prey = adjacent(me, near, j, p.r) * (1.0 - hunts[j])
        if prey > 0.0 and d2 < nearest2:
            nearest2, x, y = d2, dx, dy
    r = math.sqrt(x * x + y * y)
    pull = squash(r, p.beta, 0.0, p.gamma) / r if r > 0.0 else 0.0
    return pull * x, pull * y
