"""Looking ahead: of the commands that are safe a car takes the one nearest to its wish.

Added to Jacobs and Koessler, whose cars go for their wish whatever is in the way. The others are
taken to go on as they are: at their speed, with their wheels as they stand. Bodies are taken as two
discs each, which cover the rectangle.
"""

from __future__ import annotations

import math

from agents.bodies.cars.chassis import wheelbase
from agents.bodies.cars.signals import FRESH, PACE, QUEUE, STEERING
from agents.engine.noise import cos_sin
from worlds.compilation import compiled
from worlds.queries.surroundings import signed_distance

STEPS = 10
"""Looks ahead, evenly over the time that a car looks ahead."""
WHEELS = 9
"""Angles of the wheels that are tried beside the wished one, from right to left."""
PACES = 4
"""Throttles that are tried with each: as wished, half of it, none, and backwards."""
BACK = -0.5
"""Throttle backwards."""
TURNED, SLOWED, FICKLE, RISK, WAITING = 1.0, 1.0, 3.0, 20.0, 1.0
"""Costs of a rad off the wished angle, of the throttle taken off, of not backing out to the end, of
what is in the way, and of standing on after a second of it."""


@compiled
def gap_to(me, near, j, base, t, x, y, ux, uy, p):
    """Gap (m) between this car at (x, y) along (ux, uy) and car j, at time t (s) from now."""
    known = 1.0 - near.signal[base + FRESH, j]
    speed = known * near.signal[base + PACE, j]
    half = 0.5 * t * speed * math.tan(known * near.signal[base + STEERING, j]) / wheelbase(p)
    half = min(max(half, -8.0), 8.0)
    c, s = cos_sin(half)
    chord = speed * t * (s / half if math.fabs(half) > 1e-9 else 1.0)
    hx, hy = near.ux[j], near.uy[j]
    ox = near.x[j] + chord * (c * hx - s * hy) - x
    oy = near.y[j] + chord * (s * hx + c * hy) - y
    c, s = c * c - s * s, 2.0 * c * s
    q = 0.25 * p.length
    vx, vy = q * (c * hx - s * hy), q * (s * hx + c * hy)
    wx, wy = q * ux, q * uy
    fx, fy, gx, gy = ox + vx, oy + vy, ox - vx, oy - vy
    d2 = min(
        min((fx - wx) ** 2 + (fy - wy) ** 2, (fx + wx) ** 2 + (fy + wy) ** 2),
        min((gx - wx) ** 2 + (gy - wy) ** 2, (gx + wx) ** 2 + (gy + wy) ** 2),
    )
    return math.sqrt(d2) - 2.0 * math.sqrt(q * q + 0.25 * p.width * p.width)


@compiled
def least_gap(me, near, surroundings, base, t, x, y, ux, uy, p):
    """The least gap (m) between this car at (x, y) and any other or what is solid, at time t."""
    least = math.inf
    for j in range(near.n):
        dx, dy = near.x[j] - me.x, near.y[j] - me.y
        gap = gap_to(me, near, j, base, t, x, y, ux, uy, p)
        least = min(least, gap if dx * dx + dy * dy > 0.0 else math.inf)
    if surroundings.solids > 0:
        least = min(least, signed_distance(surroundings, x, y, 0.0) - 0.5 * p.length)
    return least


@compiled
def risk(me, near, surroundings, wheel, throttle, p, base):
    """Risk of a collision under a command: 0 for none, up to 2 the sooner and the closer it is.

    In the way is what comes nearer than the margin, and nearer than anything is now: a car can
    always get away.
    """
    step = p.ahead / STEPS
    keep = math.exp(-step / p.lag)
    bend = math.tan(wheel) / wheelbase(p)
    x, y, ux, uy, speed = me.x, me.y, me.ux, me.uy, me.speed
    worst = 0.0
    limit = min(p.margin, least_gap(me, near, surroundings, base, 0.0, x, y, ux, uy, p))
    for k in range(STEPS):
        before = speed
        speed = p.v_max * throttle + (speed - p.v_max * throttle) * keep
        gone = 0.5 * (before + speed) * step
        c, s = cos_sin(0.5 * gone * bend)
        x += gone * (c * ux - s * uy)
        y += gone * (s * ux + c * uy)
        c, s = c * c - s * s, 2.0 * c * s
        ux, uy = c * ux - s * uy, s * ux + c * uy
        gap = least_gap(me, near, surroundings, base, step * (k + 1), x, y, ux, uy, p)
        if gap < limit:
            close = min(1.0, (p.margin - gap) / (p.margin + 0.1))
            worst = max(worst, 1.0 - k / STEPS + close)
    return worst


@compiled
def goes_on(me, wheel, p, base):
    """Whether it backs out and still cannot reach its wish by turning: then it goes on with it."""
    backs = (me.signal[base + FRESH] == 0.0) & (me.signal[base + QUEUE + 1] < 0.0)
    return backs & (math.fabs(wheel) > 0.99 * math.radians(p.wheel_max))


@compiled
def yielded(me, near, surroundings, wheel, throttle, waited, p, base):
    """The command (wheel rad, throttle) nearest to the wished one that keeps clear of the others.

    Where none does, the one that puts it off longest. Backwards the wheels are best turned the
    other way, so that the nose swings to where it shall go. The longer it has stood (waited, s),
    the less it likes to stand.
    """
    worst = risk(me, near, surroundings, wheel, throttle, p, base)
    backs = goes_on(me, wheel, p, base)
    best_wheel, best_throttle = wheel, throttle
    if worst == 0.0 and not backs:
        return wheel, throttle
    turns_back = FICKLE if backs else 0.0
    least = RISK * worst + turns_back
    most = math.radians(p.wheel_max)
    for a in range(WHEELS + 1):
        angle = wheel if a == WHEELS else most * (2.0 * a / (WHEELS - 1.0) - 1.0)
        full = max(0.0, 1.0 - p.alpha_turn * math.fabs(angle))
        for b in range(PACES):
            back = b == PACES - 1
            pace = BACK if back else full * (1.0 - 0.5 * b)
            off = math.fabs(angle + wheel if back else angle - wheel)
            cost = TURNED * off + SLOWED * math.fabs(throttle - pace)
            cost += 0.0 if back else turns_back
            cost += WAITING * waited if b == PACES - 2 else 0.0
            if cost < least:
                cost += RISK * risk(me, near, surroundings, angle, pace, p, base)
                if cost < least:
                    least, best_wheel, best_throttle = cost, angle, pace
    return best_wheel, best_throttle
