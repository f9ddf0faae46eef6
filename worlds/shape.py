"""Define what all obstacles have in common: their fields, how they are moved, turned and resized.

A flat shape stands on the plan of the world. In three dimensions it is a prism from `bottom` to
`top`; None is the floor (z = 0) or the world's `height`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Protocol, Self

import numpy as np
import shapely
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from worlds.input_error import InputError

SEGMENTS = 128
"""Straight edges that a full turn of a curve is drawn with."""

Length = Annotated[float, Field(strict=True, gt=0.0, lt=1e9)]
Place = Annotated[float, Field(strict=True, gt=-1e9, lt=1e9)]
Point = tuple[Place, Place]
Corner = tuple[Place, Place] | tuple[Place, Place, Place]
Span = tuple[shapely.Polygon, float | None, float | None]
"""An outline with its bottom and top, None where it reaches the world's floor or height."""


def distinct_corners(points: tuple[Point, ...]) -> tuple[Point, ...]:
    """Corners without those that repeat the one before: they bound nothing."""
    corners = [p for k, p in enumerate(points) if k == 0 or p != points[k - 1]]
    corners = corners[:-1] if corners[0] == corners[-1] else corners
    return tuple(corners) if len(corners) > 2 else points


Corners = Annotated[tuple[Point, ...], Field(min_length=3), AfterValidator(distinct_corners)]


class HasRings(Protocol):
    """A shape bounded by a ring of points, with a ring for each hole."""

    @property
    def points(self) -> tuple[Point, ...]: ...
    @property
    def holes(self) -> tuple[tuple[Point, ...], ...]: ...


@dataclass(frozen=True, slots=True)
class Similarity:
    """A change that keeps shapes: turned and scaled on the plan about a point, then shifted.

    Heights are shifted and never scaled.
    """

    about: tuple[float, float] = (0.0, 0.0)
    degrees: float = 0.0
    """Anticlockwise."""
    factor: float = 1.0
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def point(self, at: Sequence[float]) -> Any:
        """Where a place (2,) or (3,) comes to lie."""
        x, y = at[0], at[1]
        if self.degrees or self.factor != 1.0:  # what is only shifted keeps every bit
            c, s = (self.factor * part for part in turn(self.degrees))
            dx, dy = x - self.about[0], y - self.about[1]
            x, y = self.about[0] + c * dx - s * dy, self.about[1] + s * dx + c * dy
        return x + self.shift[0], y + self.shift[1], *(z + self.shift[2] for z in at[2:])

    def rings(self, shape: HasRings) -> dict[str, Any]:
        """Points and holes, where they come to lie."""
        return {
            "points": tuple(self.point(at) for at in shape.points),
            "holes": tuple(tuple(self.point(at) for at in hole) for hole in shape.holes),
        }


class Shape(BaseModel):
    """What all obstacles have in common.

    A new shape says what it is made of (`spans` or `spheres`) and how it is placed anew
    (`_placed`). It joins `Obstacle` in `worlds.obstacles`; nothing else knows its name.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")
    name: str = ""
    """What messages call it."""

    @property
    def label(self) -> str:
        """Its name, or its shape if it has none."""
        return repr(self.name) if self.name else str(getattr(self, "shape", "obstacle"))

    def spans(self) -> list[Span]:
        """The upright solids that it is made of: outlines with bottom and top."""
        return []

    def spheres(self) -> list[tuple[tuple[float, float, float], float]]:
        """The spheres that it is made of: centre and radius."""
        return []

    def circles(self) -> list[tuple[tuple[float, float], float]]:
        """The circles that the round parts of its outline are of: centre and radius."""
        return []

    def footprint(self) -> shapely.Geometry:
        """Its outline on the plan."""
        return shapely.union_all([outline for outline, _, _ in self.spans()])

    def changed(self, change: Similarity) -> Any:
        """The obstacle as a change makes it; it may be of another shape then."""
        return self.model_copy(update=self._placed(change))

    def _placed(self, change: Similarity) -> dict[str, Any]:
        """The fields that a change changes."""
        raise NotImplementedError

    def moved(self, dx: float, dy: float, dz: float = 0.0) -> Any:
        """The same obstacle, shifted (length)."""
        return self.changed(Similarity(shift=(dx, dy, dz)))

    def turned(self, degrees: float) -> Any:
        """The obstacle turned anticlockwise about its anchor."""
        if degrees % 360.0 == 0.0:
            return self
        return self.changed(Similarity(self.anchor, degrees))

    @property
    def anchor(self) -> tuple[float, float]:
        """The point on the plan about which it turns and by which it is taken."""
        centre = getattr(self, "centre", None)
        if centre is None:
            middle = shapely.centroid(self.footprint())
            centre = middle.x, middle.y
        return float(centre[0]), float(centre[1])

    @property
    def extent(self) -> float:
        """The longer side of its bounds on the plan, length."""
        x, y, u, v = self.footprint().bounds
        return float(max(u - x, v - y))

    def handle_height(self, height: float, /) -> float:
        """The height at which it is taken, in a world of this height, length."""
        return max((height if top is None else top for _, _, top in self.spans()), default=0.0)

    def measures(self) -> dict[str, float]:
        """What of its size can be changed: name -> length, and `turn` in degrees."""
        return {"size": self.extent}

    def resized(self, **wanted: float) -> Any:
        """The obstacle with other measures, about its anchor.

        Raises InputError for a measure that it does not have.
        """
        measures = self.measures()
        for name in wanted:
            if name not in measures:
                kind = getattr(self, "shape", "obstacle")
                raise InputError(f"a {kind} has no {name} (known: {', '.join(measures)})")
        return self._resized(measures | wanted)

    def _resized(self, measures: dict[str, float]) -> Any:
        """The obstacle with these measures, all of them."""
        if "radius" in measures:
            return self.model_copy(update={"radius": measures["radius"]})
        return self.changed(Similarity(self.anchor, factor=measures["size"] / self.extent))


class Flat(Shape):
    """A shape on the plan."""

    bottom: Place | None = None
    """Height at which it begins in three dimensions; None: at the floor."""
    top: Place | None = None
    """Height at which it ends; None: at the world's height."""

    @model_validator(mode="after")
    def _stands(self) -> Self:
        if self.bottom is not None and self.top is not None and self.bottom >= self.top:
            raise ValueError(f"top = {self.top:g} is not above bottom = {self.bottom:g}")
        return self

    def outline(self) -> shapely.Polygon:
        """Its polygon on the plan."""
        raise NotImplementedError

    def spans(self) -> list[Span]:
        """Itself, upright."""
        return [(self.outline(), self.bottom, self.top)]

    def footprint(self) -> shapely.Geometry:
        """Its polygon on the plan."""
        return self.outline()

    def _raised(self, change: Similarity) -> dict[str, Any]:
        dz = change.shift[2]
        return {key: at + dz for key in ("bottom", "top") if (at := getattr(self, key)) is not None}

    def _standing(self) -> dict[str, Any]:
        """Name, bottom and top, as a rectangle takes them."""
        ((_, bottom, top),) = self.spans()
        return {"name": self.name, "bottom": bottom, "top": top}


def circle(centre: tuple[float, float], radius: float) -> np.ndarray:
    """SEGMENTS points on a circle, counterclockwise from +x, (SEGMENTS, 2)."""
    quarter = np.arange(SEGMENTS // 4) * (2.0 * np.pi / SEGMENTS)
    first = np.column_stack([np.cos(quarter), np.sin(quarter)])
    second = np.column_stack([-first[:, 1], first[:, 0]])
    unit = np.concatenate([first, second, -first, -second])
    return np.array(centre) + radius * unit


def turn(degrees: float) -> tuple[float, float]:
    """Cosine and sine of an angle in degrees, exact at right angles."""
    quarter, remainder = divmod(degrees % 360.0, 90.0)
    c, s = math.cos(math.radians(remainder)), math.sin(math.radians(remainder))
    for _ in range(int(quarter)):
        c, s = -s, c
    return c, s
