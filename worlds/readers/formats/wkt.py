"""WKT: a geometry a line, `name: POLYGON ((...))`; a line that begins with # is a comment.

The name is the layer and the name of the obstacle; without one the layer is `unnamed`. A geometry
may go on over several lines, until its last parenthesis is closed. A collection of five collections
is what JuPedSim's dxf2wkt writes: walkable area, exits, distributions, waypoints and journeys.

Source: OGC 06-103r4, section 7 (well-known text), read by GEOS; JuPedSim, scripts/dxf2wkt.py.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import partial
from itertools import accumulate, islice
from pathlib import Path

import numpy as np
import shapely

from worlds.input_error import InputError
from worlds.readers.drawing_contents import (
    DEEPEST,
    MOST_CORNERS,
    MOST_ITEMS,
    UNNAMED,
    DrawingContents,
    Item,
    layers_of,
    text_of,
)
from worlds.readers.drawn_shapes import (
    ROUNDING,
    DrawnPoint,
    Point,
    Shape,
    area,
    demand_finite,
    demand_valid,
    format_place,
    line,
)

RING = re.compile(r"\(([^()]*)\)")
LINE = re.compile(r"LINESTRING\s*\([^()]*\)", re.IGNORECASE)
JUPEDSIM = ("jps-walkablearea", "jps-exits", "jps-distributions", "jps-waypoints", "jps-journeys")
"""The layers of the five collections that dxf2wkt writes, in its order."""


def read_wkt(path: Path) -> DrawingContents:
    """The geometries of a WKT file. Raises InputError."""
    items: list[Item] = []
    geometries = list(islice(whole_geometries(text_of(path)), MOST_ITEMS + 1))
    if len(geometries) > MOST_ITEMS:
        raise InputError(f"{path} holds more than {MOST_ITEMS} geometries, too many to read")
    for number, text in geometries:
        head, colon, body = text.partition(":")
        has_name = bool(colon) and "(" not in head and ")" not in head
        name, wkt = (head.strip(), body.strip()) if has_name else ("", text.strip())
        if has_name and not wkt:
            raise InputError(f"{path}, line {number}: a name, but no geometry")
        origin = f"{path}, line {number}" + (f" {name!r}" if name else "")
        items += items_of(wkt, name, origin)
    return DrawingContents(path, tuple(items), layers_of(items), None)


def whole_geometries(text: str) -> Iterator[tuple[int, str]]:
    """Each geometry with the number of its first line; comments and empty lines are left out."""
    begun, pieces, depth = 0, list[str](), 0
    for number, text_line in enumerate(text.splitlines(), start=1):
        if not text_line.strip() or (text_line.lstrip().startswith("#") and not pieces):
            continue
        begun = begun if pieces else number
        pieces.append(text_line)
        depth += text_line.count("(") - text_line.count(")")
        if depth <= 0:
            yield begun, " ".join(pieces)
            pieces, depth = [], 0
    if pieces:
        yield begun, " ".join(pieces)


def items_of(text: str, name: str, origin: str) -> list[Item]:
    """The items of one geometry: one, or those of JuPedSim's collections."""
    try:
        shapely_geometry = geometry(text, origin)
    except InputError as refusal:
        return [Item(name or UNNAMED, kind_of(text), partial(refused, str(refusal)))]
    members = list(shapely.get_parts(shapely_geometry))
    if (
        not name
        and shapely_geometry.geom_type == "GeometryCollection"
        and len(members) == len(JUPEDSIM)
        and all(member.geom_type == "GeometryCollection" for member in members)
    ):
        return [
            Item(layer, part.geom_type.upper(), partial(shapes, part, "", origin))
            for layer, collection in zip(JUPEDSIM, members, strict=True)
            for part in shapely.get_parts(collection)
        ]
    return [
        Item(
            name or UNNAMED,
            shapely_geometry.geom_type.upper(),
            partial(shapes, shapely_geometry, name, origin),
        )
    ]


def refused(reason: str) -> list[Shape]:
    """Nothing. Raises InputError."""
    raise InputError(reason)


def kind_of(text: str) -> str:
    """The kind that a text claims to be."""
    match = re.match(r"[A-Za-z]+", text)
    return match[0].upper() if match else "geometry"


def geometry(text: str, origin: str) -> shapely.Geometry:
    """The geometry of a text. Raises InputError."""
    steps = ({"(": 1, ")": -1}.get(letter, 0) for letter in text)
    if max(accumulate(steps), default=0) > DEEPEST:
        raise InputError(f"{origin}: it is nested too deep")
    try:
        with np.errstate(invalid="ignore", over="ignore"):  # NaN and inf are refused below
            return shapely.from_wkt(text)
    except (shapely.errors.GEOSException, NotImplementedError) as error:
        if "closed" in str(error):
            repaired = RING.sub(close_rounded_ring, text)
            if repaired != text:
                return geometry(repaired, origin)
            demand_closed(text, origin)
        reason = " ".join(str(error).removeprefix("ParseException: ").rstrip(".").split())
        raise InputError(
            f"{origin}: {shorten_text(text)!r} is not WKT: {shorten_text(reason, 100)}"
        ) from None


def shapes(shapely_geometry: shapely.Geometry, name: str, origin: str) -> list[Shape]:
    """The shapes of one geometry. Raises InputError."""
    if shapely.get_num_coordinates(shapely_geometry) > MOST_CORNERS:
        raise InputError(f"{origin}: it has more than {MOST_CORNERS} corners, too many to read")
    if shapely_geometry.is_empty:
        raise InputError(f"{origin}: {shapely_geometry.geom_type.upper()} EMPTY has nothing in it")
    return [
        shape
        for part in parts(shapely_geometry, origin)
        for shape in simple_shapes(part, name, origin)
    ]


def parts(shapely_geometry: shapely.Geometry, origin: str) -> list[shapely.Geometry]:
    """The simple geometries of one; the parts of a multipolygon are checked against each other."""
    if shapely_geometry.geom_type == "MultiPolygon":
        simple = list(shapely.get_parts(shapely_geometry))
        for part in simple:
            simple_shapes(part, "", origin)
        demand_valid(shapely_geometry, origin)
        return simple
    if shapely_geometry.geom_type == "GeometryCollection":
        return [
            deep for part in shapely.get_parts(shapely_geometry) for deep in parts(part, origin)
        ]
    return list(shapely.get_parts(shapely_geometry))


def simple_shapes(shapely_geometry: shapely.Geometry, name: str, origin: str) -> list[Shape]:
    """A simple geometry as a shape, none for an empty one. Raises InputError."""
    if shapely_geometry.is_empty:
        return []
    if (
        shapely.has_z(shapely_geometry)
        and (shapely.get_coordinates(shapely_geometry, include_z=True)[:, 2] != 0.0).any()
    ):
        raise InputError(f"{origin}: its points have heights; a geometry in the plane is needed")
    if shapely_geometry.geom_type == "Polygon":
        rings = [pairs(ring) for ring in (shapely_geometry.exterior, *shapely_geometry.interiors)]
        return [area(name, rings, origin)]
    if shapely_geometry.geom_type in ("LineString", "LinearRing"):
        return [line(name, pairs(shapely_geometry), origin)]
    (place,) = pairs(shapely_geometry)
    demand_finite([place], origin)
    need = (
        f"a {shapely_geometry.geom_type.upper()} at {format_place(place)} bounds no area: a "
        "POLYGON is needed"
    )
    return [DrawnPoint(name, origin, (None, None), place, need)]


def pairs(shapely_geometry: shapely.Geometry) -> list[Point]:
    """Points of a simple geometry."""
    return [(float(x), float(y)) for x, y in shapely.get_coordinates(shapely_geometry)]


def close_rounded_ring(ring: re.Match[str]) -> str:
    """A ring that ends where it begins but for rounding, closed; any other as it is."""
    points = ring[1].split(",")
    try:
        ends = [tuple(float(number) for number in points[k].split()[:2]) for k in (0, -1)]
        sides = [float(coordinate) for point in points for coordinate in point.split()[:2]]
    except ValueError:
        return ring[0]
    gap = math.dist(*ends) if len(points) > 3 and all(len(end) == 2 for end in ends) else 0.0
    if not 0.0 < gap <= ROUNDING * (max(sides) - min(sides)):
        return ring[0]
    return f"({','.join([*points[:-1], points[0]])})"


def demand_closed(text: str, origin: str) -> None:
    """Refuse rings of a polygon whose ends differ, naming them. Raises InputError."""
    for ring in RING.findall(LINE.sub("", text)):
        ends = [tuple(point.split()[:2]) for point in ring.split(",")]
        if len(ends) > 1 and ends[0] != ends[-1] and all(len(end) == 2 for end in ends):
            begin, end = (f"({', '.join(ends[k])})" for k in (0, -1))
            raise InputError(
                f"{origin}: the outline is not closed: it begins at {begin} and ends at {end}"
            )


def shorten_text(text: str, limit: int = 40) -> str:
    """The beginning of a text."""
    return text if len(text) <= limit else text[:limit].rstrip() + " ..."
