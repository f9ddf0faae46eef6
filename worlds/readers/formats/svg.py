"""SVG: paths, polygons, rectangles, circles, ellipses and lines, on the layers of Inkscape.

A layer is a group that Inkscape calls so, else the outermost group with an id, else the class of
the shape. What is filled is an area, what has no fill a line. y grows upwards in the world, and
lengths are those of the viewBox, of which the file does not say how long they are. Read by
svgelements; use elements, transforms and styles are followed.

Source: W3C, SVG 1.1 (second edition), chapters 8 to 11.
"""

from __future__ import annotations

import io
import math
import xml.etree.ElementTree as Xml
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from xml.parsers import expat

import shapely

from worlds.input_error import InputError, shorten
from worlds.readers.drawing_contents import (
    DEEPEST,
    MOST_ITEMS,
    UNNAMED,
    DrawingContents,
    Item,
    bytes_of,
)
from worlds.readers.drawn_shapes import Point, Shape, StrayPoint, area, circle, demand_finite, line
from worlds.readers.formats.dxf import MOST_OUTLINES, STEP, nest_rings

LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
GROUPMODE = "{http://www.inkscape.org/namespaces/inkscape}groupmode"
HREF = "{http://www.w3.org/1999/xlink}href"
SIZES = ("viewBox", "width", "height")
"""What of the outermost element would scale its coordinates."""
CHORDS = 32
"""Chords of a Bezier curve."""
STUMBLES = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)
"""What svgelements raises over values that it cannot use."""
ROUND = 1e-9
"""Radii of a circle that differ by less than this share are one."""


def read_svg(path: Path) -> DrawingContents:
    """The shapes of an SVG file. Raises InputError."""
    import svgelements

    root = document(bytes_of(path), path)
    height = height_of(root)
    demand_few(root, path)
    for key in SIZES:
        root.attrib.pop(key, None)
    text = io.BytesIO(Xml.tostring(root))
    try:
        drawing = svgelements.SVG.parse(text, reify=False)
    except (
        ArithmeticError,
        AttributeError,
        LookupError,
        RecursionError,
        TypeError,
        ValueError,
    ) as e:
        raise InputError(
            f"{path} is not SVG, or damaged: {' '.join(str(e).split())[:200]}"
        ) from None
    items: list[Item] = []
    left_out = Counter[tuple[str, str]]()
    for element, layer in elements(drawing, ""):
        kind = type(element).__name__.lower()
        if not isinstance(element, svgelements.Shape):
            left_out[kind, layer] += 1
            continue
        own = attributes(element)
        name = str(own.get(LABEL) or own.get("id") or "")
        number = len(items) + 1
        origin = f"{path}, layer {layer!r}, {kind} {number}" + (f" {name!r}" if name else "")
        items.append(Item(layer, kind, partial(shapes, element, height, origin)))
        if number > MOST_ITEMS:
            raise InputError(f"{path} draws more than {MOST_ITEMS} shapes, too many to read")
    layers = dict.fromkeys([*(item.layer for item in items), *(layer for _, layer in left_out)])
    return DrawingContents(path, tuple(items), tuple(layers), None, left_out=left_out)


def document(data: bytes, path: Path) -> Xml.Element:
    """The outermost element. Raises InputError; a file that declares entities is not read."""
    demand_no_entities(data, path)
    try:
        root = Xml.fromstring(data)
    except (Xml.ParseError, ValueError, LookupError) as error:
        raise InputError(f"{path} is not SVG: {error}") from None
    if root.tag.rpartition("}")[2] != "svg":
        raise InputError(f"{path} is not SVG: its outermost element is {shorten(root.tag)}")
    return root


def demand_no_entities(data: bytes, path: Path) -> None:
    """Refuse a file that declares entities, of which few bytes make many. Raises InputError."""

    # The parser looks, not we for `<!ENTITY`: in UTF-16 that is written otherwise.
    def declared(*_: object) -> None:
        raise InputError(f"{path}: it declares entities, which are not read: save it as plain SVG")

    parser = expat.ParserCreate()
    parser.EntityDeclHandler = declared
    try:
        parser.Parse(data, True)
    except InputError:
        raise
    except (expat.ExpatError, LookupError, ValueError):
        return  # what is no XML is told by who reads it


def height_of(root: Xml.Element) -> float:
    """Where y is 0 in the world, in the file's y: the lower edge of what is shown, if it says."""
    try:
        box = [float(number) for number in root.get("viewBox", "").replace(",", " ").split()]
        height = box[1] + box[3] if len(box) == 4 else float(root.get("height", "0"))
    except ValueError:
        return 0.0
    return height if math.isfinite(height) else 0.0


def demand_few(root: Xml.Element, path: Path) -> None:
    """Refuse what would draw too much, use elements counted as often as they are opened."""
    by_id = {node.get("id"): node for node in root.iter() if "id" in node.attrib}
    counts: dict[Xml.Element, int] = {}
    # Each element after all that it holds or uses, without recursion.
    stack: list[tuple[Xml.Element, int, bool]] = [(root, 0, False)]
    open_nodes: set[Xml.Element] = set()
    while stack:
        element, depth, is_done = stack.pop()
        parts = [*element]
        # As svgelements has it, which leaves out the first letter, whatever that is.
        address = element.get("href", element.get(HREF))
        target = None if address is None else by_id.get(address[1:])
        if element.tag.rpartition("}")[2] == "use" and target is not None:
            parts.append(target)
        if is_done:
            open_nodes.discard(element)
            counts[element] = 1 + sum(counts[part] for part in parts)
            if counts[element] > MOST_ITEMS:
                raise InputError(
                    f"{path} draws more than {MOST_ITEMS} elements, those of use counted "
                    "as often as they are used: too many to read"
                )
            continue
        if element in counts:
            continue
        if element in open_nodes:
            raise InputError(f"{path}: the element {shorten(element.get('id'))} uses itself")
        if depth > DEEPEST:
            raise InputError(f"{path}: its elements are nested more than {DEEPEST} deep")
        open_nodes.add(element)
        stack.append((element, depth, True))
        stack += [(part, depth + 1, False) for part in parts]


def elements(group: Any, layer: str) -> Iterator[tuple[Any, str]]:
    """What is drawn, with its layer."""
    for element in group:
        own = attributes(element)
        if isinstance(element, list):
            is_layer = own.get(GROUPMODE) == "layer"
            name = str(own.get(LABEL) or own.get("id") or "")
            yield from elements(element, name if name and (is_layer or not layer) else layer)
        elif type(element).__name__ not in ("Title", "Desc", "SVGElement"):
            yield element, layer or str(own.get("class") or UNNAMED)


def attributes(element: Any) -> dict[str, Any]:
    """What an element itself says, without what it inherits."""
    values = getattr(element, "values", None)
    own = values.get("attributes") if isinstance(values, dict) else None
    return own if isinstance(own, dict) else {}


def shapes(element: Any, height: float, origin: str) -> list[Shape]:
    """The shapes of an element. Raises InputError."""
    import svgelements

    try:
        is_filled = element.fill is not None and element.fill.value is not None
        matrix = element.transform
        if isinstance(element, svgelements.Circle | svgelements.Ellipse):
            scale = math.hypot(matrix.a, matrix.b)
            if abs(element.rx - element.ry) <= ROUND * element.rx and keeps_circles(matrix):
                centre = matrix.point_in_matrix_space((element.cx, element.cy))
                place = (float(centre.x), height - float(centre.y))
                radius = float(element.rx) * scale
                return [circle("", place, radius, origin, is_line=not is_filled)]
        path = svgelements.Path(element)
        lines = [subpath(piece, matrix, height) for piece in path.as_subpaths()]
    except InputError:
        raise
    except STUMBLES as error:
        raise InputError(f"{origin}: it is damaged: {' '.join(str(error).split())[:200]}") from None
    if len(lines) > MOST_OUTLINES:
        raise InputError(f"{origin}: it has more than {MOST_OUTLINES} pieces, too many to read")
    lines = [points for points in lines if points]
    for points in lines:
        demand_finite(points, origin)
    if lines and len({point for points in lines for point in points}) == 1:
        return [StrayPoint("", origin, (None, None), lines[0][0])]
    if not is_filled or isinstance(element, svgelements.SimpleLine):
        return [
            area("", [points], origin, is_line=True)
            if len(points) > 3 and points[0] == points[-1]
            else line("", points, origin)
            for points in lines
        ]
    # A fill closes what is open, and has no part where two corners or fewer are.
    rings = [points if points[0] == points[-1] else [*points, points[0]] for points in lines]
    rings = [ring for ring in rings if len(set(ring)) > 2]
    for ring in rings:
        area("", [ring], origin)
    if str(element.values.get("fill-rule", "nonzero")) != "evenodd":
        rings = filled_edges(rings)
    return [area("", ring_set, origin) for ring_set in nest_rings(rings)]


def keeps_circles(matrix: Any) -> bool:
    """Whether a circle stays one: turned, mirrored, moved, and scaled alike along both axes."""
    a, b, c, d = (float(number) for number in (matrix.a, matrix.b, matrix.c, matrix.d))
    near = ROUND * max(abs(a), abs(b))
    is_rotation = abs(a - d) <= near and abs(b + c) <= near
    mirrored = abs(a + d) <= near and abs(b - c) <= near
    return is_rotation or mirrored


def subpath(piece: Any, matrix: Any, height: float) -> list[Point]:
    """The points of a piece of a path where they are drawn; curves are drawn by chords."""
    points: list[Point] = []
    for segment in piece:
        kind = type(segment).__name__
        if segment.end is None:
            continue
        if kind == "Arc":
            count = max(1, math.ceil(abs(float(segment.sweep)) / STEP - 1e-9))
        else:
            count = CHORDS if kind in ("QuadraticBezier", "CubicBezier") else 1
        for place in [*(segment.point(k / count) for k in range(1, count)), segment.end]:
            centre = matrix.point_in_matrix_space(place)
            points.append((float(centre.x), height - float(centre.y)))
    return points


def filled_edges(rings: Sequence[list[Point]]) -> list[list[Point]]:
    """The rings at which a fill of the rule nonzero begins or ends; they do not cross."""
    areas = [shapely.Polygon(ring) for ring in rings]
    turn = [1 if shapely.is_ccw(polygon.exterior) else -1 for polygon in areas]
    tree = shapely.STRtree(areas)
    edges = []
    for k, area_polygon in enumerate(areas):
        windings = [
            int(j)
            for j in tree.query(area_polygon, predicate="covered_by")
            if j != k
            and (
                areas[j].area > area_polygon.area or (areas[j].area == area_polygon.area and j < k)
            )
        ]
        outside = sum(turn[j] for j in windings)
        if (outside == 0) != (outside + turn[k] == 0):
            edges.append(rings[k])
    return edges
