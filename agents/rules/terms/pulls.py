"""What pulls at a car by the squashing rule: other cars, predators, the injected car, and prey.

Jacobs and Koessler, "Flocking Cars: Dynamic Behavior in Simulation & Implementation", (2) and (3).
"""

from __future__ import annotations

import math

from agents.engine.block import adjacent
from worlds.compiled import compiled

ERROR_X, ERROR_Y, HUNTS = 0, 1, 2
"""The rule's signals: the error of the tracked position (m), and 1.0 for a predator."""


@compiled
def squashed(r, beta, c, gamma):
    """sigma(v) of (3) for a vector of length r (m), along it: below 0 it repels."""
    return beta * (-c + r / (r + gamma))


@compiled
def is_hunter(me, p):
    """Whether this car is a predator: the first `predators` numbers are, from 1 on."""
    return float(me.id) <= p.predators


@compiled
def apart(me, near, j):
    """The vector to car j as the tracking has it, m."""
    error_x, error_y = near.signal[ERROR_X], near.signal[ERROR_Y]
    dx = (near.x[j] + error_x[j]) - (me.x + me.signal[ERROR_X])
    dy = (near.y[j] + error_y[j]) - (me.y + me.signal[ERROR_Y])
    return dx, dy


@compiled
def is_heard(me, near, j, limit, p):
    """1.0 if car j is one that is heard, see `hearing`, and no predator; else 0.0."""
    dx, dy = apart(me, near, j)
    near_enough = 1.0 if dx * dx + dy * dy <= limit else 0.0
    return near_enough * adjacent(me, near, j, p.r) * (1.0 - near.signal[HUNTS][j])


@compiled
def hearing(me, near, p):
    """Square of the distance (m^2) up to which cars are heard: that of the k-th nearest."""
    hunts = near.signal[HUNTS]
    limit, heard = -1.0, 0.0
    while heard < p.k:
        following = math.inf
        for j in range(near.n):
            dx, dy = apart(me, near, j)
            d2 = dx * dx + dy * dy
            counts = (adjacent(me, near, j, p.r) * (1.0 - hunts[j]) > 0.0) & (d2 > limit)
            following = d2 if counts & (d2 < following) else following
        if following == math.inf:
            return math.inf
        limit = following
        heard = 0.0
        for j in range(near.n):
            heard += is_heard(me, near, j, limit, p)
    return limit if p.k > 0.0 else math.inf


@compiled
def pulls(me, near, p):
    """The sums of sigma over the cars that are heard and over predators, and of headings: six."""
    hunts = near.signal[HUNTS]
    limit = hearing(me, near, p)
    cx = cy = px = py = ax = ay = 0.0
    for j in range(near.n):
        dx, dy = apart(me, near, j)
        r = math.sqrt(dx * dx + dy * dy)
        heard = is_heard(me, near, j, limit, p)
        flees = adjacent(me, near, j, p.r) * hunts[j]
        over = (1.0 if r > 0.0 else 0.0) / (r if r > 0.0 else 1.0)
        pull = heard * squashed(r, p.beta, p.C, p.gamma) * over
        push = flees * squashed(r, p.beta_p, p.C_p, p.gamma) * over
        cx += pull * dx
        cy += pull * dy
        px += push * dx
        py += push * dy
        ax += heard * p.c_align * near.ux[j]
        ay += heard * p.c_align * near.uy[j]
    return cx, cy, px, py, ax, ay


@compiled
def injected(me, surroundings, p):
    """sigma of the injected car, which is known without error; (0, 0) in a world without one."""
    if surroundings.route.shape[0] == 0:
        return 0.0, 0.0
    dx = surroundings.goal[0, 0] - (me.x + me.signal[ERROR_X])
    dy = surroundings.goal[0, 1] - (me.y + me.signal[ERROR_Y])
    r = math.sqrt(dx * dx + dy * dy)
    pull = p.c_goal * squashed(r, p.beta, p.C, p.gamma) / r if r > 0.0 else 0.0
    return pull * dx, pull * dy


@compiled
def chase(me, near, p):
    """What a predator wants: sigma with C = 0 of the nearest car that is none."""
    hunts = near.signal[HUNTS]
    least = math.inf
    x = y = 0.0
    for j in range(near.n):
        dx, dy = apart(me, near, j)
        d2 = dx * dx + dy * dy
        prey = adjacent(me, near, j, p.r) * (1.0 - hunts[j])
        if prey > 0.0 and d2 < least:
            least, x, y = d2, dx, dy
    r = math.sqrt(x * x + y * y)
    pull = squashed(r, p.beta, 0.0, p.gamma) / r if r > 0.0 else 0.0
    return pull * x, pull * y
