"""The solid shapes that a world may hold, and how a layout's table or a rectangle becomes one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal, Self, get_args

import numpy as np
import shapely
from pydantic import Field, TypeAdapter, ValidationError, field_validator, model_validator

from worlds.input_error import InputError, first_input_error, unknown
from worlds.shape import (
    Corner,
    Corners,
    Flat,
    Length,
    Place,
    Point,
    Shape,
    Similarity,
    Span,
    circle,
    turn,
)


class Disc(Flat):
    """A filled circle."""

    shape: Literal["disc"] = "disc"
    centre: Point
    radius: Length

    def outline(self) -> shapely.Polygon:
        """A regular polygon with its corners on the circle."""
        return shapely.Polygon(circle(self.centre, self.radius))

    def circles(self) -> list[tuple[tuple[float, float], float]]:
        """Its rim."""
        return [(self.centre, self.radius)]

    def measures(self) -> dict[str, float]:
        """Its radius."""
        return {"radius": self.radius}

    def _placed(self, change: Similarity) -> dict[str, Any]:
        radius = change.factor * self.radius
        return {"centre": change.point(self.centre), "radius": radius, **self._raised(change)}


class Polygon(Flat):
    """A polygon, maybe with holes; its last point is joined to its first."""

    shape: Literal["polygon"] = "polygon"
    points: Corners
    holes: tuple[Corners, ...] = ()

    def outline(self) -> shapely.Polygon:
        """The polygon."""
        return shapely.Polygon(self.points, self.holes)

    def _placed(self, change: Similarity) -> dict[str, Any]:
        return {**change.rings(self), **self._raised(change)}


class Wall(Flat):
    """A straight wall with flat ends: a rectangle around its centre line."""

    shape: Literal["wall"] = "wall"
    start: Point
    end: Point
    thickness: Length

    @model_validator(mode="after")
    def _has_length(self) -> Self:
        if self.start == self.end:
            raise ValueError(f"start and end are both {list(self.start)}: a wall needs a length")
        return self

    def outline(self) -> shapely.Polygon:
        """The rectangle."""
        start, end = np.array(self.start), np.array(self.end)
        along = (end - start) / math.dist(start, end)
        half_width = 0.5 * self.thickness * np.array([-along[1], along[0]])
        return shapely.Polygon(
            [start - half_width, end - half_width, end + half_width, start + half_width]
        )

    @property
    def anchor(self) -> tuple[float, float]:
        """The middle of its centre line."""
        (x, y), (u, v) = self.start, self.end
        return 0.5 * (x + u), 0.5 * (y + v)

    def measures(self) -> dict[str, float]:
        """Its sides, and its turn."""
        (x, y), (u, v) = self.start, self.end
        angle = math.degrees(math.atan2(v - y, u - x)) % 180.0
        return {"width": math.hypot(u - x, v - y), "depth": self.thickness, "turn": angle}

    def _resized(self, measures: dict[str, float]) -> Any:
        return rectangle(self.anchor, *measures.values(), **self._standing())

    def _placed(self, change: Similarity) -> dict[str, Any]:
        return {
            "start": change.point(self.start),
            "end": change.point(self.end),
            "thickness": change.factor * self.thickness,
            **self._raised(change),
        }


class Ring(Flat):
    """A closed ring: a disc with a round hole."""

    shape: Literal["ring"] = "ring"
    centre: Point
    radius: Length
    """Of the outer circle."""
    width: Length

    @model_validator(mode="after")
    def _has_a_hole(self) -> Self:
        if self.width >= self.radius:
            raise ValueError(f"width = {self.width:g} leaves no hole in radius = {self.radius:g}")
        return self

    def outline(self) -> shapely.Polygon:
        """A regular polygon with a hole of as many corners."""
        inner = circle(self.centre, self.radius - self.width)
        return shapely.Polygon(circle(self.centre, self.radius), [inner])

    def circles(self) -> list[tuple[tuple[float, float], float]]:
        """Its outer rim, and its inner one."""
        return [(self.centre, self.radius), (self.centre, self.radius - self.width)]

    def _placed(self, change: Similarity) -> dict[str, Any]:
        return {
            "centre": change.point(self.centre),
            "radius": change.factor * self.radius,
            "width": change.factor * self.width,
            **self._raised(change),
        }


class CShape(Flat):
    """Three sides of a rectangle: a pocket, open towards the direction `opening`."""

    shape: Literal["c"] = "c"
    centre: Point
    size: tuple[Length, Length]
    """Outer width and height while it is open towards +x, before it is turned."""
    thickness: Length
    opening: Place = 0.0
    """Direction in degrees, 0 is +x, 90 is +y."""

    @model_validator(mode="after")
    def _is_open(self) -> Self:
        width, height = self.size
        if self.thickness >= width or 2.0 * self.thickness >= height:
            raise ValueError(
                f"thickness = {self.thickness:g} leaves no room in size = {list(self.size)}"
            )
        return self

    def outline(self) -> shapely.Polygon:
        """Eight corners, turned."""
        x, y = 0.5 * self.size[0], 0.5 * self.size[1]
        t = self.thickness
        lower = [(-x, -y), (x, -y), (x, t - y), (t - x, t - y)]
        upper = [(t - x, y - t), (x, y - t), (x, y), (-x, y)]
        c, s = turn(self.opening)
        corners = np.array([*lower, *upper]) @ np.array([[c, s], [-s, c]])
        return shapely.Polygon(corners + np.array(self.centre))

    def _placed(self, change: Similarity) -> dict[str, Any]:
        return {
            "centre": change.point(self.centre),
            "size": (change.factor * self.size[0], change.factor * self.size[1]),
            "thickness": change.factor * self.thickness,
            "opening": (self.opening + change.degrees) % 360.0 if change.degrees else self.opening,
            **self._raised(change),
        }


class Sphere(Shape):
    """A sphere; only in three dimensions."""

    shape: Literal["sphere"] = "sphere"
    centre: tuple[Place, Place, Place]
    radius: Length

    def spheres(self) -> list[tuple[tuple[float, float, float], float]]:
        """Itself."""
        return [(self.centre, self.radius)]

    def footprint(self) -> shapely.Geometry:
        """Its projection on the plan."""
        return shapely.Polygon(circle(self.centre[:2], self.radius))

    def handle_height(self, _height: float, /) -> float:
        """That of its centre."""
        return self.centre[2]

    def measures(self) -> dict[str, float]:
        """Its radius."""
        return {"radius": self.radius}

    def _placed(self, change: Similarity) -> dict[str, Any]:
        return {"centre": change.point(self.centre), "radius": change.factor * self.radius}


class Box(Flat):
    """An upright box with sides along the axes; corners with 2 or 3 coordinates."""

    shape: Literal["box"] = "box"
    low: Corner
    high: Corner

    @model_validator(mode="after")
    def _is_a_box(self) -> Self:
        low, high = list(self.low), list(self.high)
        if len(low) != len(high):
            raise ValueError(f"low = {low} and high = {high} differ in dimension")
        if any(a >= b for a, b in zip(low, high, strict=True)):
            raise ValueError(f"high = {high} is not above low = {low} on every axis")
        if len(low) == 3 and (self.bottom, self.top) != (None, None):
            raise ValueError("a box with three coordinates has its own bottom and top")
        return self

    def outline(self) -> shapely.Polygon:
        """The rectangle."""
        (x, y), (u, v) = self.low[:2], self.high[:2]
        return shapely.Polygon([(x, y), (u, y), (u, v), (x, v)])

    def spans(self) -> list[Span]:
        """Itself, upright."""
        if len(self.low) == 3 and len(self.high) == 3:
            return [(self.outline(), self.low[2], self.high[2])]
        return super().spans()

    @property
    def anchor(self) -> tuple[float, float]:
        """Its middle."""
        (x, y), (u, v) = self.low[:2], self.high[:2]
        return 0.5 * (x + u), 0.5 * (y + v)

    def measures(self) -> dict[str, float]:
        """Its sides; its turn is none."""
        width, depth = (b - a for a, b in zip(self.low[:2], self.high[:2], strict=True))
        return {"width": width, "depth": depth, "turn": 0.0}

    def changed(self, change: Similarity) -> Any:
        """The box as a change makes it; turned out of the axes it is a wall of the same sides."""
        moved_box = super().changed(replace(change, degrees=0.0))
        if change.degrees % 360.0 == 0.0:
            return moved_box
        measures = moved_box.measures() | {"turn": change.degrees}
        return rectangle(change.point(self.anchor), *measures.values(), **moved_box._standing())

    def _resized(self, measures: dict[str, float]) -> Any:
        return rectangle(self.anchor, *measures.values(), **self._standing())

    def _placed(self, change: Similarity) -> dict[str, Any]:
        low, high = change.point(self.low), change.point(self.high)
        return {"low": low, "high": high, **self._raised(change)}


class Prism(Shape):
    """A polygon, maybe with holes, from a bottom to a top; only in three dimensions."""

    shape: Literal["prism"] = "prism"
    points: Corners
    holes: tuple[Corners, ...] = ()
    bottom: Place
    top: Place

    @model_validator(mode="after")
    def _stands(self) -> Self:
        if self.bottom >= self.top:
            raise ValueError(f"top = {self.top:g} is not above bottom = {self.bottom:g}")
        return self

    def spans(self) -> list[Span]:
        """Itself."""
        return [(shapely.Polygon(self.points, self.holes), self.bottom, self.top)]

    def _placed(self, change: Similarity) -> dict[str, Any]:
        dz = change.shift[2]
        return {**change.rings(self), "bottom": self.bottom + dz, "top": self.top + dz}


class Union(Shape):
    """Several obstacles under one name."""

    shape: Literal["union"] = "union"
    parts: tuple[Obstacle, ...] = Field(min_length=1)

    @field_validator("parts", mode="before")
    @classmethod
    def _known_shapes(cls, parts: Any) -> Any:
        for part in parts if isinstance(parts, list | tuple) else ():
            if isinstance(part, Mapping) and part.get("shape") not in SHAPES:
                raise ValueError(str(unknown("shape", part.get("shape"), SHAPES)))
        return parts

    def spans(self) -> list[Span]:
        """Those of its parts."""
        return [span for part in self.parts for span in part.spans()]

    def spheres(self) -> list[tuple[tuple[float, float, float], float]]:
        """Those of its parts."""
        return [sphere for part in self.parts for sphere in part.spheres()]

    def circles(self) -> list[tuple[tuple[float, float], float]]:
        """Those of its parts."""
        return [circle for part in self.parts for circle in part.circles()]

    def footprint(self) -> shapely.Geometry:
        """The union of its parts' footprints."""
        return shapely.union_all([part.footprint() for part in self.parts])

    def _placed(self, change: Similarity) -> dict[str, Any]:
        return {"parts": tuple(part.changed(change) for part in self.parts)}


Obstacle = Annotated[
    Disc | Polygon | Wall | Ring | CShape | Sphere | Box | Prism | Union,
    Field(discriminator="shape"),
]
SHAPES = {shape.model_fields["shape"].default: shape for shape in get_args(get_args(Obstacle)[0])}
Union.model_rebuild()
ADAPTER: TypeAdapter[Any] = TypeAdapter(Obstacle)


def obstacle(values: Mapping[str, Any], origin: str = "") -> Any:
    """The obstacle that a table of a layout describes, chosen by its key `shape`.

    Raises InputError naming the obstacle, the key and the value; `origin` says where it came from.

    >>> obstacle({"shape": "disc", "centre": [2, 3], "radius": 0.5}).footprint().bounds
    (1.5, 2.5, 2.5, 3.5)
    """
    if not isinstance(values, Mapping):
        raise InputError(f"obstacle = {values!r} is not a table of keys ({origin})")
    if "shape" not in values:
        raise InputError(f"obstacle {dict(values)} has no shape (known: {', '.join(SHAPES)})")
    if values["shape"] not in SHAPES:
        raise unknown("shape", values["shape"], SHAPES, origin)
    label = repr(values["name"]) if values.get("name") else values["shape"]
    try:
        return ADAPTER.validate_python(values)
    except ValidationError as error:
        raise first_input_error(error, f"obstacle {label}", origin, SHAPES) from None


def rectangle(
    at: Sequence[float], width: float, depth: float, turned: float = 0.0, **more: Any
) -> Box | Wall:
    """A rectangle about its centre `at`, turned anticlockwise by degrees.

    Along the axes it is a `Box`; else it is a `Wall`, which keeps its sides.

    >>> rectangle((2, 2), 4.0, 2.0).footprint().bounds
    (0.0, 1.0, 4.0, 3.0)
    """
    x, y = float(at[0]), float(at[1])
    if turned % 90.0 == 0.0:
        if turned % 180.0:
            width, depth = depth, width
        low, high = (x - 0.5 * width, y - 0.5 * depth), (x + 0.5 * width, y + 0.5 * depth)
        return obstacle({"shape": "box", "low": low, "high": high, **more})
    c, s = turn(turned)
    dx, dy = 0.5 * width * c, 0.5 * width * s
    start, end = (x - dx, y - dy), (x + dx, y + dy)
    return obstacle({"shape": "wall", "start": start, "end": end, "thickness": depth, **more})
