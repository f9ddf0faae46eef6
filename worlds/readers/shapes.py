"""Shapes as a file draws them, checked before anything is made of them.

A shape is in the units of its file, so that a refusal names the place where the file has it. An
unsound shape is refused and never repaired.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import shapely

from worlds.counting import counted
from worlds.obstacles import Obstacle, obstacle
from worlds.refusal import Refusal

Point = tuple[float, float]
Span = tuple[float | None, float | None]
"""From which height to which a shape stands; None is the floor or the ceiling."""

FARTHEST = 1e12
"""Largest coordinate, in units of the file."""
DEFECTS = {
    "Self-intersection": "crosses itself",
    "Ring Self-intersection": "touches itself",
    "Hole lies outside shell": "has a hole that is not inside it",
    "Holes are nested": "has a hole inside another hole",
    "Nested shells": "has a part inside another part",
    "Interior is disconnected": "is cut in two by its holes",
    "Duplicate Rings": "has the same outline twice",
}
"""What shapely finds, in words that follow a name."""


@dataclass(frozen=True)
class Drawn:
    """What all shapes have: a name, where they stand in the file, and their span of heights."""

    name: str
    origin: str
    span: Span

    def made(self, scale: float, values: dict[str, Any]) -> Obstacle:
        """The obstacle with these values, in metres. Raises Refusal."""
        heights = {
            key: z * scale
            for key, z in zip(("bottom", "top"), self.span, strict=True)
            if z is not None
        }
        return obstacle({"name": self.name, **values, **heights}, self.origin)


@dataclass(frozen=True)
class Area(Drawn):
    """A polygon: `rings` are its outline and its holes, each without a repeated last point."""

    rings: tuple[tuple[Point, ...], ...]

    def obstacle(self, scale: float, thickness: float | None) -> Obstacle:  # noqa: ARG002
        """The solid, in metres. Raises Refusal."""
        points, *holes = (tuple(times(point, scale) for point in ring) for ring in self.rings)
        return self.made(scale, {"shape": "polygon", "points": points, "holes": tuple(holes)})


@dataclass(frozen=True)
class Circle(Drawn):
    """A disc, which stays exactly round."""

    centre: Point
    radius: float

    def obstacle(self, scale: float, thickness: float | None) -> Obstacle:  # noqa: ARG002
        """The solid, in metres. Raises Refusal."""
        centre = times(self.centre, scale)
        return self.made(scale, {"shape": "disc", "centre": centre, "radius": self.radius * scale})


@dataclass(frozen=True)
class Line(Drawn):
    """A line of two or more points, which is solid only with a thickness."""

    points: tuple[Point, ...]
    thickness: float | None
    """Its own, in units of the file; else the one that is asked for, in metres."""

    def obstacle(self, scale: float, thickness: float | None) -> Obstacle:
        """The wall along it, in metres; mitred at its corners, flat at its ends. Raises Refusal."""
        thick = thickness if self.thickness is None else self.thickness * scale
        if thick is None:
            raise Refusal(
                f"{self.origin}: an open line from {at(self.points[0])} to {at(self.points[-1])} "
                "bounds no area: close it, or give a thickness"
            )
        points = [times(point, scale) for point in self.points]
        if len(points) == 2:
            start, end = points
            return self.made(
                scale, {"shape": "wall", "start": start, "end": end, "thickness": thick}
            )
        drawn = shapely.LineString(points).buffer(
            thick / 2.0, cap_style="flat", join_style="mitre", mitre_limit=5.0
        )
        if not isinstance(drawn, shapely.Polygon) or drawn.is_empty:
            raise Refusal(f"{self.origin}: no wall {thick:g} m thick can be drawn along the line")
        outer, *holes = (
            tuple((x, y) for x, y in ring.coords[:-1])
            for ring in (drawn.exterior, *drawn.interiors)
        )
        return self.made(scale, {"shape": "polygon", "points": outer, "holes": tuple(holes)})


Shape = Area | Circle | Line


def area(
    name: str, rings: Sequence[Sequence[Point]], origin: str, span: Span = (None, None)
) -> Area:
    """A polygon of closed rings (first point = last point), checked. Raises Refusal."""
    for ring in rings:
        demand_finite(ring, origin)
        if not ring or tuple(ring[0]) != tuple(ring[-1]):
            ends = f"begins at {at(ring[0])} and ends at {at(ring[-1])}" if ring else "has no point"
            raise Refusal(f"{origin}: the outline is not closed: it {ends}")
        if len(set(map(tuple, ring))) < 3:
            points = counted(len(set(map(tuple, ring))), "point")
            raise Refusal(
                f"{origin}: the outline at {at(ring[0])} has {points}: at least 3 bound an area"
            )
        if shapely.MultiPoint(ring).convex_hull.area == 0.0:
            raise Refusal(f"{origin}: the outline at {at(ring[0])} has no area")
    made = shapely.Polygon(rings[0], rings[1:])
    demand_valid(made, origin)
    if made.area == 0.0:  # so thin that rounding leaves nothing
        raise Refusal(f"{origin}: the outline at {at(rings[0][0])} has no area")
    return Area(name, origin, span, tuple(tuple((x, y) for x, y in ring[:-1]) for ring in rings))


def circle(
    name: str, centre: Point, radius: float, origin: str, span: Span = (None, None)
) -> Circle:
    """A disc, checked. Raises Refusal."""
    demand_finite([centre], origin)
    if not (radius > 0.0 and math.isfinite(radius)):
        raise Refusal(f"{origin}: radius = {radius:g} at {at(centre)} is not a length > 0")
    return Circle(name, origin, span, centre, radius)


def line(
    name: str,
    points: Sequence[Point],
    origin: str,
    thickness: float | None = None,
    span: Span = (None, None),
) -> Line:
    """A line, checked. Raises Refusal."""
    demand_finite(points, origin)
    distinct = [p for k, p in enumerate(points) if k == 0 or p != points[k - 1]]
    if len(distinct) < 2:
        raise Refusal(f"{origin}: the line has no length")
    if thickness is not None and not (thickness > 0.0 and math.isfinite(thickness)):
        raise Refusal(f"{origin}: thickness = {thickness:g} is not a length > 0")
    return Line(name, origin, span, tuple(distinct), thickness)


def demand_finite(points: Sequence[Point], origin: str) -> None:
    """Refuse a coordinate that is NaN, infinite or beyond FARTHEST. Raises Refusal."""
    for k, point in enumerate(points, start=1):
        if not all(abs(one) <= FARTHEST for one in point):
            raise Refusal(f"{origin}: point {k} is {at(point)}, which is no place")


def demand_valid(made: shapely.Geometry, origin: str) -> None:
    """Refuse a polygon that crosses itself or is unsound otherwise. Raises Refusal."""
    reason = shapely.is_valid_reason(made)
    if reason == "Valid Geometry":
        return
    found = re.fullmatch(r"(.*?)\[(\S+) (\S+)\]", reason)
    what, place = (found[1], at((float(found[2]), float(found[3])))) if found else (reason, "")
    words = DEFECTS.get(what, f"is not sound ({what})")
    raise Refusal(f"{origin}: the outline {words}" + (f" at {place}" if place else ""))


def at(point: Sequence[float]) -> str:
    """A place as a message shows it.

    >>> at((1.5, -2.0))
    '(1.5, -2)'
    """
    return "(" + ", ".join(f"{one:.9g}" for one in point) + ")"


def times(point: Point, scale: float) -> Point:
    """A point in metres."""
    return (point[0] * scale, point[1] * scale)
