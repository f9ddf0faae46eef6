"""From the axes of a tracking system to the floor: which axis is up, the unit, the car's nose.

Nothing is guessed: a system that is set up with y up and declared with z up gives cars that drive
through the floor plan sideways, so it is declared and shown. What is declared is held against every
pose: a car whose top does not point up has no heading that can be trusted, and is not tracked.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from app.live.control.plausibility import UPRIGHT
from app.live.control.pose import Pose, Sighting, seen, unseen
from worlds.input_error import InputError, unknown

UPS = ("z", "y")
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Metres in one unit."""
NOSES = ("x", "-x", "y", "-y", "z", "-z")

UNIT_WITHIN = 0.01
"""How far the length of a quaternion may be from 1: more is no rotation."""
FLAT = 0.5
"""Least horizontal part of the nose: a car pitched by more than 60 degrees has no heading."""


@dataclass(frozen=True, slots=True)
class Axes:
    """How a tracking system is set up.

    Raises InputError if there is no such axis or unit.
    """

    up: str = "z"
    """The axis of the room that points up. With y up, the floor is (x, -z), as Motive has it."""
    unit: str = "m"
    """Of positions: one of UNITS."""
    nose: str = "x"
    """The axis of the body that points to the nose of the car."""
    top: str = ""
    """The axis of the body that points up; empty: the one called as that of the room."""

    def __post_init__(self) -> None:
        if self.up not in UPS:
            raise unknown("up axis", self.up, UPS)
        if self.unit not in UNITS:
            raise unknown("unit", self.unit, UNITS)
        if self.nose not in NOSES:
            raise unknown("nose axis", self.nose, NOSES)
        if self.top and self.top not in NOSES:
            raise unknown("top axis", self.top, NOSES)
        if self.top and self.top[-1] == self.nose[-1]:
            raise InputError(f"top = {self.top} lies along the nose, {self.nose}")

    def __str__(self) -> str:
        nose = "" if self.nose == "x" else f", nose {self.nose}"
        return f"{self.up} up, {self.unit}{nose}" + (f", top {self.top}" if self.top else "")

    @property
    def body_top(self) -> str:
        """The axis of the body that points up; empty where the nose lies along that of the room."""
        return self.top or ("" if self.nose[-1] == self.up else self.up)

    def floor(self, point: Iterable[float]) -> tuple[float, float]:
        """A point (x, y, z) of the room in metres on the floor."""
        x, y, z = (float(part) for part in point)
        scale = UNITS[self.unit]
        return (scale * x, scale * y) if self.up == "z" else (scale * x, 0.0 - scale * z)

    def heading(self, direction: Iterable[float]) -> float | None:
        """Yaw in radians of a direction (x, y, z) of length 1 of the room; None if too steep."""
        x, y, z = (float(part) for part in direction)
        along, across = (x, y) if self.up == "z" else (x, -z)
        if not math.hypot(along, across) >= FLAT:
            return None
        return math.atan2(across + 0.0, along)  # + 0.0: a zero below 0 would be -pi, not pi

    def pose(self, point: Iterable[float], quaternion: Iterable[float]) -> Pose | None:
        """Where a body at `point` (x, y, z) turned by `quaternion` (x, y, z, w) is on the floor.

        None where it cannot be said: a number that is none, a quaternion that is no rotation, or
        a car on its nose, its side or its roof.

        >>> Axes().pose((1.0, 2.0, 0.1), (0.0, 0.0, 0.0, 1.0))
        Pose(x=1.0, y=2.0, yaw=0.0)
        >>> Axes(up="y", unit="mm").pose((1000.0, 100.0, -2000.0), (0.0, 0.0, 0.0, 1.0))
        Pose(x=1.0, y=2.0, yaw=0.0)
        """
        return self.sighting("", point, quaternion).pose

    def sighting(self, name: str, point: Iterable[float], quaternion: Iterable[float]) -> Sighting:
        """A body at `point` turned by `quaternion`; as `pose`, with what is wrong with it.

        >>> Axes().sighting("red", (1.0, 2.0, 0.1), (1.0, 0.0, 0.0, 0.0)).why
        'its axis z, which should point up, is rolled 180 degrees about its nose'
        """
        quaternion = tuple(quaternion)
        nose = rotate_axis(self.nose, quaternion)
        if nose is None:
            return unseen(name, "its quaternion is no rotation")
        top = rotate_axis(self.body_top, quaternion) if self.body_top else None
        return self.sighting_from_directions(name, point, nose, top)

    def sighting_from_directions(
        self,
        name: str,
        point: Iterable[float],
        nose: Iterable[float],
        top: Iterable[float] | None,
    ) -> Sighting:
        """A body at `point`, from the directions (x, y, z) of its nose and its top in the room.

        Without a top, whether it is upright is not looked at.
        """
        x, y = self.floor(point)
        if not (math.isfinite(x) and math.isfinite(y)):
            return unseen(name, "its position is no finite number")
        nose = tuple(nose)
        yaw = self.heading(nose)
        if yaw is None:
            return unseen(name, f"its nose, the axis {self.nose}, points up or down")
        if top is not None:
            up = "xyz".index(self.up)
            roll = roll_degrees(nose[up], tuple(top)[up])
            if not roll <= UPRIGHT:
                words = f"its axis {self.body_top}, which should point up, is rolled {roll:.0f}"
                return unseen(name, f"{words} degrees about its nose")
        return seen(name, Pose(x, y, yaw))

    def up_in_body(self, quaternion: Iterable[float]) -> tuple[float, float, float] | None:
        """The room's up, in the axes of a body; None if the quaternion is no rotation.

        It stays the same while a car drives on a floor, however its rigid body was defined.
        """
        quaternion = tuple(quaternion)
        columns = [rotate_axis(axis, quaternion) for axis in "xyz"]
        up = "xyz".index(self.up)
        first, second, third = (None if column is None else column[up] for column in columns)
        if first is None or second is None or third is None:
            return None
        return first, second, third


def roll_degrees(nose: float, top: float) -> float:
    """How far a body is rolled about its nose, in [0, 180], from how far its nose and its top rise.

    Both are upward components of directions of length 1. Pitch is not in it.

    >>> [round(roll_degrees(nose, top)) for nose, top in ((0.0, 1.0), (0.6, 0.8), (0.0, -1.0))]
    [0, 0, 180]
    """
    return math.degrees(math.atan2(math.sqrt(max(1.0 - nose * nose - top * top, 0.0)), top))


def rotate_axis(axis: str, quaternion: Iterable[float]) -> tuple[float, float, float] | None:
    """Where a quaternion (x, y, z, w) turns an axis of the body; None if it is no rotation."""
    x, y, z, w = (float(part) for part in quaternion)
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(length - 1.0) <= UNIT_WITHIN:
        return None
    x, y, z, w = x / length, y / length, z / length, w / length
    match axis.removeprefix("-"):
        case "x":
            a, b, c = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)
        case "y":
            a, b, c = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
        case _:
            a, b, c = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    return (-a, -b, -c) if axis.startswith("-") else (a, b, c)
