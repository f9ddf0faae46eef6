"""Shapes as a file draws them, checked before anything is made of them.

A shape is in the units of its file, so that a refusal names the place where the file has it. An
unsound shape is refused and never repaired.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import shapely

from worlds.input_error import InputError
from worlds.number_text import counted
from worlds.obstacles import Obstacle, obstacle

Point = tuple[float, float]
Bounds = tuple[float, float, float, float]
"""Least x and y, largest x and y."""
Span = tuple[float | None, float | None]
"""From which height to which a shape stands; None is the floor or the ceiling."""

ROUNDING = 1e-6
"""Ends of an outline that are nearer than this, as a share of its extent, are one place: drawing
programs compute the ends of arcs and turned lines, and round."""
FARTHEST = 1e12
"""Largest coordinate, in units of the file."""
MOST_TOUCHING = 200
"""Holes of an outline that may touch it or each other at most: each is held against each."""
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
class DrawnShape:
    """What all shapes have: a name, where they stand in the file, and their span of heights."""

    name: str
    origin: str
    span: Span

    def build_obstacle(self, values: dict[str, Any]) -> Obstacle:
        """The obstacle with these values, in metres. Raises InputError."""
        heights = {
            key: z for key, z in zip(("bottom", "top"), self.span, strict=True) if z is not None
        }
        return obstacle({"name": self.name, **values, **heights}, self.origin)


@dataclass(frozen=True)
class UnitConversion:
    """How lengths of the file become metres: times `scale`, rounded to `digits` decimals."""

    scale: float
    digits: int

    def length(self, value: float) -> float:
        """A length in metres."""
        return round(value * self.scale, self.digits)

    def point(self, place: Point) -> Point:
        """A point in metres."""
        return (self.length(place[0]), self.length(place[1]))

    def span(self, heights: Span) -> Span:
        """Heights in metres."""
        low, high = (None if z is None else self.length(z) for z in heights)
        return (low, high)


@dataclass(frozen=True)
class DrawnArea(DrawnShape):
    """A polygon: `rings` are its outline and its holes, each without a repeated last point."""

    rings: tuple[tuple[Point, ...], ...]
    is_line: bool = False
    """Whether it is drawn as a line that closes, which may be meant as a wall."""

    def corners(self) -> Sequence[Point]:
        """All its points."""
        return [point for ring in self.rings for point in ring]

    def bounds(self) -> Bounds:
        """Its lower and upper corner."""
        return bounds_of(self.rings[0])

    def measured(self, by: UnitConversion) -> DrawnArea:
        """The same in metres. Raises InputError if rounding has left nothing of it."""
        rings = [[by.point(point) for point in ring] for ring in self.rings]
        closed = [[*ring, ring[0]] for ring in rings]
        return area(self.name, closed, self.origin, by.span(self.span), self.is_line)

    def map_points(self, to: Callable[[Point], Point]) -> DrawnArea:
        """The same with every point somewhere else."""
        return replace(self, rings=tuple(tuple(map(to, ring)) for ring in self.rings))

    def walls(self) -> list[Solid]:
        """Its outline and those of its holes, as closed lines."""
        return [
            line(self.name, [*ring, ring[0]], self.origin, None, self.span) for ring in self.rings
        ]

    def obstacle(self, thickness: float | None, digits: int) -> Obstacle:  # noqa: ARG002
        """The solid. Raises InputError."""
        points, *holes = self.rings
        return self.build_obstacle({"shape": "polygon", "points": points, "holes": tuple(holes)})


@dataclass(frozen=True)
class DrawnCircle(DrawnShape):
    """A disc, which stays exactly round."""

    centre: Point
    radius: float
    is_line: bool = False
    """Whether it is drawn as a line, which may be meant as a wall."""
    is_wall: bool = False
    """Whether only its rim is solid, with a thickness."""

    def corners(self) -> Sequence[Point]:
        """The corners of its bounds."""
        (x, y), r = self.centre, self.radius
        return [(x - r, y - r), (x + r, y + r)]

    def bounds(self) -> Bounds:
        """Its lower and upper corner."""
        return bounds_of(self.corners())

    def measured(self, by: UnitConversion) -> DrawnCircle:
        """The same in metres. Raises InputError if rounding has left nothing of it."""
        centre, radius = by.point(self.centre), by.length(self.radius)
        drawn_circle = circle(
            self.name, centre, radius, self.origin, by.span(self.span), self.is_line
        )
        return replace(drawn_circle, is_wall=self.is_wall)

    def map_points(self, to: Callable[[Point], Point]) -> DrawnCircle:
        """The same somewhere else."""
        return replace(self, centre=to(self.centre))

    def walls(self) -> list[Solid]:
        """Its rim."""
        return [replace(self, is_wall=True)]

    def obstacle(self, thickness: float | None, digits: int) -> Obstacle:
        """The solid. Raises InputError."""
        if not self.is_wall or thickness is None:
            return self.build_obstacle(
                {"shape": "disc", "centre": self.centre, "radius": self.radius}
            )
        outer = round(self.radius + thickness / 2.0, digits)
        if thickness >= outer:  # it reaches its own middle
            return self.build_obstacle({"shape": "disc", "centre": self.centre, "radius": outer})
        ring = {"shape": "ring", "centre": self.centre, "radius": outer, "width": thickness}
        return self.build_obstacle(ring)


@dataclass(frozen=True)
class DrawnLine(DrawnShape):
    """A line of two or more points, which is solid only with a thickness."""

    points: tuple[Point, ...]
    thickness: float | None
    """Its own; else the one that is asked for."""

    def corners(self) -> Sequence[Point]:
        """All its points."""
        return self.points

    def bounds(self) -> Bounds:
        """Its lower and upper corner."""
        return bounds_of(self.points)

    def measured(self, by: UnitConversion) -> DrawnLine:
        """The same in metres. Raises InputError if rounding has left nothing of it."""
        thick = None if self.thickness is None else by.length(self.thickness)
        points = [by.point(point) for point in self.points]
        return line(self.name, points, self.origin, thick, by.span(self.span))

    def map_points(self, to: Callable[[Point], Point]) -> DrawnLine:
        """The same with every point somewhere else."""
        return replace(self, points=tuple(map(to, self.points)))

    def walls(self) -> list[Solid]:
        """Itself."""
        return [self]

    def obstacle(self, thickness: float | None, digits: int) -> Obstacle:
        """The wall along it, mitred at its corners, flat at its ends. Raises InputError."""
        thick = thickness if self.thickness is None else self.thickness
        if thick is None:
            raise InputError(f"{self.origin}: {self.describe_gap()}: close it, give a thickness, "
                          "join lines whose ends meet (--join), or --drop-lines")  # fmt: skip
        if len(self.points) == 2:
            start, end = self.points
            return self.build_obstacle(
                {"shape": "wall", "start": start, "end": end, "thickness": thick}
            )
        drawn = shapely.LineString(self.points).buffer(
            thick / 2.0, cap_style="flat", join_style="mitre", mitre_limit=5.0
        )
        if not isinstance(drawn, shapely.Polygon) or drawn.is_empty:
            raise InputError(
                f"{self.origin}: no wall {thick:g} m thick can be drawn along the line"
            )
        outer, *holes = (
            tuple((round(x, digits), round(y, digits)) for x, y in ring.coords[:-1])
            for ring in (drawn.exterior, *drawn.interiors)
        )
        try:
            demand_valid(shapely.Polygon(outer, holes), self.origin)
        except InputError as refusal:
            raise InputError(
                f"{refusal}, as a wall {thick:g} m thick: give another --thickness, or "
                "--ignore its layer"
            ) from None
        return self.build_obstacle({"shape": "polygon", "points": outer, "holes": tuple(holes)})

    def describe_gap(self) -> str:
        """That it is open, and from where to where."""
        begin, end = format_place(self.points[0]), format_place(self.points[-1])
        return f"an open line from {begin} to {end} bounds no area"


@dataclass(frozen=True)
class DrawnPoint(DrawnShape):
    """A point, which is no obstacle, but may be a goal; `need` says what it lacks."""

    place: Point
    need: str

    def corners(self) -> Sequence[Point]:
        """Itself."""
        return [self.place]

    def bounds(self) -> Bounds:
        """Itself, twice."""
        return bounds_of([self.place])

    def measured(self, by: UnitConversion) -> DrawnPoint:
        """The same in metres."""
        return DrawnPoint(
            self.name, self.origin, by.span(self.span), by.point(self.place), self.need
        )

    def map_points(self, to: Callable[[Point], Point]) -> DrawnPoint:
        """The same somewhere else."""
        return replace(self, place=to(self.place))

    def walls(self) -> list[Solid]:
        """Itself."""
        return [self]

    def obstacle(self, thickness: float | None, digits: int) -> Obstacle:  # noqa: ARG002
        """Nothing. Raises InputError."""
        raise InputError(f"{self.origin}: {self.need}")


@dataclass(frozen=True)
class DrawnCurve(DrawnShape):
    """A curve that no chords draw exactly; `drawn` gives its points, within a tolerance."""

    drawn: Callable[[float], Iterator[Point]]


@dataclass(frozen=True)
class StrayPoint(DrawnShape):
    """Something all of whose points are one: it bounds nothing, and is left out with a word."""

    place: Point


Solid = DrawnArea | DrawnCircle | DrawnLine | DrawnPoint
Shape = Solid | DrawnCurve | StrayPoint


def area(
    name: str,
    rings: Sequence[Sequence[Point]],
    origin: str,
    span: Span = (None, None),
    is_line: bool = False,
) -> DrawnArea:
    """A polygon of closed rings (first point = last point), checked. Raises InputError.

    Ends that differ by rounding are one place, and a corner that is repeated counts once. A hole
    may touch the outline, or another hole, as long as one area is left.
    """
    closed = [close_ring(ring, origin) for ring in rings]
    polygon = shapely.Polygon(closed[0], closed[1:])
    if not polygon.is_valid:
        polygon = subtract_holes(closed, origin)
        closed = [list(ring.coords) for ring in (polygon.exterior, *polygon.interiors)]
    if polygon.area == 0.0:  # so thin that rounding leaves nothing
        raise InputError(f"{origin}: the outline at {format_place(closed[0][0])} has no area")
    corners = tuple(tuple((x, y) for x, y in ring[:-1]) for ring in closed)
    return DrawnArea(name, origin, span, corners, is_line)


def close_ring(ring: Sequence[Point], origin: str) -> list[Point]:
    """A ring whose last point is its first, without repeated corners. Raises InputError."""
    demand_finite(ring, origin)
    if not ring:
        raise InputError(f"{origin}: the outline is not closed: it has no point")
    first, last = ring[0], ring[-1]
    low_x, low_y, high_x, high_y = bounds_of(ring)
    if math.dist(first, last) > ROUNDING * math.hypot(high_x - low_x, high_y - low_y):
        begin, end = format_apart(first, last)
        raise InputError(
            f"{origin}: the outline is not closed: it begins at {begin} and ends at {end}, "
            f"{math.dist(first, last):.3g} apart: close it there, or --ignore its layer"
        )
    points = [(x, y) for x, y in (*ring[:-1], first)]
    points = [p for k, p in enumerate(points) if k == 0 or p != points[k - 1]]
    if len(set(points)) < 3:
        count = counted(len(set(points)), "point")
        raise InputError(
            f"{origin}: the outline at {format_place(first)} has {count}: at least 3 bound an area"
        )
    if shapely.MultiPoint(points).convex_hull.area == 0.0:
        raise InputError(f"{origin}: the outline at {format_place(first)} has no area")
    return points


def subtract_holes(rings: Sequence[Sequence[Point]], origin: str) -> shapely.Polygon:
    """What holes leave of an outline that they touch along a line. Raises InputError."""
    outline, *holes = (shapely.Polygon(ring) for ring in rings)
    for polygon in (outline, *holes):
        demand_valid(polygon, origin)
    inside = [hole for hole in holes if hole.covered_by(outline)]
    if len(inside) < len(holes):
        hole = next(hole for hole in holes if not hole.covered_by(outline))
        beyond = hole.difference(outline).representative_point()
        if hole.disjoint(outline):
            demand_valid(shapely.Polygon(rings[0], rings[1:]), origin)
        raise InputError(
            f"{origin}: the outline has a hole that crosses it: at "
            f"{format_place((beyond.x, beyond.y))} the hole is outside of the outline"
        )
    for polygon, other in itertools.combinations(holes[:MOST_TOUCHING], 2):
        both = polygon.intersection(other)
        if both.area > 0.0:
            place = both.representative_point()
            raise InputError(f"{origin}: the outline has two holes that overlap at "
                          f"{format_place((place.x, place.y))}: draw them as one")  # fmt: skip
    left = outline.difference(shapely.union_all(holes))
    parts = len(shapely.get_parts(left))
    if parts != 1:
        raise InputError(f"{origin}: the outline is cut into {parts} by its holes: draw each part")
    if len(holes) > MOST_TOUCHING or not left.is_valid:
        demand_valid(shapely.Polygon(rings[0], rings[1:]), origin)
    return left


def circle(
    name: str,
    centre: Point,
    radius: float,
    origin: str,
    span: Span = (None, None),
    is_line: bool = False,
) -> DrawnCircle:
    """A disc, checked. Raises InputError."""
    demand_finite([centre], origin)
    if not (radius > 0.0 and math.isfinite(radius)):
        raise InputError(
            f"{origin}: radius = {radius:g} at {format_place(centre)} is not a length > 0"
        )
    return DrawnCircle(name, origin, span, centre, radius, is_line)


def line(
    name: str,
    points: Sequence[Point],
    origin: str,
    thickness: float | None = None,
    span: Span = (None, None),
) -> DrawnLine:
    """A line, checked. Raises InputError."""
    demand_finite(points, origin)
    distinct = [p for k, p in enumerate(points) if k == 0 or p != points[k - 1]]
    if len(distinct) < 2:
        raise InputError(f"{origin}: the line has no length")
    if thickness is not None and not (thickness > 0.0 and math.isfinite(thickness)):
        raise InputError(f"{origin}: thickness = {thickness:g} is not a length > 0")
    return DrawnLine(name, origin, span, tuple(distinct), thickness)


def demand_finite(points: Sequence[Point], origin: str) -> None:
    """Refuse a coordinate that is NaN, infinite or beyond FARTHEST. Raises InputError."""
    for k, point in enumerate(points, start=1):
        if not all(abs(number) <= FARTHEST for number in point):
            raise InputError(f"{origin}: point {k} is {format_place(point)}, which is no place")


def demand_valid(geometry: shapely.Geometry, origin: str) -> None:
    """Refuse a polygon that crosses itself or is unsound otherwise. Raises InputError."""
    reason = shapely.is_valid_reason(geometry)
    if reason == "Valid Geometry":
        return
    match = re.fullmatch(r"(.*?)\[(\S+) (\S+)\]", reason)
    what, place = (
        (match[1], format_place((float(match[2]), float(match[3])))) if match else (reason, "")
    )
    words = DEFECTS.get(what, f"is not sound ({what})")
    raise InputError(f"{origin}: the outline {words}" + (f" at {place}" if place else ""))


def format_place(point: Sequence[float]) -> str:
    """A place as a message shows it.

    >>> format_place((1.5, -2.0))
    '(1.5, -2)'
    """
    return "(" + ", ".join(f"{number:.9g}" for number in point) + ")"


def format_apart(first: Point, other: Point) -> tuple[str, str]:
    """Two places, with as many digits as it takes to tell them apart."""
    for digits in range(9, 17):
        ends = [[f"{x:.{digits}g}" for x in point] for point in (first, other)]
        gap = math.dist(*([float(x) for x in end] for end in ends))
        if math.isclose(gap, math.dist(first, other), rel_tol=0.01):
            break
    begin, end = (f"({', '.join(point)})" for point in ends)
    return begin, end


def bounds_of(points: Sequence[Point]) -> Bounds:
    """The bounds of one point or more."""
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return (min(xs), min(ys), max(xs), max(ys))
