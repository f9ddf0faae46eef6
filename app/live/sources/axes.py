"""From the axes of a tracking system to the floor: which axis is up, the unit, the car's nose.

Nothing is guessed: a system that is set up with y up and declared with z up gives cars that drive
through the floor plan sideways, so it is declared and shown.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from app.live.control.pose import Pose
from worlds.refusal import unknown

UPS = ("z", "y")
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""Metres in one unit."""
NOSES = ("x", "-x", "y", "-y", "z", "-z")

UNIT_WITHIN = 0.01
"""How far the length of a quaternion may be from 1: more is no rotation."""
FLAT = 0.5
"""Least horizontal part of the nose: a car pitched by more than 60 degrees has no heading."""


@dataclass(frozen=True, slots=True)
class Axes:
    """How a tracking system is set up.

    Raises Refusal if there is no such axis or unit.
    """

    up: str = "z"
    """The axis of the room that points up. With y up, the floor is (x, -z), as Motive has it."""
    unit: str = "m"
    """Of positions: m, cm or mm."""
    nose: str = "x"
    """The axis of the body that points to the nose of the car."""

    def __post_init__(self) -> None:
        if self.up not in UPS:
            raise unknown("up axis", self.up, UPS)
        if self.unit not in UNITS:
            raise unknown("unit", self.unit, UNITS)
        if self.nose not in NOSES:
            raise unknown("nose axis", self.nose, NOSES)

    def __str__(self) -> str:
        return f"{self.up} up, {self.unit}" + ("" if self.nose == "x" else f", nose {self.nose}")

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
        a car on its nose.

        >>> Axes().pose((1.0, 2.0, 0.1), (0.0, 0.0, 0.0, 1.0))
        Pose(x=1.0, y=2.0, yaw=0.0)
        >>> Axes(up="y", unit="mm").pose((1000.0, 100.0, -2000.0), (0.0, 0.0, 0.0, 1.0))
        Pose(x=1.0, y=2.0, yaw=0.0)
        """
        x, y = self.floor(point)
        direction = turned(self.nose, quaternion)
        if direction is None or not (math.isfinite(x) and math.isfinite(y)):
            return None
        yaw = self.heading(direction)
        return None if yaw is None else Pose(x, y, yaw)


def turned(axis: str, quaternion: Iterable[float]) -> tuple[float, float, float] | None:
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
