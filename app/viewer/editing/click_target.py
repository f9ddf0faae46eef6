"""What a click in the picture means: a place on the floor, or an obstacle.

Rays are in the world's units, in three coordinates: origin (3,) and direction (3,).
"""

from __future__ import annotations

import numpy as np
import shapely

from worlds.world import World

LEVELS = 64
"""Heights at which a ray is looked at between top and bottom of an obstacle."""


def floor_place(world: World, origin: np.ndarray, direction: np.ndarray) -> np.ndarray | None:
    """Where a ray meets the floor, (2,); None if it does not."""
    floor = world.low[2] if world.dim == 3 else 0.0
    if not (np.isfinite(origin).all() and np.isfinite(direction).all()) or direction[2] == 0.0:
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        share = (floor - origin[2]) / direction[2]
        place = origin[:2] + share * direction[:2]
    return place if share > 0.0 and np.isfinite(place).all() else None


def obstacle_hit(
    world: World, origin: np.ndarray, direction: np.ndarray, height: float
) -> int | None:
    """The place in `world.obstacles` of the first obstacle that a ray meets; None if none.

    `height` is how tall obstacles of a flat world are drawn, length.
    """
    if not (np.isfinite(origin).all() and np.isfinite(direction).all()):
        return None
    size = float(np.linalg.norm(direction))
    if size == 0.0:
        return None
    way = direction / size
    found = [
        (first_meeting(world, one, origin, way, height), number)
        for number, one in enumerate(world.obstacles)
    ]
    distance, number = min(found, default=(np.inf, 0))
    return number if np.isfinite(distance) else None


def first_meeting(
    world: World, obstacle, origin: np.ndarray, way: np.ndarray, height: float
) -> float:
    """Distance along a ray (unit `way`) to an obstacle; inf if it passes by."""
    nearest = np.inf
    for outline, bottom, top in obstacle.spans():
        low, high = 0.0, height
        if world.dim == 3:
            low = 0.0 if bottom is None else bottom
            high = world.height if top is None else top
        nearest = min(nearest, meets_prism(outline, low, high, origin, way))
    for centre, radius in obstacle.spheres():
        away = np.array(centre) - origin
        along = float(away @ way)
        aside = float(away @ away) - along**2
        if along > 0.0 and aside <= radius**2:
            nearest = min(nearest, along - np.sqrt(radius**2 - aside))
    return nearest


def meets_prism(
    outline: shapely.Polygon, low: float, high: float, origin: np.ndarray, way: np.ndarray
) -> float:
    """Distance along a ray to an upright solid, to about one level in LEVELS; inf if it passes."""
    if abs(way[2]) < 1e-9:
        return level_meeting(outline, low, high, origin, way)
    distance = (np.linspace(low, high, LEVELS) - origin[2]) / way[2]
    at = origin[:2] + distance[:, None] * way[:2]
    inside = shapely.contains_xy(outline, *at.T) & (distance > 0.0)
    return float(distance[inside].min(initial=np.inf))


def level_meeting(
    outline: shapely.Polygon, low: float, high: float, origin: np.ndarray, way: np.ndarray
) -> float:
    """The same for a level ray, exactly."""
    flat = float(np.hypot(way[0], way[1]))
    if not low <= origin[2] <= high or flat == 0.0:
        return np.inf
    x, y, u, v = outline.bounds
    far = abs(x - origin[0]) + abs(u - origin[0]) + abs(y - origin[1]) + abs(v - origin[1])
    line = shapely.linestrings([origin[:2], origin[:2] + far * way[:2] / flat])
    return float(shapely.distance(shapely.points(origin[:2]), shapely.intersection(line, outline))
                 if shapely.intersects(line, outline) else np.inf)  # fmt: skip
