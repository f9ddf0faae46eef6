"""Cars after Jacobs and Koessler: one tick written plainly, and closed forms on a circle.

The rule is (2) and (3) of the paper; the car is a bicycle that turns about a point on the line of
its rear axle. Angles in rad unless a name says degrees, lengths in m, times in s.
"""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from shapely.affinity import rotate, translate
from shapely.geometry import box


@dataclass(frozen=True)
class Cars:
    """Symbols of the paper and of the reading's plant; angles in degrees."""

    beta: float = 2.0
    C: float = 0.7
    gamma: float = 0.214
    k: int = 0
    c_goal: float = 1.0
    c_align: float = 0.0
    derivative: float = 0.0
    integral: float = 0.0
    windup: float = 1.0
    power: float = 1.0
    soft: float = 0.0
    sensing: str = "tracking"
    alpha_s: float = 360.0
    r: float = 20.0
    predators: int = 0
    beta_p: float = 0.6
    C_p: float = 1.2
    v_max: float = 1.0
    alpha_turn: float = 0.4
    wheel_max: float = 45.0
    circle: float = 0.95
    lag: float = 0.15
    servo: float = 7.0
    latency: float = 0.0
    hop: float = 0.0
    dt: float = 0.01


def sigma(v, beta, c, gamma):
    """The vector squashing function (3)."""
    r = np.linalg.norm(v)
    return beta * v / r * (-c + r / (r + gamma))


def shaped(v, beta, c, gamma, p):
    """(3) of another shape: zero where (3) is, if it is anywhere, and -C beta at r = -soft."""
    r = np.linalg.norm(v)
    zero = c * gamma / (1.0 - c) if 0.0 < c < 1.0 else None
    if zero is None:
        ratio = ((r + p.soft) / gamma) ** p.power
    else:  # c / (1 - c) at the zero, where ratio / (1 + ratio) = c
        ratio = ((r + p.soft) / (zero + p.soft)) ** p.power * c / (1.0 - c)
    return beta * v / r * (-c + ratio / (1.0 + ratio))


def is_seen(i, place, position, heading, p):
    """Whether car i's own sensors, or the tracking, tell it of what is at a place."""
    away = place - position[i]
    d = np.linalg.norm(away)
    if d > p.r:
        return False
    off = math.degrees(math.acos(np.clip(away @ heading[i] / d, -1.0, 1.0)))
    return p.sensing == "tracking" or off <= p.alpha_s / 2


def desired(i, position, heading, goal, p):
    """D_i of (2), row i having the number i + 1; goal is None or the injected car's position."""
    seen = [
        j for j in range(len(position)) if j != i and is_seen(i, position[j], position, heading, p)
    ]
    prey = [j for j in seen if j >= p.predators]
    prey.sort(key=lambda j: np.linalg.norm(position[j] - position[i]))
    if i < p.predators:
        if not prey:
            return np.zeros(2)
        return sigma(position[prey[0]] - position[i], p.beta, 0.0, p.gamma)
    total = np.zeros(2)
    for j in prey[: p.k or None]:
        total += shaped(position[j] - position[i], p.beta, p.C, p.gamma, p) + p.c_align * heading[j]
    for j in seen:
        if j < p.predators:
            total += shaped(position[j] - position[i], p.beta_p, p.C_p, p.gamma, p)
    if goal is not None and (p.sensing != "own" or is_seen(i, goal, position, heading, p)):
        total += p.c_goal * shaped(goal - position[i], p.beta, p.C, p.gamma, p)
    return total


def cut(total, p):
    """What D has added up to, no longer than windup."""
    return total / max(1.0, np.linalg.norm(total) / p.windup)


class Plant:
    """Cars that get a command each tick, which comes after as many ticks as its way takes."""

    def __init__(self, position, heading, speed, p):
        self.p = p
        self.x = np.array(position, float)
        self.yaw = np.arctan2(*np.array(heading, float).T[::-1])
        self.v = np.array(speed, float)
        self.steering = np.zeros(len(self.x))
        ways = [round((p.latency + (i + 1) * p.hop) / p.dt) for i in range(len(self.x))]
        self.radio = [deque([(0.0, 0.0)] * way) for way in ways]
        self.last = [None] * len(self.x)
        self.sums = [np.zeros(2)] * len(self.x)

    @property
    def heading(self):
        """Unit vectors (N, 2)."""
        return np.column_stack([np.cos(self.yaw), np.sin(self.yaw)])

    def tick(self, goal):
        """All cars decide on what is, then all move."""
        heading = self.heading
        wanted = [desired(i, self.x, heading, goal, self.p) for i in range(len(self.x))]
        self.sums = [cut(s + self.p.dt * d, self.p) for s, d in zip(self.sums, wanted, strict=True)]
        for i, d in enumerate(wanted):
            before, self.last[i] = self.last[i], d
            if before is not None:
                d = d + self.p.derivative * (d - before) / self.p.dt
            d = d + self.p.integral * self.sums[i]
            self.drive(i, d)

    def drive(self, i, d):
        """One car: command, radio, servo, motor, roll."""
        p = self.p
        most = math.radians(p.wheel_max)
        off = math.remainder(math.atan2(d[1], d[0]) - self.yaw[i], 2 * math.pi)
        wheel = min(max(off, -most), most) if d.any() else 0.0
        self.radio[i].append((wheel, max(0.0, 1.0 - p.alpha_turn * abs(wheel))))
        wheel, throttle = self.radio[i].popleft()
        turn = min(max(wheel - self.steering[i], -p.servo * p.dt), p.servo * p.dt)
        self.steering[i] += turn
        aim = p.v_max * throttle
        self.v[i] = aim + (self.v[i] - aim) * math.exp(-p.dt / p.lag)
        self.roll(i)

    def roll(self, i):
        """Turn about the point where the axles' lines meet."""
        p, yaw, gone = self.p, self.yaw[i], self.v[i] * self.p.dt
        length = p.circle / 2 * math.tan(math.radians(p.wheel_max))
        if abs(self.steering[i]) < 1e-7:
            self.x[i] += gone * np.array([math.cos(yaw), math.sin(yaw)])
            return
        radius = length / math.tan(self.steering[i])
        centre = self.x[i] + radius * np.array([-math.sin(yaw), math.cos(yaw)])
        self.yaw[i] = yaw + gone / radius
        self.x[i] = centre + radius * np.array([math.sin(self.yaw[i]), -math.cos(self.yaw[i])])


def behind_a_circle(radius, speed, p):
    """(radius m, lag rad) of one car behind a target at `speed` on a circle: the closed form.

    The wheel angle delta is the bearing of the target, so w = speed / radius, r = v / w with
    v = v_max (1 - alpha_turn delta), tan delta = L / r, and the triangle gives the lag.
    """
    w = speed / radius
    length = p.circle / 2 * math.tan(math.radians(p.wheel_max))
    low, high = 0.0, math.radians(p.wheel_max)
    for _ in range(200):
        delta = 0.5 * (low + high)
        r = p.v_max * (1.0 - p.alpha_turn * delta) / w
        low, high = (delta, high) if math.tan(delta) < length / r else (low, delta)
    return r, math.pi / 2 + delta - math.asin(r * math.cos(delta) / radius)


def zero_turn_behind_a_circle(radius, speed, p):
    """Lag (rad) of one car that goes with D behind a target at `speed` on a circle.

    It goes straight at the target, along the tangent of its own circle of radius R cos(lag), at a
    distance R sin(lag): speed cos(lag) = |sigma(R sin(lag))|.
    """
    low, high = 1e-6, math.pi / 2
    for _ in range(200):
        lag = 0.5 * (low + high)
        d = radius * math.sin(lag)
        slow = p.beta * (-p.C + d / (d + p.gamma)) < speed * math.cos(lag)
        low, high = (lag, high) if slow else (low, lag)
    return lag


def rectangle(x, y, yaw, length, width):
    """A car's body as a polygon."""
    body = box(-length / 2, -width / 2, length / 2, width / 2)
    return translate(rotate(body, yaw, origin=(0, 0), use_radians=True), x, y)
