"""What the monitors of a room plot: the times of its loop, how close its cars are, how they lag."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations

import numpy as np

from app.live.control.injected import Injection
from app.live.control.pose import Pose
from app.live.control.status import Status

KEPT = 120.0
"""Seconds that are kept."""
EVERY = 0.1
"""Seconds between two points, at least."""
SLACK = 1e-9
MS = 1000.0


@dataclass(frozen=True)
class Point:
    """One moment; NaN where there is nothing to tell."""

    time: float
    """`Status.time`, s."""
    loop: float
    worst: float
    latency: float
    least: float
    lags: dict[str, float]


@dataclass(frozen=True)
class Course:
    """The last two minutes of a room since it was opened. It is never changed: `after` makes
    another."""

    plan: Injection
    """How the injected car moves."""
    began: float | None = None
    """`Status.time` of the first status, s."""
    points: tuple[Point, ...] = field(default=(), repr=False)

    def after(self, status: Status) -> Course:
        """The course with another status, unless it follows the last point too soon."""
        if self.points and status.time < self.points[-1].time + EVERY - SLACK:
            return self
        began = status.time if self.began is None else self.began
        kept = [point for point in self.points if point.time >= status.time - KEPT - SLACK]
        return Course(self.plan, began, (*kept, self.point(status)))

    def point(self, status: Status) -> Point:
        """The point of a status. A lost car has no place: where it is nobody knows."""
        poses = {
            car.name: car.pose
            for car in status.cars
            if car.pose is not None and car.tracking != "lost"
        } | {one.name: one.pose for one in status.companions}
        return Point(
            status.time,
            MS * status.period.median,
            MS * status.period.worst,
            MS * status.latency.median,
            least_distance(list(poses.values())),
            {} if status.injected is None else phase_lags(self.plan, status.injected, poses),
        )

    @cached_property
    def times(self) -> np.ndarray:
        """Seconds since the room was opened, (T,)."""
        return self.of(lambda point: point.time - (self.began or 0.0))

    @cached_property
    def loop(self) -> np.ndarray:
        """From tick to tick, median of the last ones, (T,), ms."""
        return self.of(lambda point: point.loop)

    @cached_property
    def worst(self) -> np.ndarray:
        """From tick to tick, the longest of the last ones, (T,), ms."""
        return self.of(lambda point: point.worst)

    @cached_property
    def latency(self) -> np.ndarray:
        """From a frame to its commands, median of the last ones, (T,), ms."""
        return self.of(lambda point: point.latency)

    @cached_property
    def least(self) -> np.ndarray:
        """Between the middles of any two cars, real or simulated, (T,), m."""
        return self.of(lambda point: point.least)

    @cached_property
    def lags(self) -> dict[str, np.ndarray]:
        """By car, how far it is behind an injected car that goes round a circle, (T,), deg.

        Only cars that have lagged; NaN where a car was not there.
        """
        names = dict.fromkeys(name for point in self.points for name in point.lags)
        return {
            name: np.array([point.lags.get(name, math.nan) for point in self.points])
            for name in names
        }

    def of(self, value: Callable[[Point], float]) -> np.ndarray:
        """A value of every point, (T,)."""
        return np.array([value(point) for point in self.points], float)


def least_distance(poses: list[Pose]) -> float:
    """The distance of the two that are closest, m; NaN of fewer than two."""
    apart = [math.hypot(a.x - b.x, a.y - b.y) for a, b in combinations(poses, 2)]
    return min(apart, default=math.nan)


def phase_lags(plan: Injection, injected: Pose, poses: dict[str, Pose]) -> dict[str, float]:
    """By how much each is behind the injected car round its circle, deg; none off a circle.

    The convention is that of `app.experiments.kinds.driving.lags`, along the injected car's sense.
    """
    if plan.path != "circle":
        return {}
    sense = -1.0 if plan.speed < 0.0 else 1.0
    ahead = angle(plan, injected)
    return {name: behind(sense * (ahead - angle(plan, pose))) for name, pose in poses.items()}


def angle(plan: Injection, pose: Pose) -> float:
    """Where a pose is about the centre of the circle, rad."""
    return math.atan2(pose.y - plan.centre[1], pose.x - plan.centre[0])


def behind(turned: float) -> float:
    """An angle (rad) in (-180, 180] deg.

    >>> behind(-math.pi), behind(0.5 * math.pi)
    (180.0, 90.0)
    """
    degrees = math.degrees(math.remainder(turned, 2.0 * math.pi))
    return 180.0 if degrees <= -180.0 else degrees
