"""GeoJSON: polygons, lines with a thickness and points with a radius as features.

Coordinates are lengths in a plane, or degrees if asked. The property `kind` or `layer` names a
feature's layer, `name` or `id` the feature; `bottom` and `top` are the heights between which it
stands.

Source: RFC 7946.
"""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any, Literal

from worlds.input_error import InputError, unknown
from worlds.readers.drawing_contents import (
    DEEPEST,
    MOST_ITEMS,
    UNNAMED,
    DrawingContents,
    Item,
    layers_of,
    text_of,
)
from worlds.readers.drawn_shapes import (
    DrawnPoint,
    Point,
    Shape,
    Span,
    area,
    circle,
    demand_finite,
    format_place,
    line,
)

GEOMETRIES = ("Polygon", "MultiPolygon", "LineString", "MultiLineString", "Point", "MultiPoint",
              "GeometryCollection")  # fmt: skip
DEGREES = ("CRS84", "EPSG::4326", "EPSG:4326", "WGS84")
"""Coordinate systems whose coordinates are angles."""


def read_geojson(path: Path) -> DrawingContents:
    """The features of a GeoJSON file. Raises InputError."""
    text = text_of(path)
    try:
        document = json.loads(text, parse_int=parse_integer)
    except RecursionError:
        raise InputError(f"{path} is not GeoJSON: it is nested too deep") from None
    except json.JSONDecodeError as error:
        raise InputError(f"{path} is not JSON: {error}") from None
    if not isinstance(document, dict):
        raise InputError(f"{path} is not GeoJSON: it holds no object with a type")
    feature_list = features(document, path)
    if len(feature_list) > MOST_ITEMS:
        raise InputError(f"{path} holds more than {MOST_ITEMS} features, too many to read")
    items = [item(feature, k, path) for k, feature in enumerate(feature_list, start=1)]
    return DrawingContents(path, tuple(items), layers_of(items), None, degrees=degrees_of(document))


def features(document: dict[str, Any], path: Path) -> list[dict[str, Any]]:
    """The features of a collection, of one feature, or of a bare geometry. Raises InputError."""
    kind = document.get("type")
    if kind == "FeatureCollection":
        items = document.get("features")
        if not isinstance(items, list) or not all(isinstance(item, dict) for item in items):
            raise InputError(f"{path}: 'features' is not a list of features")
        return items
    if kind == "Feature":
        return [document]
    if kind in GEOMETRIES:
        return [{"type": "Feature", "properties": {}, "geometry": document}]
    raise unknown("GeoJSON type", kind, ("FeatureCollection", "Feature", *GEOMETRIES), str(path))


def item(feature: dict[str, Any], number: int, path: Path) -> Item:
    """One feature. Raises InputError if it is none."""
    if feature.get("type") != "Feature":
        raise InputError(
            f"{path}, feature {number}: its type is {feature.get('type')!r}, not Feature"
        )
    properties = feature.get("properties") or {}
    if not isinstance(properties, dict):
        raise InputError(f"{path}, feature {number}: 'properties' is not an object")
    name = str(first(properties.get("name"), properties.get("id"), feature.get("id"), ""))
    layer = str(first(properties.get("kind"), properties.get("layer"), UNNAMED))
    origin = f"{path}, feature {number}" + (f" {name!r}" if name else "")
    geometry = feature.get("geometry")
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    kind = kind if kind in GEOMETRIES else "feature"
    return Item(layer, kind, partial(shapes, geometry, properties, name, origin))


def shapes(
    geometry: Any, properties: dict[str, Any], name: str, origin: str, depth: int = 0
) -> list[Shape]:
    """The shapes of a geometry, `depth` collections deep. Raises InputError."""
    if depth > DEEPEST:
        raise InputError(f"{origin}: it is nested too deep")
    if not isinstance(geometry, dict):
        raise InputError(f"{origin}: it has no geometry")
    kind, coordinates = geometry.get("type"), geometry.get("coordinates")
    span = (number(properties, "bottom", origin), number(properties, "top", origin))
    if kind not in GEOMETRIES:
        raise unknown("geometry", kind, GEOMETRIES, origin)
    if kind == "GeometryCollection":
        parts = geometry.get("geometries")
        if not isinstance(parts, list):
            raise InputError(f"{origin}: 'geometries' is not a list")
        return [
            shape for part in parts for shape in shapes(part, properties, name, origin, depth + 1)
        ]
    several = coordinates if kind.startswith("Multi") else [coordinates]
    if not isinstance(several, list) or not several:
        raise InputError(f"{origin}: its {kind} has no coordinates")
    return [
        simple_shapes(kind.removeprefix("Multi"), part, properties, name, origin, span)
        for part in several
    ]


def simple_shapes(
    kind: str, coordinates: Any, properties: dict[str, Any], name: str, origin: str, span: Span
) -> Shape:
    """One simple geometry. Raises InputError."""
    if kind == "Polygon":
        if not isinstance(coordinates, list) or not coordinates:
            raise InputError(f"{origin}: its Polygon has no outline")
        return area(name, [points(ring, origin) for ring in coordinates], origin, span)
    if kind == "LineString":
        return line(
            name, points(coordinates, origin), origin, number(properties, "thickness", origin), span
        )
    (centre,) = points([coordinates], origin)
    radius = number(properties, "radius", origin)
    if radius is None:
        demand_finite([centre], origin)
        need = f"a Point at {format_place(centre)} bounds no area: give it a radius"
        return DrawnPoint(name, origin, span, centre, need)
    return circle(name, centre, radius, origin, span)


def parse_integer(digits: str) -> float:
    """A number written without a point; one too long for a float is infinite, and refused later."""
    return int(digits) if len(digits) < 300 else float(digits)


def points(coordinates: Any, origin: str) -> list[Point]:
    """Positions as pairs of numbers. Raises InputError."""
    if not isinstance(coordinates, list):
        raise InputError(f"{origin}: {coordinates!r} is not a list of positions")
    places = []
    for k, position in enumerate(coordinates, start=1):
        if not (
            isinstance(position, list)
            and len(position) in (2, 3)
            and all(isinstance(x, int | float) and not isinstance(x, bool) for x in position)
        ):
            raise InputError(f"{origin}: point {k} is {position!r}, not a pair of numbers")
        if len(position) == 3 and position[2] != 0:
            raise InputError(
                f"{origin}: point {k} is {format_place(position)}: a height is given by the "
                "properties 'bottom' and 'top'"
            )
        places.append((float(position[0]), float(position[1])))
    return places


def number(properties: dict[str, Any], key: str, origin: str) -> float | None:
    """A property that is a number, or None without it. Raises InputError."""
    value = properties.get(key)
    if value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
        raise InputError(f"{origin}: {key} = {value!r} is not a number")
    return None if value is None else float(value)


def degrees_of(document: dict[str, Any]) -> Literal["yes", "maybe", "no"]:
    """Whether coordinates are degrees: as the file says, and without a word maybe (RFC 7946)."""
    crs = document.get("crs")
    if crs is None:
        return "maybe"
    properties = crs.get("properties") if isinstance(crs, dict) else None
    crs_name = str(properties.get("name", "")) if isinstance(properties, dict) else ""
    return "yes" if crs_name.upper().replace(" ", "").endswith(DEGREES) else "no"


def first(*values: Any) -> Any:
    """The first value that is given."""
    return next(value for value in values if value is not None)
