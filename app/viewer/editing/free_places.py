"""Agents that an obstacle has come upon: each is put on the nearest free place."""

from __future__ import annotations

import math

import numpy as np
import shapely

from worlds.input_error import InputError
from worlds.queries.clearance import clearance
from worlds.queries.outlines import outlines, shifts
from worlds.world import World

GAP = 1e-3
"""Distance to what is solid of an agent that was put out of it, as a share of the longest side."""
RAYS = 96
"""Directions in which a way out is sought in three dimensions."""
SHELLS = 48
"""Distances at which it is looked for along each ray, before the edge is found by halving."""
BATCH = 256
"""Agents for which it is sought at a time."""
HALVINGS = 12


def move_out(world: World, position: np.ndarray) -> np.ndarray:
    """Positions (N, dim), those inside an obstacle or beyond a solid edge put outside of it.

    In the plane this is the nearest free place, GAP from what is solid; in space the nearest along
    one of RAYS directions. No two of them are put on the same spot. The others stay where they
    are. Raises InputError if there is no free place.
    """
    if not world.is_solid or not len(position):
        return position
    inside = is_inside(world, position)
    if not inside.any():
        return position
    freed = position.copy()
    find = nearest_on_plan if world.dim == 2 else nearest_in_space
    freed[inside] = find(world, position[inside])
    wraps, size = world.wraps, np.array(world.size)
    return np.where(wraps & inside[:, None], np.mod(freed, size), freed)


def is_inside(world: World, position: np.ndarray) -> np.ndarray:
    """Which positions (N, dim) are in an obstacle or beyond a solid edge, (N,) bool."""
    if world.dim == 3:
        return clearance(world, position) <= 0.0
    solid = np.array([edge == "solid" for edge in world.edges])
    low, high = np.array(world.low), np.array(world.low) + world.size
    inside = (((position <= low) | (position >= high)) & solid).any(axis=1)
    solids = [
        outline if by == (0.0, 0.0) else shapely.transform(outline, lambda at, by=by: at + by)
        for obstacle in world.obstacles
        for outline, _, _ in obstacle.spans()
        for by in [shift[:2] for shift in shifts(world)]
    ]
    # One by one: to unite them would take longer than anything else here.
    tree = shapely.STRtree(shapely.points(position))
    inside[tree.query(solids, predicate="covers")[1]] = True
    return inside


def nearest_on_plan(world: World, position: np.ndarray) -> np.ndarray:
    """The nearest free places to (M, 2). Raises InputError."""
    gap = GAP * max(world.size)
    free, places = free_area(world, gap), shapely.points(position)
    place = nearest_in_area(free, places, world)
    for attempt in range(1, len(position) + 1):
        again = is_repeated(place)
        if not again.any():
            return place
        # Several in one corner: all but the first go a little farther out.
        place[again] = nearest_in_area(
            free_area(world, gap * (1.0 + attempt)), places[again], world
        )
    return place


def free_area(world: World, gap: float) -> shapely.Geometry:
    """Where agents may be: at least `gap` from all that is solid."""
    low, high = np.array(world.low), np.array(world.low) + world.size
    solids = shapely.union_all(list(outlines(world, math.inf).values()))
    reach = np.array(world.size)
    if not solids.is_empty:
        x, y, u, v = solids.bounds
        reach = reach + np.maximum(low - (x, y), np.array((u, v)) - high).clip(0.0)
    room = np.array(
        [
            {"solid": -gap, "wrap": 0.5 * side, "open": far + gap}[edge]
            for edge, side, far in zip(world.edges, world.size, reach, strict=True)
        ]
    )
    low, high = low - room, high + room
    if (low >= high).any():
        return shapely.Polygon()
    return shapely.box(*low, *high).difference(shapely.buffer(solids, gap))


def nearest_in_area(free: shapely.Geometry, places: np.ndarray, world: World) -> np.ndarray:
    """The points of an area nearest to places, (M, 2). Raises InputError if there is no area."""
    if free.is_empty:
        raise InputError(f"no free place would be left for the agents in {world.name}")
    lines = shapely.shortest_line(places, free)
    return shapely.get_coordinates(lines)[1::2]


def is_repeated(position: np.ndarray) -> np.ndarray:
    """Rows (M, dim) that say what an earlier row says, (M,) bool."""
    _, first = np.unique(position, axis=0, return_index=True)
    again = np.ones(len(position), bool)
    again[first] = False
    return again


def nearest_in_space(world: World, position: np.ndarray) -> np.ndarray:
    """Free places near (M, 3), each the nearest along a ray. Raises InputError."""
    parts = [
        nearest_along_rays(world, position[first : first + BATCH], first)
        for first in range(0, len(position), BATCH)
    ]
    return np.concatenate(parts)


def nearest_along_rays(world: World, position: np.ndarray, number: int) -> np.ndarray:
    """The nearest free places along RAYS directions, (M, 3), for rows from `number` on.

    No two rows have the same rays, so that no two come out on the same spot.
    """
    ways = np.array([directions(RAYS, number + row) for row in range(len(position))])
    gap = GAP * max(world.size)
    reach = 2.0 * (max(world.size) + float(np.abs(position - world.low).max()))

    def is_free(distance: np.ndarray) -> np.ndarray:
        """Whether the places at distances (M, R) along the rays are free."""
        places = position[:, None] + distance[..., None] * ways
        return (clearance(world, places.reshape(-1, 3)) > gap).reshape(distance.shape)

    low, high = np.zeros(ways.shape[:2]), np.full(ways.shape[:2], np.inf)
    before = 0.0
    for far in np.geomspace(gap, reach, SHELLS):
        out = is_free(np.full(low.shape, far)) & np.isinf(high).all(axis=1)[:, None]
        low[out], high[out], before = before, far, far
        if np.isfinite(high).any(axis=1).all():
            break
    else:
        raise InputError(f"no free place would be left for the agents in {world.name}")
    for _ in range(HALVINGS):
        middle = np.where(np.isfinite(high), 0.5 * (low + high), 0.0)
        out = is_free(middle) & np.isfinite(high)
        low, high = np.where(out, low, middle), np.where(out, middle, high)
    rows, first = np.arange(len(position)), np.argmin(high, axis=1)
    return position + high[rows, first][:, None] * ways[rows, first]


def directions(count: int, turn: int) -> np.ndarray:
    """Unit vectors spread evenly over the sphere, the axes first, (count + 6, 3)."""
    rank = np.arange(count) + 0.5
    rise = 1.0 - 2.0 * rank / count
    azimuth = np.pi * (1.0 + math.sqrt(5.0)) * rank + turn
    flat = np.sqrt(1.0 - rise**2)
    even = np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), rise])
    return np.concatenate([np.eye(3), -np.eye(3), even])


# What a click in the picture means: a place on the floor, or an obstacle.
#
# Rays are in the world's units, in three coordinates: origin (3,) and direction (3,).

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
    hits = [
        (distance_to_obstacle(world, obstacle, origin, way, height), number)
        for number, obstacle in enumerate(world.obstacles)
    ]
    distance, number = min(hits, default=(np.inf, 0))
    return number if np.isfinite(distance) else None


def distance_to_obstacle(
    world: World, obstacle, origin: np.ndarray, way: np.ndarray, height: float
) -> float:
    """Distance along a ray (unit `way`) to an obstacle; inf if it passes by."""
    nearest = np.inf
    for outline, bottom, top in obstacle.spans():
        low, high = 0.0, height
        if world.dim == 3:
            low = 0.0 if bottom is None else bottom
            high = world.height if top is None else top
        nearest = min(nearest, distance_to_prism(outline, low, high, origin, way))
    for centre, radius in obstacle.spheres():
        away = np.array(centre) - origin
        along = float(away @ way)
        aside = float(away @ away) - along**2
        if along > 0.0 and aside <= radius**2:
            nearest = min(nearest, along - np.sqrt(radius**2 - aside))
    return nearest


def distance_to_prism(
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
