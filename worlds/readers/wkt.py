"""WKT: one geometry a line, `name: POLYGON ((...))`; a line that begins with # is a comment.

The name is the layer and the name of the obstacle; without one the layer is `obstacle`.

Source: OGC 06-103r4, section 7 (well-known text); read by GEOS.
"""

from __future__ import annotations

import re
from functools import partial
from itertools import accumulate
from pathlib import Path

import numpy as np
import shapely

from worlds.readers.contents import OBSTACLE, Contents, Item, layers_of, text_of
from worlds.readers.shapes import Point, Shape, area, at, demand_valid, line
from worlds.refusal import Refusal

NAMED = re.compile(r"\s*(?:(?P<name>[^:()]+?)\s*:)?\s*(?P<wkt>\S.*?)\s*")
DEEPEST = 50
"""Most parentheses one in another."""
RING = re.compile(r"\(([^()]*)\)")


def read_wkt(path: Path) -> Contents:
    """The geometries of a WKT file. Raises Refusal."""
    items = []
    for number, text in enumerate(text_of(path).splitlines(), start=1):
        if not text.strip() or text.lstrip().startswith("#"):
            continue
        found = NAMED.fullmatch(text)
        if not found:
            raise Refusal(f"{path}, line {number}: a name, but no geometry")
        name = found["name"] or ""
        origin = f"{path}, line {number}" + (f" {name!r}" if name else "")
        items.append(Item(name or OBSTACLE, partial(shapes, found["wkt"], name, origin)))
    return Contents(tuple(items), layers_of(items), None)


def shapes(text: str, name: str, origin: str) -> list[Shape]:
    """The shapes of one geometry. Raises Refusal."""
    demand_closed(text, origin)
    steps = ({"(": 1, ")": -1}.get(letter, 0) for letter in text)
    if max(accumulate(steps), default=0) > DEEPEST:
        raise Refusal(f"{origin}: it is nested too deep")
    try:
        with np.errstate(invalid="ignore", over="ignore"):  # NaN and inf are refused below
            made = shapely.from_wkt(text)
    except (shapely.errors.GEOSException, NotImplementedError) as error:
        reason = str(error).removeprefix("ParseException: ").rstrip(".")
        raise Refusal(f"{origin}: {short(text)!r} is not WKT: {reason}") from None
    if made.is_empty:
        raise Refusal(f"{origin}: {made.geom_type.upper()} EMPTY has nothing in it")
    return [shape for part in parts(made, origin) for shape in one(part, name, origin)]


def parts(made: shapely.Geometry, origin: str) -> list[shapely.Geometry]:
    """The simple geometries of one; the parts of a multipolygon are checked against each other."""
    if made.geom_type == "MultiPolygon":
        simple = list(shapely.get_parts(made))
        for part in simple:
            one(part, "", origin)
        demand_valid(made, origin)
        return simple
    if made.geom_type == "GeometryCollection":
        return [deep for part in shapely.get_parts(made) for deep in parts(part, origin)]
    return list(shapely.get_parts(made))


def one(made: shapely.Geometry, name: str, origin: str) -> list[Shape]:
    """A simple geometry as a shape. Raises Refusal for one that bounds no area."""
    if shapely.has_z(made) and (shapely.get_coordinates(made, include_z=True)[:, 2] != 0.0).any():
        raise Refusal(f"{origin}: its points have heights; a geometry in the plane is needed")
    if made.geom_type == "Polygon":
        rings = [pairs(ring) for ring in (made.exterior, *made.interiors)]
        return [area(name, rings, origin)]
    if made.geom_type in ("LineString", "LinearRing"):
        return [line(name, pairs(made), origin)]
    raise Refusal(
        f"{origin}: a {made.geom_type.upper()} at {at(pairs(made)[0])} bounds no area: "
        "a POLYGON or MULTIPOLYGON is needed"
    )


def pairs(made: shapely.Geometry) -> list[Point]:
    """Points of a simple geometry."""
    return [(float(x), float(y)) for x, y in shapely.get_coordinates(made)]


def demand_closed(text: str, origin: str) -> None:
    """Refuse rings of a polygon whose ends differ, naming them. Raises Refusal."""
    if "POLYGON" not in text.upper():
        return
    for ring in RING.findall(text):
        ends = [tuple(point.split()[:2]) for point in ring.split(",")]
        if len(ends) > 1 and ends[0] != ends[-1] and all(len(end) == 2 for end in ends):
            begin, end = (f"({', '.join(ends[k])})" for k in (0, -1))
            raise Refusal(
                f"{origin}: the outline is not closed: it begins at {begin} and ends at {end}"
            )


def short(text: str, most: int = 40) -> str:
    """The beginning of a text."""
    return text if len(text) <= most else text[:most].rstrip() + " ..."
