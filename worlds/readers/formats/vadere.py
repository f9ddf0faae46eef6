"""Scenarios of Vadere: obstacles, sources and targets of a topography, in its bounds.

The layers are those of the file, and `bounds`: what can be walked on. In a bounded topography that
is the bounds without the rim of `boundingBoxWidth`. Sources are starts, targets goals.

Source: Vadere 2, VadereState (topography, its attributes, and shapes).
"""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

from worlds.input_error import InputError, shorten, unknown
from worlds.readers.drawing_contents import MOST_ITEMS, DrawingContents, Item, layers_of, text_of
from worlds.readers.drawn_shapes import Point, Shape, area, circle, format_place
from worlds.readers.roles import GOAL, IGNORE, OBSTACLE, START, WALKABLE

SHAPES = ("POLYGON", "RECTANGLE", "CIRCLE")
BOUNDS = "bounds"
ROLES = {
    BOUNDS: (WALKABLE, "the topography is that large"),
    "obstacles": (OBSTACLE, "Vadere's obstacles"),
    "sources": (START, "where Vadere's pedestrians start"),
    "targets": (GOAL, "where Vadere's pedestrians go"),
}
"""What the lists of a topography are; all others are of no world."""


def read_vadere(path: Path) -> DrawingContents:
    """The topography of a scenario, or of a file of its own. Raises InputError."""
    try:
        document = json.loads(text_of(path))
    except RecursionError:
        raise InputError(f"{path} is not a scenario of Vadere: it is nested too deep") from None
    except ValueError as error:
        raise InputError(f"{path} is not JSON: {' '.join(str(error).split())[:200]}") from None
    topography = topography_of(document, path)
    items = [Item(BOUNDS, "box", partial(bounds, topography, path))]
    for layer, entries in topography.items():
        if not isinstance(entries, list):
            continue
        items += [
            Item(layer, kind_of(element), partial(shapes, element, layer, f"{path}, {layer} {k}"))
            for k, element in enumerate(entries, start=1)
        ]
    if len(items) > MOST_ITEMS:
        raise InputError(f"{path} holds more than {MOST_ITEMS} elements, too many to read")
    ignored = dict.fromkeys(topography, (IGNORE, "it is not of the world"))
    return DrawingContents(path, tuple(items), layers_of(items), 1.0, roles={**ignored, **ROLES})


def topography_of(document: Any, path: Path) -> dict[str, Any]:
    """The topography in a scenario. Raises InputError."""
    for key in ("scenario", "topography"):
        if isinstance(document, dict) and key in document:
            document = document[key]
    if not isinstance(document, dict) or not isinstance(document.get("attributes"), dict):
        raise InputError(
            f"{path} is not a scenario of Vadere: it has no topography with attributes"
        )
    return document


def bounds(topography: dict[str, Any], path: Path) -> list[Shape]:
    """What of the bounds can be walked on. Raises InputError."""
    attributes = topography["attributes"]
    origin = f"{path}, bounds"
    low_x, low_y, width, height = rectangle(attributes.get("bounds"), origin)
    rim = number(attributes, "boundingBoxWidth", origin, 0.0)
    rim = rim if attributes.get("bounded", True) else 0.0
    if not 0.0 <= 2.0 * rim < min(width, height):
        raise InputError(
            f"{origin}: boundingBoxWidth = {rim:g} leaves nothing of {width:g} x {height:g}"
        )
    corners = box(low_x + rim, low_y + rim, low_x + width - rim, low_y + height - rim)
    return [area("", [corners], origin)]


def kind_of(element: Any) -> str:
    """What the shape of an element calls itself."""
    shape = element.get("shape") if isinstance(element, dict) else None
    kind = shape.get("type") if isinstance(shape, dict) else None
    return kind if kind in SHAPES else "element"


def shapes(element: Any, layer: str, origin: str) -> list[Shape]:
    """The shape of an element. Raises InputError."""
    shape = element.get("shape") if isinstance(element, dict) else None
    if not isinstance(shape, dict):
        raise InputError(f"{origin}: it has no shape")
    identity = element.get("id")
    has_number = isinstance(identity, int) and not isinstance(identity, bool) and identity >= 0
    origin = f"{origin} (id {identity})" if has_number else origin
    name = f"{layer.removesuffix('s')} {identity}" if has_number else ""
    kind = shape.get("type")
    if kind == "RECTANGLE":
        x, y, width, height = rectangle(shape, origin)
        return [area(name, [box(x, y, x + width, y + height)], origin)]
    if kind == "CIRCLE":
        centre = shape.get("center")
        return [circle(name, point(centre, origin), number(shape, "radius", origin), origin)]
    if kind != "POLYGON":
        raise unknown("shape", kind, SHAPES, origin)
    corners = shape.get("points")
    if not isinstance(corners, list) or not corners:
        raise InputError(f"{origin}: its polygon has no points")
    points = [point(corner, origin) for corner in corners]
    return [area(name, [[*points, points[0]]], origin)]


def rectangle(value: Any, origin: str) -> tuple[float, float, float, float]:
    """Lower left corner, width and height. Raises InputError."""
    if not isinstance(value, dict):
        raise InputError(f"{origin}: {shorten(value)} is no rectangle")
    x, y, width, height = (number(value, key, origin) for key in ("x", "y", "width", "height"))
    if not (width > 0.0 and height > 0.0):
        raise InputError(f"{origin}: {width:g} x {height:g} at {format_place((x, y))} is no area")
    return x, y, width, height


def box(low_x: float, low_y: float, high_x: float, high_y: float) -> list[Point]:
    """A closed rectangle."""
    return [(low_x, low_y), (high_x, low_y), (high_x, high_y), (low_x, high_y), (low_x, low_y)]


def point(value: Any, origin: str) -> Point:
    """A place. Raises InputError."""
    if not isinstance(value, dict):
        raise InputError(f"{origin}: {shorten(value)} is no point with x and y")
    return (number(value, "x", origin), number(value, "y", origin))


def number(table: dict[str, Any], key: str, origin: str, default: float | None = None) -> float:
    """A number by its key. Raises InputError."""
    value = table.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{origin}: {key} = {shorten(value)} is not a number")
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{origin}: {key} has too many digits") from None
