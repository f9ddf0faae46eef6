"""Obstacles as a person draws them, and how large they may be."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from worlds.input_error import InputError
from worlds.obstacles import Disc, Polygon, obstacle
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


def polygon(points: Sequence[Sequence[float]]) -> Polygon:
    """A polygon of the corners that were clicked; a corner clicked twice counts once.

    Raises InputError for fewer than three corners or more than CORNERS.
    """
    corners = [(float(point[0]), float(point[1])) for point in points]
    previous = corners[-1:] + corners[:-1]
    kept_corners = [corner for corner, before in zip(corners, previous, strict=True)
            if corner != before]  # fmt: skip
    if len(kept_corners) < 3:
        raise InputError(f"a polygon needs 3 corners or more, {len(kept_corners)} were given")
    if len(kept_corners) > CORNERS:
        raise InputError(f"a polygon has {CORNERS} corners at most, {len(kept_corners)} were given")
    return obstacle({"shape": "polygon", "points": kept_corners})


def demand_fitting(shape: Any, world: World) -> None:
    """Raise InputError if a drawn obstacle is too small or too large for its world."""
    side = max(world.size)
    for name, value in shape.measures().items():
        if name in MEASURES and not LEAST * side <= value <= MOST * side:
            raise InputError(
                f"{name} = {value:g} is not allowed: from {LEAST * side:g} to {MOST * side:g} in "
                "this world"
            )
