"""What is measured of a room: the times of its loop, how close its cars are, how they lag."""

from __future__ import annotations

import math
from itertools import combinations

from app.live.control.injected_target import Injection
from app.live.control.loop_status import Status
from app.live.control.pose import Pose
from app.viewer.measuring.time_series import TimeSeries

EVERY = 0.1
"""Seconds between two values, at least."""
SLACK = 1e-9
MS = 1000.0


class RoomReadings:
    """What is measured of a room, over the seconds since it was opened.

    One thread notes; others may read it meanwhile.
    """

    def __init__(self, plan: Injection):
        """`plan` is how the injected car moves."""
        self.plan = plan
        self.began: float | None = None
        """`Status.time` of the first status, s."""
        self.noted = -math.inf
        """That of the last one that was taken, s."""
        self.loop = TimeSeries(gaps=True)
        """From tick to tick, median of the last ones, ms."""
        self.worst = TimeSeries(gaps=True)
        """From tick to tick, the longest of the last ones, ms."""
        self.latency = TimeSeries(gaps=True)
        """From a frame to its commands, median of the last ones, ms."""
        self.least = TimeSeries(gaps=True)
        """Between the middles of any two cars, real or simulated, m."""
        self.lags: dict[str, TimeSeries] = {}
        """By car, how far it is behind an injected car that goes round a circle, deg; only of cars
        that have lagged, with a gap where one was not there."""

    def note(self, status: Status) -> None:
        """Take a status, unless it follows the last one too soon.

        A lost car has no place: where it is nobody knows.
        """
        if status.time < self.noted + EVERY - SLACK:
            return
        self.began = status.time if self.began is None else self.began
        self.noted = status.time
        poses = {
            car.name: car.pose
            for car in status.cars
            if car.pose is not None and car.tracking != "lost"
        } | {one.name: one.pose for one in status.companions}
        now = status.time - self.began
        self.loop.add(now, MS * status.period.median)
        self.worst.add(now, MS * status.period.worst)
        self.latency.add(now, MS * status.latency.median)
        self.least.add(now, least_distance(list(poses.values())))
        lags = {} if status.injected is None else phase_lags(self.plan, status.injected, poses)
        new = lags.keys() - self.lags.keys()
        self.lags = self.lags | {name: TimeSeries(gaps=True) for name in lags if name in new}
        for name, series in self.lags.items():
            series.add(now, lags.get(name, math.nan))


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
