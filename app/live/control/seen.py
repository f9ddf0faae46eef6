"""The last pose of each body and its age; gaps in the tracking are not filled in."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeGuard

from app.live.control.limits import CarLimits
from app.live.control.plausibility import reachable
from app.live.control.pose import MocapFrame, Pose, Sighting


@dataclass(frozen=True)
class LastPose:
    """The last pose of a body that was accepted."""

    pose: Pose
    time: float
    """When it was received, s on the loop's clock; never later than when it was taken."""


class Seen:
    """The last pose of each body that is followed. A car that seems to leap is rejected.

    `bodies` gives the laboratory's name of each tracked body that is followed; others are passed
    over. `cars` are the cars among these names; `leap` as in `Limits`.
    """

    def __init__(self, bodies: Mapping[str, str], cars: Mapping[str, CarLimits], leap: float):
        self.bodies = bodies
        self.cars = cars
        self.leap = leap
        self.last: dict[str, LastPose] = {}
        self.leaps: dict[str, float] = {}
        """Cars of the newest frame that are further off than they can have come, and how far (m)
        they are from where they were believed."""
        self.jumped: dict[str, tuple[float, float]] = {}
        """When (s) a car was last believed where it cannot have come to, and how far (m) that is
        from where it was."""
        self.why: dict[str, str] = {}
        """Why bodies of the newest frame are not tracked, where the source can tell."""
        self.frame: MocapFrame | None = None
        self.fresh: dict[str, Pose] = {}
        """Poses that the newest frame has brought."""

    def take(self, now: float, frame: MocapFrame | None, believing: bool = False) -> bool:
        """Take the newest frame; whether it is one that was not taken before.

        `believing` takes every pose as it is, also that of a car that was carried away. A body that
        is in the frame twice, or whose pose is no finite number, is not seen.
        """
        self.fresh = {}
        if believing:
            self.leaps.clear()
        if frame is None or (self.frame is not None and same(frame, self.frame)):
            return False
        self.frame = frame
        received = min(frame.received, now)
        times = Counter(sighting.name for sighting in frame.sightings)
        self.why = {self.bodies.get(one.name, ""): one.why for one in frame.sightings if one.why}
        for sighting in frame.sightings:
            pose = sighting.pose
            name = self.bodies.get(sighting.name)
            if name is None or times[sighting.name] > 1 or not sighting.valid or not finite(pose):
                continue
            if believing and not self.can_be(name, pose, received):
                self.jumped[name] = (now, self.leaps[name])
            if believing or self.can_be(name, pose, received):
                self.last[name] = LastPose(pose, received)
                self.leaps.pop(name, None)
                self.fresh[name] = pose
        return True

    def can_be(self, name: str, pose: Pose, time: float) -> bool:
        """Whether a car can have come there since it was last believed; notes a leap."""
        before = self.last.get(name)
        if before is None or name not in self.cars:
            return True
        far = math.hypot(pose.x - before.pose.x, pose.y - before.pose.y)
        seconds = max(time - before.time, 0.0)
        if far <= reachable(seconds, self.cars[name].fastest, self.leap):
            return True
        self.leaps[name] = far
        return False

    def age(self, name: str, now: float) -> float:
        """Seconds since a body was last seen; infinite if it never was."""
        last = self.last.get(name)
        return math.inf if last is None else max(now - last.time, 0.0)

    def sightings(self, now: float, stale: float) -> tuple[Sighting, ...]:
        """The last pose of every body that was seen within `stale` seconds, by name."""
        return tuple(
            Sighting(name, last.pose, True)
            for name, last in sorted(self.last.items())
            if now - last.time <= stale
        )


def same(one: MocapFrame, other: MocapFrame) -> bool:
    """Whether two frames are the same one: a source that begins again counts from 0."""
    return one.number == other.number and one.received == other.received


def finite(pose: Pose | None) -> TypeGuard[Pose]:
    """Whether it is a pose, and of finite numbers."""
    return pose is not None and all(map(math.isfinite, (pose.x, pose.y, pose.yaw)))
