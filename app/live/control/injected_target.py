"""The injected car: a target that the flock follows, on a path, by hand, or a tracked body."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from pydantic import Field, model_validator

from app.live.control.pose import Pose, Sighting, TrackingArea
from app.strict_table import StrictTable
from worlds.input_error import InputError

Point = tuple[float, float]
INJECTED = "injected"
"""Its name among the sightings, where it is a tracked body."""
TURNS = 0.01
"""Metres that the hand must move for the target to turn with it."""


class Injection(StrictTable):
    """How the injected car moves; the defaults are the circle of the source.

    An eight is two circles that touch in its centre, one above the other.
    """

    path: Literal["circle", "eight", "route", "hand", "body", "none"] = "circle"
    centre: tuple[float, float] = (0.0, 0.0)
    """Of the circle or the eight, or where the hand begins, m."""
    radius: float = Field(default=2.0, gt=0.0)
    """Of the circle, or of both of the eight, m."""
    speed: float = Field(default=1.1, ge=-10.0, le=10.0)
    """Along the path, m/s; on the circle anticlockwise, if positive."""
    route: tuple[Point, ...] = ()
    """The points of a route, which is gone round and round, m."""
    begins: float = Field(default=0.0, ge=-360.0, le=360.0)
    """Where on the circle it begins, degrees from the x axis."""
    body: str = ""
    """The tracked body that it is."""

    @model_validator(mode="after")
    def _goes_somewhere(self) -> Injection:
        if (self.path == "route") != bool(self.route):
            raise ValueError('a route and path = "route" need each other')
        if any(length == 0.0 for _, _, length in legs(self.route)):
            raise ValueError("a route needs two points or more, each apart from the next")
        return self

    def corners(self) -> list[Point]:
        """Points that its path lies within, m."""
        x, y = self.centre
        tall = {"circle": 1.0, "eight": 2.0}.get(self.path, 0.0) * self.radius
        wide = min(tall, self.radius)
        match self.path:
            case "circle" | "eight" | "hand":
                return [(x - wide, y - tall), (x + wide, y + tall)]
            case "route":
                return list(self.route)
        return []

    def pose_after(self, seconds: float) -> Pose:
        """Where it is after so many seconds on its circle, eight or route."""
        distance = self.speed * seconds
        if self.path == "route":
            x, y, yaw = route_pose(self.route, distance)
        else:
            turned = distance / self.radius
            if self.path == "circle":
                x, y, yaw = circle_pose(turned + math.radians(self.begins))
            else:
                x, y, yaw = eight_pose(turned)
            x, y = self.centre[0] + self.radius * x, self.centre[1] + self.radius * y
        backwards = math.pi if self.speed < 0.0 else 0.0
        return Pose(x, y, math.remainder(yaw + backwards, 2.0 * math.pi))


def circle_pose(turned: float) -> tuple[float, float, float]:
    """x, y and yaw on the unit circle."""
    return math.cos(turned), math.sin(turned), turned + 0.5 * math.pi


def eight_pose(turned: float) -> tuple[float, float, float]:
    """x, y and yaw on two unit circles: first the upper, to the left, then the lower."""
    turned %= 4.0 * math.pi
    side = 1.0 if turned < 2.0 * math.pi else -1.0
    return math.sin(turned), side * (1.0 - math.cos(turned)), side * turned


def route_pose(route: Sequence[Point], distance: float) -> tuple[float, float, float]:
    """x, y (m) and yaw after so many metres round a closed route."""
    distance %= sum(length for _, _, length in legs(route))
    for (x, y), (u, v), length in legs(route):
        if distance < length:
            share = distance / length
            return x + share * (u - x), y + share * (v - y), math.atan2(v - y, u - x)
        distance -= length
    return *route[0], math.atan2(route[1][1] - route[0][1], route[1][0] - route[0][0])


def legs(route: Sequence[Point]) -> list[tuple[Point, Point, float]]:
    """Start, end and length (m) of each leg of a closed route."""
    return [(a, b, math.dist(a, b)) for a, b in zip(route, [*route[1:], *route[:1]], strict=True)]


class InjectedTarget:
    """The injected car as it moves; it moves on its path only while the cars run."""

    def __init__(self, plan: Injection, area: TrackingArea):
        self.plan = plan
        self.area = area
        self.seconds = 0.0
        """How long it has moved, s."""
        self.before: float | None = None
        self.hand = Pose(*area.clamp(*plan.centre), 0.0)

    def place(self, x: float, y: float) -> None:
        """Move the hand, which is kept within the fence. Raises InputError for no finite number."""
        if not (math.isfinite(x) and math.isfinite(y)):
            raise InputError(f"the injected car cannot be at ({x}, {y})")
        x, y = self.area.clamp(x, y)
        dx, dy = x - self.hand.x, y - self.hand.y
        yaw = math.atan2(dy, dx) if math.hypot(dx, dy) >= TURNS else self.hand.yaw
        self.hand = Pose(x, y, yaw)

    def pose_at(self, now: float, running: bool, sightings: tuple[Sighting, ...]) -> Pose | None:
        """Where it is at `now` (s); None where there is none or its body is not seen."""
        if running and self.before is not None:
            self.seconds += now - self.before
        self.before = now
        match self.plan.path:
            case "circle" | "eight" | "route":
                return self.plan.pose_after(self.seconds)
            case "hand":
                return self.hand
            case "body":
                return next((s.pose for s in sightings if s.name == INJECTED), None)
        return None
