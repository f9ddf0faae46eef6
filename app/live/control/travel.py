"""Whether a car goes where its commands take it, and stays where it is told to stand.

A frozen stream still brings frames, and each differs by the noise of the tracking; what gives it
away is that the car is told to drive and its pose stays where it is. How far a car should have come
is the answer of its motor to the throttle, v' = (speed throttle - v) / lag, seen DELAY later.
"""

from __future__ import annotations

import math
from collections import deque

from app.live.control.pose import Pose
from app.live.control.safety_limits import CarLimits
from app.live.links.firmware import WATCHDOG

DELAY = 0.05
"""Seconds from a command to the pose that shows it: link, servo and tracking."""
LEAST = 0.05
"""Metres that a car should have come before it is judged."""
SHARE = 0.25
"""Share of what it should have come below which it stands still."""
PATIENT = 10.0
"""How many windows are looked back at most for a slow car to have come LEAST."""
AGAINST = -0.5
"""Cosine between its nose and its way below which a car goes against its nose: 120 degrees."""
STRAY = 0.05
"""Metres that a car may seem to move while it stands: a person beside it, a camera that is hit."""
COASTS = 3.0
"""Motor lags after which a car that rolls out stands but for a twentieth of its way."""
RESTS = 1.0
"""Seconds without moving after which a car stands again, or unseen after which it may have been
carried."""


class Travel:
    """The commanded and the seen travel of one car.

    It is judged over the last `window` seconds; over up to `PATIENT` of them where the car was too
    slow to come `LEAST` in one.
    """

    def __init__(self, car: CarLimits, window: float):
        self.car = car
        self.window = window
        self.forget(0.0)

    def forget(self, now: float) -> None:
        """Begin again with a car that stands."""
        self.now = now
        self.speed = 0.0
        self.gone = 0.0
        self.path = 0.0
        self.throttle = 0.0
        self.commanded: deque[tuple[float, float, float]] = deque([(now, 0.0, 0.0)])
        """Time, where it should be along its way, and the length of the way to there, m."""
        self.seen: deque[tuple[float, float, float]] = deque()
        self.against: float | None = None
        """Since when it is seen to go against its nose, s."""

    def add_pose(self, now: float, pose: Pose) -> None:
        """A new pose of the car."""
        self.seen.append((now, pose.x, pose.y))
        while self.seen[0][0] < now - PATIENT * self.window:
            self.seen.popleft()
        if not self.is_reversed(pose):
            self.against = None
        elif self.against is None:
            self.against = now

    def drive(self, now: float, throttle: float) -> None:
        """The throttle that the car is sent from `now` on."""
        self.advance(now)
        self.throttle = throttle if abs(throttle) > self.car.rests else 0.0

    def advance(self, now: float) -> None:
        """Bring the commanded travel up to `now`, exactly for a throttle that was constant."""
        step = now - self.now
        target_speed = self.car.speed * self.throttle
        decay = math.exp(-step / self.car.lag) if self.car.lag > 0.0 else 0.0
        far = target_speed * step + (self.speed - target_speed) * self.car.lag * (1.0 - decay)
        self.gone += far
        self.path += abs(far)
        self.speed = target_speed + (self.speed - target_speed) * decay
        self.now = now
        self.commanded.append((now, self.gone, self.path))
        while self.commanded[0][0] < now - PATIENT * self.window:
            self.commanded.popleft()

    def expected_and_since(self) -> tuple[float, float]:
        """How far (m) it should be seen to have come, from its furthest point, and since when.

        Since `window` seconds ago, or since so long ago that it should have come `LEAST`.
        """
        due, begins = self.now - DELAY, self.now - self.window
        far, newest = 0.0, None
        for at, distance, path in reversed(self.commanded):
            if at > due:
                continue
            if newest is None:
                newest = distance
                if path - self.commanded[0][2] < LEAST:  # it should not have come so far at all
                    return 0.0, begins
            if at < begins and far >= LEAST:
                break
            far = max(far, abs(newest - distance))
            since = at
        return (far, min(since, begins)) if newest is not None else (0.0, begins)

    @property
    def expected(self) -> float:
        """How far (m) it should be seen to have come, from its furthest point."""
        return self.expected_and_since()[0]

    def seen_distance(self, since: float) -> float:
        """How far (m) it is seen to have come from its furthest point since then."""
        if not self.seen:
            return 0.0
        _, x, y = self.seen[-1]
        far = 0.0
        for at, a, b in reversed(self.seen):
            if at < since:
                break
            far = max(far, math.hypot(x - a, y - b))
        return far

    def is_stuck(self) -> bool:
        """Whether it should have moved by now and has not."""
        expected, since = self.expected_and_since()
        return expected >= LEAST and self.seen_distance(since) < SHARE * expected

    def is_reversed(self, pose: Pose) -> bool:
        """Whether it has come `LEAST` against the nose of its newest pose, as it was not told."""
        if self.path - self.commanded[0][2] < LEAST:
            return False
        for at, a, b in reversed(self.seen):
            along, across = pose.x - a, pose.y - b
            far = math.hypot(along, across)
            if far >= LEAST:
                commanded_distance = self.expected_at(self.now - DELAY) - self.expected_at(
                    at - DELAY
                )
                ahead = (along * math.cos(pose.yaw) + across * math.sin(pose.yaw)) / far
                return (
                    abs(commanded_distance) >= SHARE * LEAST
                    and math.copysign(ahead, ahead * commanded_distance) < AGAINST
                )
        return False

    def expected_at(self, time: float) -> float:
        """Where it should have been along its way at a time, m."""
        for at, distance, _ in reversed(self.commanded):
            if at <= time:
                return distance
        return self.commanded[0][1]


class Standstill:
    """Whether a car stays where it is while it is told to stand, armed or not.

    Told to stand it may roll on: at full speed until its own watchdog must have stopped the motor,
    then with the motor's lag, then not at all.
    """

    def __init__(self, car: CarLimits):
        self.car = car
        self.told: float | None = None
        """Since when it is told to stand, s; None while it is told to drive."""
        self.anchor: tuple[float, float] | None = None
        """From where on it is watched, m; and since when, s."""
        self.anchored = self.seen = 0.0
        self.settled = 0
        """How many of the stages of rolling out are over."""
        self.moves = False

    def set_throttle(self, now: float, throttle: float) -> None:
        """The throttle that the car is sent from `now` on."""
        if throttle != 0.0:
            self.told, self.moves = None, False
        elif self.told is None:
            self.told, self.anchor, self.settled = now, None, 0

    def add_pose(self, now: float, pose: Pose) -> None:
        """A new pose of the car."""
        gap = now - self.seen > RESTS
        self.seen = now
        if self.told is None:
            return
        stages = self.stages()
        settled = sum(now - self.told > until for until, _ in stages)
        if self.anchor is None or gap or settled > self.settled:
            self.anchor, self.anchored, self.settled = (pose.x, pose.y), now, settled
        allowed = stages[settled][1] if settled < len(stages) else STRAY
        if math.hypot(pose.x - self.anchor[0], pose.y - self.anchor[1]) > allowed:
            self.anchor, self.anchored, self.moves = (pose.x, pose.y), now, True
        elif now - self.anchored > RESTS:
            self.moves = False

    def stages(self) -> tuple[tuple[float, float], ...]:
        """The stages of rolling out: until when (s since it was told to stand) and how far (m)."""
        stopped = WATCHDOG + DELAY
        return (
            (stopped, self.car.fastest * stopped + STRAY),
            (stopped + COASTS * self.car.lag, self.car.fastest * self.car.lag + STRAY),
        )
