"""Tracked poses in the plane, frame by frame, as every source gives them.

Every source gives the same: metres and radians on the floor, z up. What is not tracked has no pose;
nothing is filled in, held or predicted.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Pose:
    """A body on the floor."""

    x: float
    """Metres."""
    y: float
    """Metres."""
    yaw: float
    """Radians from the x axis to the nose, anticlockwise seen from above, in (-pi, pi]."""


@dataclass(frozen=True, slots=True)
class Sighting:
    """One body in one frame."""

    name: str
    pose: Pose | None
    """None where the body is not tracked."""
    valid: bool
    """Whether the body is tracked; only then is there a pose to steer by."""
    why: str = field(default="", compare=False)
    """Why it is not tracked, in words, where the source can tell."""


@dataclass(frozen=True, slots=True)
class MocapFrame:
    """One frame of motion capture: all bodies at one time.

    >>> frame = MocapFrame(7, 100.0, (seen("car1", Pose(1.0, 2.0, 0.0)), unseen("car2")))
    >>> frame.pose("car1"), frame.pose("car2"), frame.pose("car3"), frame.age(100.25)
    (Pose(x=1.0, y=2.0, yaw=0.0), None, None, 0.25)
    """

    number: int
    """Rises from frame to frame; where the source numbers its frames, a leap is frames lost."""
    received: float
    """`time.monotonic()` in seconds when it arrived on this machine; all processes share it."""
    sightings: tuple[Sighting, ...]
    """A body that is missing is not tracked, as one that is not valid."""
    sent: float | None = None
    """Seconds by the source's own clock, where it tells."""

    def age(self, now: float) -> float:
        """Seconds from its arrival until `now`, a reading of `time.monotonic()`."""
        return now - self.received

    def pose(self, name: str) -> Pose | None:
        """Where the body is; None if it is not tracked in this frame."""
        for sighting in self.sightings:
            if sighting.name == name:
                return sighting.pose if sighting.valid else None
        return None


def seen(name: str, pose: Pose) -> Sighting:
    """A body that is tracked."""
    return Sighting(name, pose, True)


def unseen(name: str, why: str = "") -> Sighting:
    """A body that is not tracked, and why, where that is known."""
    return Sighting(name, None, False, why)
