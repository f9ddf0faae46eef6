"""From a wish to the wheels of a car: what the computer commands, the radio, what the car does.

The signals of the body are the rows of `out` from `base` on: see `agents.bodies.cars.signals`.
"""

from __future__ import annotations

import math

from agents.bodies.cars.safe_command import BACK, yielded
from agents.bodies.cars.signals import FRESH, LONGEST, QUEUE, STUCK, THROTTLE, WHEEL
from agents.bodies.tracking import is_seen, yaw_error
from agents.engine.noise import uniform
from worlds.compilation import compiled

LOST = 9
"""Draw of the radio."""
GIVES_UP, BACKS = 0.5, 1.0
"""After how long without getting on a car backs out, and for how long, s."""
CREEPS, TRIES = 0.05, 0.2
"""Shares of full speed below which it does not get on, and of full throttle that should move it."""


@compiled
def wheel_for(me, want, p):
    """clip(wrap(angle(D) - yaw), +- the largest angle of the wheels), rad; 0 without a wish.

    The yaw is the one that the tracking tells.
    """
    if want.x * want.x + want.y * want.y < 1e-24:
        return 0.0
    angle = math.atan2(me.ux * want.y - me.uy * want.x, me.ux * want.x + me.uy * want.y)
    angle -= yaw_error(me, p)
    angle -= 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)
    most = math.radians(p.wheel_max)
    return min(max(angle, -most), most)


@compiled
def throttle_for(wheel, p):
    """max - alpha |theta| as a share of full throttle, never negative."""
    return max(0.0, 1.0 - p.alpha_turn * math.fabs(wheel))


@compiled
def time_stuck(me, p, base):
    """Time (s) for which a car has been stuck; it counts from -BACKS up to 0 while it backs out.

    One that looks ahead stands of its own will, which is counted too, and backs out when it likes.
    """
    time = (1.0 - me.signal[base + FRESH]) * me.signal[base + STUCK]
    if time < 0.0:
        return min(0.0, time + p.dt)
    tries = p.yields > 0.0 or (p.reverse > 0.0 and me.signal[base + THROTTLE] > TRIES)
    if not tries or math.fabs(me.speed) > CREEPS * p.v_max:
        return 0.0
    return time + p.dt if p.yields > 0.0 or time + p.dt < GIVES_UP else -BACKS


@compiled
def command(me, near, surroundings, want, p, base, out):
    """The wheel angle (rad) and throttle (share of full, below 0 backwards) for this frame."""
    wheel = wheel_for(me, want, p)
    time = time_stuck(me, p, base)
    out[base + STUCK] = time
    if p.yields > 0.0:
        return yielded(me, near, surroundings, wheel, throttle_for(wheel, p), time, p, base)
    if time < 0.0:
        return -wheel, BACK
    return wheel, throttle_for(wheel, p)


@compiled
def sent(me, wheel, throttle, p, base, out):
    """Put a command at the head of the queue; for a car that is not seen, the last one again."""
    ready = 1.0 - me.signal[base + FRESH]
    queue = base + QUEUE
    for k in range(2 * LONGEST - 2):
        out[queue + 2 + k] = ready * me.signal[queue + k]
    seen = is_seen(me, p)
    out[queue] = wheel if seen else ready * me.signal[queue]
    out[queue + 1] = throttle if seen else ready * me.signal[queue + 1]


@compiled
def received(me, p, base, out):
    """The command in force: the one sent as long ago as its way takes, or the one before if lost.

    Tracking that is late by t is the same as commands that are: both act on poses of t ago.
    """
    ready = 1.0 - me.signal[base + FRESH]
    way = math.floor((p.latency + me.id * p.hop) / p.dt + 0.5)
    at = base + QUEUE + 2 * int(min(way, LONGEST - 1.0))
    lost = uniform(me.key, me.id, LOST) < p.loss
    wheel = ready * me.signal[base + WHEEL] if lost else out[at]
    throttle = ready * me.signal[base + THROTTLE] if lost else out[at + 1]
    out[base + WHEEL] = wheel
    out[base + THROTTLE] = throttle
    return wheel, throttle
