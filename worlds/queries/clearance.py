"""How far places are from everything solid, for whole arrays of places, by shapely."""

from __future__ import annotations

import math

import numpy as np
import shapely

from worlds.queries.outlines import footprints, outlines, spheres
from worlds.world import World

__all__ = ["clearance", "footprints"]


def clearance(world: World, position: np.ndarray) -> np.ndarray:
    """Signed distance of each place to the nearest solid surface, (N, dim) -> (N,), length.

    Negative inside an obstacle or beyond a solid edge, inf in a world where nothing is solid. Where
    solids overlap, the depth inside is that of the deepest one, a lower bound of the union's.
    Obstacles are seen across wrapping edges.
    """
    position = np.asarray(position, float)
    least = np.full(len(position), np.inf)
    for axis, edge in enumerate(world.edges):
        if edge == "solid":
            up = position[:, axis] - world.low[axis]
            least = np.minimum(least, np.minimum(up, world.size[axis] - up))
    for (bottom, top), outline in outlines(world, math.inf).items():
        flat = plan_distance(outline, position[:, :2])
        if world.dim == 3:
            above = np.maximum(bottom - position[:, 2], position[:, 2] - top)
            outside = np.hypot(np.maximum(flat, 0.0), np.maximum(above, 0.0))
            flat = np.where(outside > 0.0, outside, np.maximum(flat, above))
        least = np.minimum(least, flat)
    for centre, radius in spheres(world, math.inf):
        away = np.linalg.norm(position - np.array(centre), axis=1) - radius
        least = np.minimum(least, away)
    return least


def plan_distance(outline: shapely.Geometry, position: np.ndarray) -> np.ndarray:
    """Signed distance of places in the plane (N, 2) to an outline, negative inside, (N,)."""
    shapely.prepare(outline)
    away = shapely.distance(outline.boundary, shapely.points(position))
    return np.where(shapely.contains_xy(outline, *position.T), -away, away)
