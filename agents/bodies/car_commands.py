"""Turn a wish into the motion of a car: the computer's command, the radio, wheels and motor.

The signals of the body are the rows of `out` from `base` on: see `agents.bodies.car_commands`.
"""

from __future__ import annotations

import math

from agents.bodies.tracking import is_seen, yaw_error
from agents.engine.noise import cos_sin, uniform
from worlds.compilation import compiled
from worlds.queries.crossing import is_crossed
from worlds.queries.surroundings import signed_distance

# What cars tell each other: the rows of a car's signals, from the body's first one on.

FRESH, STEERING, PACE, WHEEL, THROTTLE, STUCK, STOPS = range(7)
"""1.0 until it has moved once; angle of its wheels, rad; speed, m/s; the command that it has, rad
and share of full throttle; the time (s) that it has not got on, below 0 while it backs out for
having been stuck; ticks in which something has stopped it."""
QUEUE = 7
"""The commands sent, the latest first: wheel, throttle, wheel, ..."""
LONGEST = 24
"""Commands kept; the longest way of one is a tick less."""
ROWS = QUEUE + 2 * LONGEST
SIGNALS = (
    "fresh",
    "steering",
    "pace",
    "wheel",
    "throttle",
    "stuck",
    "stops",
    *(f"{what} sent {ago}" for ago in range(1, LONGEST + 1) for what in ("wheel", "throttle")),
)
"""Their names; the commands sent, 1 for the latest, each a tick after the next."""
WORDS = {
    "fresh": "has not moved yet?",
    "steering": "front wheels turned",
    "pace": "speed it tells",
    "wheel": "wheels commanded",
    "throttle": "throttle commanded",
    "stuck": "stuck for",
    "stops": "ticks stopped",
    **{name: name for name in SIGNALS[QUEUE:]},
}
"""What people call them."""


# The mechanics of a car: a bicycle that turns about its rear axle, a rectangle that others stop.
#
# Angles in rad, to the left positive; lengths in m; times in s. A speed below 0 is backwards.


@compiled
def wheelbase(p):
    """L_eff = R tan(delta_max) of a car whose turning circle has the diameter 2 R, m."""
    return 0.5 * p.circle * math.tan(math.radians(p.wheel_max))


@compiled
def roll(x, y, ux, uy, speed, wheel, length, dt):
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
    length_sum, width_sum = a + a * c + b * s, b + a * s + b * c
    return max(
        max(math.fabs(dx * ux + dy * uy) - length_sum, math.fabs(dy * ux - dx * uy) - width_sum),
        max(math.fabs(dx * vx + dy * vy) - length_sum, math.fabs(dy * vx - dx * vy) - width_sum),
    )


@compiled
def nearest_car(me, near, x, y, ux, uy, p):
    """Separation (m) of the nearest other car from this one at (x, y) along (ux, uy); or inf.

    The block holds this car too, and knows it by its place and heading: of several that share both,
    all but one are others.
    """
    nearest_gap = math.inf
    same_poses = 0
    for j in range(near.n):
        ex, ey = near.x[j] - me.x, near.y[j] - me.y
        is_same_pose = (ex * ex + ey * ey == 0.0) & (near.ux[j] == me.ux) & (near.uy[j] == me.uy)
        same_poses += 1 if is_same_pose else 0
        gap = separation(
            near.x[j] - x, near.y[j] - y, ux, uy, near.ux[j], near.uy[j], p.length, p.width
        )
        nearest_gap = min(nearest_gap, math.inf if is_same_pose else gap)
    if same_poses > 1:
        gap = separation(me.x - x, me.y - y, ux, uy, me.ux, me.uy, p.length, p.width)
        nearest_gap = min(nearest_gap, gap)
    return nearest_gap


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


# Looking ahead: of the commands that are safe a car takes the one nearest to its wish.
#
# Added to Jacobs and Koessler, whose cars go for their wish whatever is in the way. The others are
# taken to go on as they are: at their speed, with their wheels as they stand. Bodies are taken as
# two discs each, which cover the rectangle.

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
    has_moved = 1.0 - near.signal[base + FRESH, j]
    speed = has_moved * near.signal[base + PACE, j]
    half = 0.5 * t * speed * math.tan(has_moved * near.signal[base + STEERING, j]) / wheelbase(p)
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
    smallest_gap = math.inf
    for j in range(near.n):
        dx, dy = near.x[j] - me.x, near.y[j] - me.y
        gap = gap_to(me, near, j, base, t, x, y, ux, uy, p)
        smallest_gap = min(smallest_gap, gap if dx * dx + dy * dy > 0.0 else math.inf)
    if surroundings.solids > 0:
        smallest_gap = min(smallest_gap, signed_distance(surroundings, x, y, 0.0) - 0.5 * p.length)
    return smallest_gap


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
        speed_before = speed
        speed = p.v_max * throttle + (speed - p.v_max * throttle) * keep
        travelled = 0.5 * (speed_before + speed) * step
        c, s = cos_sin(0.5 * travelled * bend)
        x += travelled * (c * ux - s * uy)
        y += travelled * (s * ux + c * uy)
        c, s = c * c - s * s, 2.0 * c * s
        ux, uy = c * ux - s * uy, s * ux + c * uy
        gap = least_gap(me, near, surroundings, base, step * (k + 1), x, y, ux, uy, p)
        if gap < limit:
            closeness = min(1.0, (p.margin - gap) / (p.margin + 0.1))
            worst = max(worst, 1.0 - k / STEPS + closeness)
    return worst


@compiled
def must_back_out(me, wheel, p, base):
    """Whether it backs out and still cannot reach its wish by turning: then it goes on with it."""
    backs = (me.signal[base + FRESH] == 0.0) & (me.signal[base + QUEUE + 1] < 0.0)
    return backs & (math.fabs(wheel) > 0.99 * math.radians(p.wheel_max))


@compiled
def choose_clear_command(me, near, surroundings, wheel, throttle, waiting_time, p, base):
    """The command (wheel rad, throttle) nearest to the wished one that keeps clear of the others.

    Where none does, the one that puts it off longest. Backwards the wheels are best turned the
    other way, so that the nose swings to where it shall go. The longer it has stood (waited, s),
    the less it likes to stand.
    """
    worst = risk(me, near, surroundings, wheel, throttle, p, base)
    backs = must_back_out(me, wheel, p, base)
    best_wheel, best_throttle = wheel, throttle
    if worst == 0.0 and not backs:
        return wheel, throttle
    turns_back = FICKLE if backs else 0.0
    least_cost = RISK * worst + turns_back
    wheel_limit = math.radians(p.wheel_max)
    for a in range(WHEELS + 1):
        angle = wheel if a == WHEELS else wheel_limit * (2.0 * a / (WHEELS - 1.0) - 1.0)
        full_throttle = max(0.0, 1.0 - p.alpha_turn * math.fabs(angle))
        for b in range(PACES):
            back = b == PACES - 1
            pace = BACK if back else full_throttle * (1.0 - 0.5 * b)
            off = math.fabs(angle + wheel if back else angle - wheel)
            cost = TURNED * off + SLOWED * math.fabs(throttle - pace)
            cost += 0.0 if back else turns_back
            cost += WAITING * waiting_time if b == PACES - 2 else 0.0
            if cost < least_cost:
                cost += RISK * risk(me, near, surroundings, angle, pace, p, base)
                if cost < least_cost:
                    least_cost, best_wheel, best_throttle = cost, angle, pace
    return best_wheel, best_throttle


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
    wheel_limit = math.radians(p.wheel_max)
    return min(max(angle, -wheel_limit), wheel_limit)


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
        return choose_clear_command(
            me, near, surroundings, wheel, throttle_for(wheel, p), time, p, base
        )
    if time < 0.0:
        return -wheel, BACK
    return wheel, throttle_for(wheel, p)


@compiled
def queue_command(me, wheel, throttle, p, base, out):
    """Put a command at the head of the queue; for a car that is not seen, the last one again."""
    ready = 1.0 - me.signal[base + FRESH]
    queue = base + QUEUE
    for k in range(2 * LONGEST - 2):
        out[queue + 2 + k] = ready * me.signal[queue + k]
    is_tracked = is_seen(me, p)
    out[queue] = wheel if is_tracked else ready * me.signal[queue]
    out[queue + 1] = throttle if is_tracked else ready * me.signal[queue + 1]


@compiled
def receive_command(me, p, base, out):
    """The command in force: the one sent as long ago as its way takes, or the one before if lost.

    Tracking that is late by t is the same as commands that are: both act on poses of t ago.
    """
    ready = 1.0 - me.signal[base + FRESH]
    delay_ticks = math.floor((p.latency + me.id * p.hop) / p.dt + 0.5)
    at = base + QUEUE + 2 * int(min(delay_ticks, LONGEST - 1.0))
    is_lost = uniform(me.key, me.id, LOST) < p.loss
    wheel = ready * me.signal[base + WHEEL] if is_lost else out[at]
    throttle = ready * me.signal[base + THROTTLE] if is_lost else out[at + 1]
    out[base + WHEEL] = wheel
    out[base + THROTTLE] = throttle
    return wheel, throttle
