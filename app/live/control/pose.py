"""Tracked poses in the plane, frame by frame, as every source gives them.

Every source gives the same: metres and radians on the floor, z up. What is not tracked has no pose;
nothing is filled in, held or predicted.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from pydantic import Field, model_validator

from app.strict_table import StrictTable
from worlds.input_error import InputError


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


# The capture area: a rectangle on the floor, with a fence some way inside it.


class TrackingArea(StrictTable):
    """Where the cars are tracked, metres in the frame of the tracking."""

    low: tuple[float, float]
    high: tuple[float, float]
    fence: float = Field(default=0.5, ge=0.0)
    """How far inside the area the cars are stopped, m."""

    @model_validator(mode="after")
    def _reaches_beyond_its_fence(self) -> TrackingArea:
        for axis in range(2):
            if self.high[axis] - self.low[axis] <= 2.0 * self.fence:
                raise ValueError(
                    f"there is no room within a fence of {self.fence:g} m between "
                    f"{'xy'[axis]} = {self.low[axis]:g} and {self.high[axis]:g}"
                )
        return self

    def distance_inside(self, x: float, y: float) -> float:
        """How far (m) a point is inside the fence; negative beyond it.

        >>> TrackingArea(low=(-2, -2), high=(2, 2)).distance_inside(1.25, 0)
        0.25
        """
        return min(
            x - self.low[0] - self.fence,
            self.high[0] - self.fence - x,
            y - self.low[1] - self.fence,
            self.high[1] - self.fence - y,
        )

    def clamp(self, x: float, y: float) -> tuple[float, float]:
        """The nearest point on or within the fence."""
        low = [edge + self.fence for edge in self.low]
        high = [edge - self.fence for edge in self.high]
        return min(max(x, low[0]), high[0]), min(max(y, low[1]), high[1])


# What drives the cars: the contract between the control loop and a rule.


class NoFreeSpace(InputError):
    """No free space for the simulated cars; raised once for each time that they are asked for."""


@dataclass(frozen=True, slots=True)
class Companion:
    """A simulated car in the world of the real ones."""

    name: str
    """`sim 1`, `sim 2`, ..."""
    pose: Pose
    steer: float
    """Angle of its front wheels as a share of full lock, in [-1, 1]; left is positive."""


class Driver(Protocol):
    """Computes commands from the poses; called once a tick, by one thread.

    What it answers may depend on nothing but what it was made of and what it has been called with,
    in order: no clock, no chance without a seed. Then a recording replays to the bit. It must be
    done within a few milliseconds.
    """

    def drive(
        self, now: float, sightings: tuple[Sighting, ...], injected: Pose | None, running: bool
    ) -> Mapping[str, tuple[float, float]]:
        """(steer, throttle) in [-1, 1] by car: left and forwards are positive.

        `now` is in seconds on the loop's clock. `sightings` has the cars, by the laboratory's
        names, that were seen within the limit `stale`, each where it was last seen; a car without
        a command gets no throttle. `injected` is the injected car, None where there is none.
        `running` says whether the cars were told to run in the last tick. Whatever it raises stops
        the cars; after NoFreeSpace they go on with the next tick, without new simulated cars.
        """
        ...


@runtime_checkable
class TunableDriver(Protocol):
    """A driver with parameters that can be changed while it drives."""

    def tune(self, values: Mapping[str, Any]) -> None:
        """Change parameters by name. Raises InputError, and then changes nothing."""
        ...


@runtime_checkable
class CompanionDriver(Protocol):
    """A driver with simulated cars beside the real ones, which drive while those run."""

    @property
    def companions(self) -> tuple[Companion, ...]:
        """The simulated cars as they are after the last tick."""
        ...

    def accompany(self, count: int) -> None:
        """Have so many simulated cars from now on: new ones begin where there is room, the last
        ones leave first. Raises InputError, and then changes nothing."""
        ...
