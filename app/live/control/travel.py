"""Whether a car goes where its commands take it: finds frozen streams, stuck cars and cut links.

A frozen stream still brings frames, and each differs by the noise of the tracking; what gives it
away is that the car is told to drive and its pose stays where it is. How far a car should have come
is the answer of its motor to the throttle, v' = (speed throttle - v) / lag, seen DELAY later.
"""

from __future__ import annotations

import math
from collections import deque

from app.live.control.limits import CarLimits
from app.live.control.pose import Pose

DELAY = 0.05
"""Seconds from a command to the pose that shows it: link, servo and tracking."""
LEAST = 0.05
"""Metres that a car should have come before it is judged."""
SHARE = 0.25
"""Share of what it should have come below which it stands still."""


class Travel:
    """The commanded and the seen travel of one car over the last `window` seconds."""

    def __init__(self, car: CarLimits, window: float):
        self.car = car
        self.window = window
        self.forget(0.0)

    def forget(self, now: float) -> None:
        """Begin again with a car that stands."""
        self.now = now
        self.speed = 0.0
        self.gone = 0.0
        self.throttle = 0.0
        self.commanded: deque[tuple[float, float]] = deque([(now, 0.0)])
        self.seen: deque[tuple[float, float, float]] = deque()

    def see(self, now: float, pose: Pose) -> None:
        """A new pose of the car."""
        self.seen.append((now, pose.x, pose.y))
        while self.seen[0][0] < now - self.window:
            self.seen.popleft()

    def drive(self, now: float, throttle: float) -> None:
        """The throttle that the car is sent from `now` on."""
        self.advance(now)
        self.throttle = throttle if abs(throttle) > self.car.rests else 0.0

    def advance(self, now: float) -> None:
        """Bring the commanded travel up to `now`, exactly for a throttle that was constant."""
        step = now - self.now
        wanted = self.car.speed * self.throttle
        decay = math.exp(-step / self.car.lag) if self.car.lag > 0.0 else 0.0
        self.gone += wanted * step + (self.speed - wanted) * self.car.lag * (1.0 - decay)
        self.speed = wanted + (self.speed - wanted) * decay
        self.now = now
        self.commanded.append((now, self.gone))
        while self.commanded[0][0] < now - self.window:
            self.commanded.popleft()

    @property
    def expected(self) -> float:
        """How far (m) it should be seen to have come within the window, from its furthest point."""
        known = [gone for at, gone in self.commanded if at <= self.now - DELAY]
        return max((abs(known[-1] - gone) for gone in known), default=0.0)

    @property
    def came(self) -> float:
        """How far (m) it is seen to have come within the window, from its furthest point."""
        if not self.seen:
            return 0.0
        _, x, y = self.seen[-1]
        return max(math.hypot(x - a, y - b) for _, a, b in self.seen)

    def stands(self) -> bool:
        """Whether it should have moved by now and has not."""
        expected = self.expected
        return expected >= LEAST and self.came < SHARE * expected
