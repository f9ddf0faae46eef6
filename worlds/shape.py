"""What all obstacles have in common, and how curves become straight edges."""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

import numpy as np
import shapely
from pydantic import BaseModel, ConfigDict, Field, model_validator

SEGMENTS = 128
"""Straight edges that a full turn of a curve is drawn with."""

Length = Annotated[float, Field(strict=True, gt=0.0, lt=1e9)]
Place = Annotated[float, Field(strict=True, gt=-1e9, lt=1e9)]
Point = tuple[Place, Place]
Corner = tuple[Place, Place] | tuple[Place, Place, Place]
Span = tuple[shapely.Polygon, float | None, float | None]
"""An outline with its bottom and top, None where it reaches the world's floor or height."""


class Shape(BaseModel):
    """What all obstacles have in common."""

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

    def footprint(self) -> shapely.Geometry:
        """Its outline on the plan."""
        return shapely.union_all([outline for outline, _, _ in self.spans()])

    def moved(self, dx: float, dy: float, dz: float = 0.0) -> Self:
        """The same obstacle, shifted (length)."""
        return self.model_copy(update=self._shifted(dx, dy, dz))

    def _shifted(self, dx: float, dy: float, dz: float) -> dict[str, Any]:
        """The fields that a shift changes."""
        raise NotImplementedError


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

    def _raised(self, dz: float) -> dict[str, Any]:
        return {key: at + dz for key in ("bottom", "top") if (at := getattr(self, key)) is not None}


def circle(centre: tuple[float, float], radius: float) -> np.ndarray:
    """SEGMENTS points on a circle, counterclockwise from +x, (SEGMENTS, 2)."""
    quarter = np.arange(SEGMENTS // 4) * (2.0 * np.pi / SEGMENTS)
    first = np.column_stack([np.cos(quarter), np.sin(quarter)])
    second = np.column_stack([-first[:, 1], first[:, 0]])
    unit = np.concatenate([first, second, -first, -second])
    return np.array(centre) + radius * unit


def turn(degrees: float) -> tuple[float, float]:
    """Cosine and sine of an angle in degrees, exact at right angles."""
    quarter, rest = divmod(degrees % 360.0, 90.0)
    c, s = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(quarter)):
        c, s = -s, c
    return c, s


def shifted(point: tuple[float, float], dx: float, dy: float) -> tuple[float, float]:
    """The point, moved."""
    return point[0] + dx, point[1] + dy
