"""Recognise plans in degrees, ask about them, and project them to metres around their middle.

Source: RFC 7946, section 4 (longitude, latitude, in this order); Snyder, Map projections, USGS
professional paper 1395, chapter 8 (transverse Mercator), computed by PROJ.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from worlds.input_error import InputError
from worlds.plug_ins import demand
from worlds.readers.drawing_contents import (
    MOST_CORNERS,
    DrawingContents,
    Item,
    PlanChoice,
    PlanQuestion,
)
from worlds.readers.drawn_shapes import (
    Bounds,
    DrawnCurve,
    Point,
    Shape,
    StrayPoint,
    bounds_of,
    format_place,
)
from worlds.readers.roles import IGNORE, LayerRole

WIDEST = 1.0
"""Largest side of a plan in degrees; within it the projection is off by at most 0.02 %."""
FINE = 5
"""Decimals from which a coordinate is hardly a length: a hundredth of a millimetre."""
READ = (".geojson", ".json", ".wkt")
"""Formats that may be in degrees."""


def question_of_degrees(contents: DrawingContents, places: Sequence[Point]) -> PlanQuestion | None:
    """What to ask of a plan that is, or may be, in degrees, and for which nobody has said it."""
    if contents.degrees == "no" or not places:
        return None
    bounds = bounds_of(places)
    if contents.degrees == "maybe" and not look_like_degrees(bounds, places):
        return None
    says = "as the file says" if contents.degrees == "yes" else "as GeoJSON is unless it says else"
    lengths = "" if contents.degrees == "yes" else ", or --unit m if they are lengths"
    choices = [PlanChoice("Degrees", {"degrees": True})]
    if lengths:
        choices.append(PlanChoice("Metres", {"unit": "m"}))
    return PlanQuestion(
        f"{contents.path}: its coordinates, {format_place(bounds[:2])} to "
        f"{format_place(bounds[2:])}, look like longitude and latitude ({says}): give --degrees to "
        f"project them to metres{lengths}",
        tuple(choices),
    )


def look_like_degrees(bounds: Bounds, places: Sequence[Point]) -> bool:
    """Whether places are on the globe, and too near each other, or too exact, to be lengths."""
    low_x, low_y, high_x, high_y = bounds
    if not (low_x >= -180.0 and high_x <= 180.0 and low_y >= -90.0 and high_y <= 90.0):
        return False
    side = max(high_x - low_x, high_y - low_y)
    if 0.0 < side < WIDEST and len(places) > 2:
        return True
    fine = sum(round(x, FINE - 1) != x or round(y, FINE - 1) != y for x, y in places)
    return side < 10.0 * WIDEST and 2 * fine > len(places)


def projected(contents: DrawingContents, rows: Sequence[LayerRole]) -> tuple[DrawingContents, str]:
    """The drawing in metres around the middle of what has a role, and a line about it.

    Lengths beside coordinates (radius, thickness, heights) are metres already. Raises InputError.
    """
    if contents.path.suffix.lower() not in READ:
        raise InputError(f"{contents.path}: --degrees is for {', '.join(READ)} files")
    demand("pyproj", "projecting degrees", "maps")
    roles = {row.layer for row in rows if row.role not in (None, IGNORE)}
    places: list[Point] = []
    for item in contents.items:
        if item.layer in roles:
            try:
                places += places_of(item.read())
            except InputError:  # It is told when the item itself is taken.
                continue
        if len(places) > MOST_CORNERS:
            raise InputError(
                f"{contents.path}: what it draws has more than {MOST_CORNERS} corners, "
                "too many to read"
            )
    if not places:
        return contents, f"{contents.path}: there is nothing to project"
    low_x, low_y, high_x, high_y = bounds_of(places)
    if not (low_x >= -180.0 and high_x <= 180.0 and low_y >= -90.0 and high_y <= 90.0):
        raise InputError(
            f"{contents.path}: its coordinates, {format_place((low_x, low_y))} to "
            f"{format_place((high_x, high_y))}, are no degrees: longitudes are from "
            "-180 to 180, latitudes from -90 to 90"
        )
    if max(high_x - low_x, high_y - low_y) > WIDEST:
        raise InputError(
            f"{contents.path}: it is {max(high_x - low_x, high_y - low_y):.3g} degrees wide: "
            f"at most {WIDEST:g} is projected, beyond it the earth is not flat"
        )
    middle = (round(0.5 * (low_x + high_x), 6), round(0.5 * (low_y + high_y), 6))
    to = to_metres(middle)
    items = tuple(replace(item, read=reader(item, to)) for item in contents.items)
    note = f"degrees are projected to metres, (0, 0) is longitude {middle[0]}, latitude {middle[1]}"
    return replace(contents, items=items, degrees="no"), note


def to_metres(middle: Point) -> Callable[[Point], Point]:
    """What takes a longitude and latitude to metres east and north of a place."""
    from pyproj import Transformer

    tmerc = (
        f"+proj=tmerc +lon_0={middle[0]!r} +lat_0={middle[1]!r} +k=1 +x_0=0 +y_0=0 +ellps=WGS84 "
        "+units=m"
    )
    transform = Transformer.from_crs("EPSG:4326", tmerc, always_xy=True).transform

    def project(place: Point) -> Point:
        x, y = transform(*place)
        return (float(x), float(y))

    return project


def reader(item: Item, to: Callable[[Point], Point]) -> Callable[[], list[Shape]]:
    """How to read an item, with its shapes in metres."""

    def read() -> list[Shape]:
        return [
            shape if isinstance(shape, DrawnCurve | StrayPoint) else shape.map_points(to)
            for shape in item.read()
        ]

    return read


def places_of(shapes: Sequence[Shape]) -> list[Point]:
    """The corners of shapes; of a circle, whose radius is in metres, the centre."""
    return [
        place
        for shape in shapes
        if not isinstance(shape, DrawnCurve | StrayPoint)
        for place in ([shape.centre] if hasattr(shape, "centre") else shape.corners())
    ]
