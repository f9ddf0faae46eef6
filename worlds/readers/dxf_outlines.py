"""Closed outlines of DXF entities: bulges become chords, rings of a hatch get their holes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import shapely

from worlds.readers.drawn_shapes import Point

STEP = 2.0 * math.pi / 128
"""Longest turn of a chord, rad, as the curves of obstacles have it: it leaves its arc by at most
0.0003 of the radius."""
MOST_OUTLINES = 2000
"""Walkable areas of a file, and outlines of a hatch, at most: each is held against each."""
STRAIGHT = 1e-9
"""Bulges up to this are none: the arc leaves its chord by less than a billionth of its length."""


def along(vertices: Sequence[tuple[float, float, float]], closed: bool) -> list[Point]:
    """The points of a polyline of (x, y, bulge), its arcs drawn by chords of at most STEP.

    A bulge is the tangent of a quarter of the angle of the arc to the next vertex, positive when it
    turns left. The first point is repeated at the end if the polyline is closed.
    """
    made: list[Point] = []
    count = len(vertices)
    for k, (x, y, bulge) in enumerate(vertices):
        made.append((x, y))
        if abs(bulge) > STRAIGHT and (closed or k < count - 1):
            x1, y1, _ = vertices[(k + 1) % count]
            made += arc((x, y), (x1, y1), bulge)
    if closed and made and made[0] != made[-1]:
        made.append(made[0])
    return made


def arc(start: Point, end: Point, bulge: float) -> list[Point]:
    """The points between the ends of an arc, on it."""
    angle = 4.0 * math.atan(bulge)
    chord_x, chord_y = end[0] - start[0], end[1] - start[1]
    if not math.isfinite(angle) or (chord_x == 0.0 and chord_y == 0.0):
        return []
    ahead = (1.0 - bulge * bulge) / (4.0 * bulge)
    centre_x = 0.5 * (start[0] + end[0]) - ahead * chord_y
    centre_y = 0.5 * (start[1] + end[1]) + ahead * chord_x
    dx, dy = start[0] - centre_x, start[1] - centre_y
    pieces = math.ceil(abs(angle) / STEP)
    turns = [angle * k / pieces for k in range(1, pieces)]
    return [
        (
            centre_x + dx * math.cos(turn) - dy * math.sin(turn),
            centre_y + dx * math.sin(turn) + dy * math.cos(turn),
        )
        for turn in turns
    ]


def nested(rings: Sequence[list[Point]]) -> list[list[list[Point]]]:
    """Rings by the even-odd rule: each outline with the holes that lie directly in it."""
    areas = [shapely.Polygon(ring) for ring in rings]
    around: list[set[int]] = [set() for _ in areas]
    for inner, outer in within(areas):
        around[inner].add(outer)
    found = []
    for k, beyond in enumerate(around):
        if len(beyond) % 2 == 0:
            holes = [j for j, o in enumerate(around) if k in o and len(o) == len(beyond) + 1]
            found.append([rings[k], *(rings[j] for j in holes)])
    return found


def within(areas: Sequence[shapely.Geometry]) -> list[tuple[int, int]]:
    """Pairs of areas of which the first lies in the second, a larger one, by their indices."""
    inner, outer = shapely.STRtree(areas).query(areas, predicate="covered_by")
    size = shapely.area(areas)
    smaller = size[inner] < size[outer]
    return list(zip(inner[smaller].tolist(), outer[smaller].tolist(), strict=True))
