"""The last pose of each body and its age; gaps in the tracking are not filled in.

Here is decided what counts as fresh, for every source:

- A frame counts while armed if its number is above the last one's, and so is the time of the source
  where the source tells it (`MocapFrame.sent`).
- A car that was told to drive since it was last seen must be seen at another pose: one that is the
  last pose to the bit is no sighting, and neither is any pose of the last `REMEMBERED` where the
  source tells no time of its own, whether a tick has steered by it or has only passed over it. Real
  tracking is never the same twice: such a frame is an old one that a library or a stranger hands
  out again.
- A car that was told to stand ever since may be seen where it was, to the bit: tracking in software
  has no noise.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeGuard

from app.live.control.plausibility import reachable_distance
from app.live.control.pose import MocapFrame, Pose, Sighting
from app.live.control.safety_limits import CarLimits

REMEMBERED = 6000
"""Poses of a car that are known again: a minute of them at 100 Hz."""
TURN = 1.2
"""Radians that a car may be seen to have turned at once: more is no noise."""
TIGHTEST = 0.3
"""Radius (m) of the tightest curve that any car of the laboratory can drive."""


@dataclass(frozen=True)
class LastPose:
    """The last pose of a body that was accepted."""

    pose: Pose
    time: float
    """When it was received, s on the loop's clock; never later than when it was taken."""


class PoseTracker:
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
        self.turns: dict[str, float] = {}
        """Cars of the newest frame that have turned faster than any can, and by how much (rad)."""
        self.driven: set[str] = set()
        """Cars that were told to drive since they were last seen."""
        self.repeated: set[str] = set()
        """Cars whose newest poses are old ones that come again."""
        self.past: dict[str, dict[Pose, None]] = {name: {} for name in cars}
        """The last poses of each car, oldest first."""
        self.frame: MocapFrame | None = None
        self.fresh: dict[str, Pose] = {}
        """Poses that the newest frame has brought."""

    def take(self, now: float, frames: Sequence[MocapFrame], believing: bool = False) -> bool:
        """Take the newest of the frames that have come; whether there is one that counts.

        `believing` takes every pose as it is, also that of a car that was carried away. A body that
        is in the frame twice, or whose pose is no finite number, is not seen.
        """
        taken = self.take_newest(now, frames[-1] if frames else None, believing)
        for passed in frames[:-1]:  # a stranger may have heard them too
            self.remember(passed)
        return taken

    def take_newest(self, now: float, frame: MocapFrame | None, believing: bool) -> bool:
        """Take a frame; see `take`."""
        self.fresh = {}
        if believing:
            self.leaps.clear()
            self.turns.clear()
            self.repeated.clear()
        if frame is None or not self.counts(frame, believing):
            return False
        self.frame = frame
        received = min(frame.received, now)
        times = Counter(sighting.name for sighting in frame.sightings)
        self.why = {
            self.bodies.get(sighting.name, ""): sighting.why
            for sighting in frame.sightings
            if sighting.why
        }
        for sighting in frame.sightings:
            pose = sighting.pose
            name = self.bodies.get(sighting.name)
            if name is None or times[sighting.name] > 1 or not sighting.valid or not finite(pose):
                continue
            if believing and not self.is_reachable(name, pose, received):
                self.jumped[name] = (now, self.leaps[name])
            if not believing and self.is_old(name, pose, frame):
                self.repeated.add(name)
                continue
            if believing or (
                self.is_reachable(name, pose, received) and self.can_face(name, pose, received)
            ):
                self.last[name] = LastPose(pose, received)
                self.leaps.pop(name, None)
                self.turns.pop(name, None)
                self.driven.discard(name)
                self.repeated.discard(name)
                self.fresh[name] = pose
        self.remember(frame)
        return True

    def counts(self, frame: MocapFrame, believing: bool) -> bool:
        """Whether a frame is newer than the last one, by its number and by the source's own time.

        While `believing` any other frame will do: a source that was opened again counts from 0.
        """
        last = self.frame
        if last is None:
            return True
        if believing:
            return not is_same_frame(frame, last)
        if frame.number <= last.number:
            return False
        return frame.sent is None or last.sent is None or frame.sent > last.sent

    def is_old(self, name: str, pose: Pose, frame: MocapFrame) -> bool:
        """Whether a car was told to drive and is seen where it was before, to the bit."""
        if name not in self.driven or name not in self.last:
            return False
        return pose == self.last[name].pose or (frame.sent is None and pose in self.past[name])

    def remember(self, frame: MocapFrame) -> None:
        """Know the poses of the cars again, as long as they are among the newest."""
        for sighting in frame.sightings:
            past = self.past.get(self.bodies.get(sighting.name, ""))
            if past is not None and sighting.pose is not None:
                past[sighting.pose] = None
                if len(past) > REMEMBERED:
                    del past[next(iter(past))]

    def is_reachable(self, name: str, pose: Pose, time: float) -> bool:
        """Whether a car can have come there since it was last believed; notes a leap."""
        before = self.last.get(name)
        if before is None or name not in self.cars:
            return True
        far = math.hypot(pose.x - before.pose.x, pose.y - before.pose.y)
        seconds = max(time - before.time, 0.0)
        if far <= reachable_distance(seconds, self.cars[name].fastest, self.leap):
            return True
        self.leaps[name] = far
        return False

    def can_face(self, name: str, pose: Pose, time: float) -> bool:
        """Whether a car can have turned so far since it was last believed; notes a turn."""
        before = self.last.get(name)
        if before is None or name not in self.cars:
            return True
        turned = abs(math.remainder(pose.yaw - before.pose.yaw, math.tau))
        seconds = max(time - before.time, 0.0)
        if turned <= TURN + self.cars[name].fastest * seconds / TIGHTEST:
            return True
        self.turns[name] = turned
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


def is_same_frame(frame: MocapFrame, other: MocapFrame) -> bool:
    """Whether two frames are the same one: a source that begins again counts from 0."""
    return frame.number == other.number and frame.received == other.received


def finite(pose: Pose | None) -> TypeGuard[Pose]:
    """Whether it is a pose, and of finite numbers."""
    return pose is not None and all(map(math.isfinite, (pose.x, pose.y, pose.yaw)))
