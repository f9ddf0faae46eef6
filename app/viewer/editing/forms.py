"""Obstacles as a person draws them: made, measured, resized, turned and moved.

A rectangle along the axes is a `Box`; turned by an angle it is a `Wall`, which keeps its sides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import shapely

from worlds.obstacles import (
    Box,
    CShape,
    Disc,
    Polygon,
    Prism,
    Ring,
    Sphere,
    Union,
    Wall,
    obstacle,
    turn,
)
from worlds.refusal import Refusal
from worlds.world import World

LEAST, MOST = 1e-3, 4.0
"""Least and most extent of what a person draws, as multiples of the world's longest side."""
CORNERS = 200
"""Corners of a drawn polygon at most."""
MEASURES = ("radius", "width", "depth", "size")
"""Lengths by which obstacles are drawn."""


def disc(at: Sequence[float], radius: float) -> Disc:
    """A disc, or in three dimensions a column."""
    return obstacle({"shape": "disc", "centre": (float(at[0]), float(at[1])), "radius": radius})


def rectangle(
    at: Sequence[float], width: float, depth: float, degrees: float = 0.0, **more: Any
) -> Box | Wall:
    """A rectangle about its centre `at`, turned anticlockwise.

    >>> rectangle((2, 2), 4.0, 2.0).footprint().bounds
    (0.0, 1.0, 4.0, 3.0)
    """
    x, y = float(at[0]), float(at[1])
    if degrees % 90.0 == 0.0:
        if degrees % 180.0:
            width, depth = depth, width
        low, high = (x - 0.5 * width, y - 0.5 * depth), (x + 0.5 * width, y + 0.5 * depth)
        return obstacle({"shape": "box", "low": low, "high": high, **more})
    c, s = turn(degrees)
    dx, dy = 0.5 * width * c, 0.5 * width * s
    start, end = (x - dx, y - dy), (x + dx, y + dy)
    return obstacle({"shape": "wall", "start": start, "end": end, "thickness": depth, **more})


def polygon(points: Sequence[Sequence[float]]) -> Polygon:
    """A polygon of the corners that were clicked; a corner clicked twice counts once.

    Raises Refusal for fewer than three corners or more than CORNERS.
    """
    corners = [(float(point[0]), float(point[1])) for point in points]
    kept = [one for one, before in zip(corners, corners[-1:] + corners[:-1], strict=True)
            if one != before]  # fmt: skip
    if len(kept) < 3:
        raise Refusal(f"a polygon needs 3 corners or more, {len(kept)} were given")
    if len(kept) > CORNERS:
        raise Refusal(f"a polygon has {CORNERS} corners at most, {len(kept)} were given")
    return obstacle({"shape": "polygon", "points": kept})


def measures(shape: Any) -> dict[str, float]:
    """What of an obstacle's size can be changed: name -> length, and `turn` in degrees."""
    if isinstance(shape, Disc | Sphere):
        return {"radius": shape.radius}
    if isinstance(shape, Box):
        width, depth = (b - a for a, b in zip(shape.low[:2], shape.high[:2], strict=True))
        return {"width": width, "depth": depth, "turn": 0.0}
    if isinstance(shape, Wall):
        (x, y), (u, v) = shape.start, shape.end
        angle = math.degrees(math.atan2(v - y, u - x)) % 180.0
        return {"width": math.hypot(u - x, v - y), "depth": shape.thickness, "turn": angle}
    return {"size": extent(shape)}


def resized(shape: Any, **wanted: float) -> Any:
    """The obstacle with other measures, about the same centre.

    Raises Refusal for a measure that it does not have.
    """
    now = measures(shape)
    for name in wanted:
        if name not in now:
            raise Refusal(f"a {shape.shape} has no {name} (known: {', '.join(now)})")
    now |= wanted
    if "radius" in now:
        return shape.model_copy(update={"radius": now["radius"]})
    if "size" in now:
        return scaled(shape, now["size"] / extent(shape), anchor(shape))
    return rectangle(anchor(shape), now["width"], now["depth"], now["turn"], **standing(shape))


def turned(shape: Any, degrees: float, about: Sequence[float] | None = None) -> Any:
    """The obstacle turned anticlockwise about a point, its own centre unless given."""
    if degrees % 360.0 == 0.0:
        return shape
    about = anchor(shape) if about is None else about
    c, s = turn(degrees)

    def at(point: Sequence[float]) -> tuple[float, ...]:
        x, y = point[0] - about[0], point[1] - about[1]
        return about[0] + c * x - s * y, about[1] + s * x + c * y, *point[2:]

    if isinstance(shape, Polygon | Prism):
        return placed_again(shape, at)
    if isinstance(shape, Wall):
        return shape.model_copy(update={"start": at(shape.start), "end": at(shape.end)})
    if isinstance(shape, Box):
        now = measures(shape)
        more = standing(shape)
        return rectangle(at(anchor(shape)), now["width"], now["depth"], degrees, **more)
    if isinstance(shape, Union):
        parts = tuple(turned(part, degrees, about) for part in shape.parts)
        return shape.model_copy(update={"parts": parts})
    changed: dict[str, Any] = {"centre": at(shape.centre)}
    if isinstance(shape, CShape):
        changed["opening"] = (shape.opening + degrees) % 360.0
    return shape.model_copy(update=changed)


def scaled(shape: Any, factor: float, about: Sequence[float]) -> Any:
    """The obstacle made larger or smaller on the plan, about a point; heights stay."""

    def at(point: Sequence[float]) -> tuple[float, ...]:
        flat = (about[k] + factor * (point[k] - about[k]) for k in (0, 1))
        return *flat, *point[2:]

    if isinstance(shape, Polygon | Prism):
        return placed_again(shape, at)
    if isinstance(shape, Union):
        parts = tuple(scaled(part, factor, about) for part in shape.parts)
        return shape.model_copy(update={"parts": parts})
    changed: dict[str, Any] = {
        key: at(getattr(shape, key))
        for key in ("centre", "start", "end", "low", "high")
        if hasattr(shape, key)
    }
    for key in ("radius", "width", "thickness"):
        if hasattr(shape, key):
            changed[key] = factor * getattr(shape, key)
    if isinstance(shape, CShape):
        changed["size"] = (factor * shape.size[0], factor * shape.size[1])
    return shape.model_copy(update=changed)


def placed_again(shape: Polygon | Prism, at: Any) -> Any:
    """A polygon with all its corners sent elsewhere."""
    holes = tuple(tuple(at(point) for point in hole) for hole in shape.holes)
    points = tuple(at(point) for point in shape.points)
    return shape.model_copy(update={"points": points, "holes": holes})


def standing(shape: Any) -> dict[str, Any]:
    """Name, bottom and top of a rectangle, as another rectangle takes them."""
    bottom, top = shape.bottom, shape.top
    if isinstance(shape, Box) and len(shape.low) == 3:
        bottom, top = shape.low[2], shape.high[2]  # type: ignore[misc]
    return {"name": shape.name, "bottom": bottom, "top": top}


def anchor(shape: Any) -> tuple[float, float]:
    """The point about which an obstacle turns, on the plan."""
    if isinstance(shape, Box):
        (x, y), (u, v) = shape.low[:2], shape.high[:2]
        return 0.5 * (x + u), 0.5 * (y + v)
    if isinstance(shape, Wall):
        (x, y), (u, v) = shape.start, shape.end
        return 0.5 * (x + u), 0.5 * (y + v)
    if isinstance(shape, Disc | Ring | CShape | Sphere):
        return shape.centre[0], shape.centre[1]
    middle = shapely.centroid(shape.footprint())
    return float(middle.x), float(middle.y)


def middle(shape: Any, world: World) -> float:
    """The height at which an obstacle is taken hold of, length."""
    if isinstance(shape, Sphere):
        return shape.centre[2]
    tops = [world.height if top is None else top for _, _, top in shape.spans()]
    return max(tops, default=0.0)


def extent(shape: Any) -> float:
    """The longer side of an obstacle's bounds on the plan, length."""
    x, y, u, v = shape.footprint().bounds
    return float(max(u - x, v - y))


def demand_fitting(shape: Any, world: World) -> None:
    """Raise Refusal if a drawn obstacle is too small or too large for its world."""
    side = max(world.size)
    for name, value in measures(shape).items():
        if name in MEASURES and not LEAST * side <= value <= MOST * side:
            raise Refusal(
                f"{name} = {value:g} is not allowed: from {LEAST * side:g} to {MOST * side:g} in "
                "this world"
            )
