"""Boundary points: places along outlines, close enough to stand for the surface."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely

from worlds.queries.outlines import MOST_SWEEP, OutlineRing, Solid, distance_to_edge, edge_rows
from worlds.world import World

HIDDEN = 1e-9
"""A point deeper than this in what is solid is no surface, length."""
CENTRAL = 1e-6
"""Share of a circle's radius within which a place is its centre."""


def boundary_points(world: World, solids: list[Solid], margin: float) -> np.ndarray:
    """Points along the outlines and the solid edges of the box, (M, 2), length.

    Each part of an outline from one corner to the next is divided evenly, into steps of at most
    `world.boundary_spacing` along it, and there is a point in the middle of each step: corners are
    not among the points. With corners among them counterclockwise flocks of Wu et al. 2023 leave
    agents behind at sharp ones. A ring without corners is divided evenly from the place on it that
    is nearest to the goal, or to the centre of all outlines where the world has no goal. So the
    points turn and move with the scene, and it is all one where a ring is said to begin.

    Points beyond a solid edge are left out, and points of solid edges within an outline. Solid
    edges go on by `margin` (length) across a wrapping edge.
    """
    towards = reference_place(world, solids)
    rows = [ring_points(ring, world.boundary_spacing, towards)
             for part in solids for ring in part.rings]  # fmt: skip
    own = np.concatenate(rows) if rows else np.empty((0, 2))
    edges = np.concatenate([*box_lines(world, margin), np.empty((0, 2))])
    is_hidden = np.zeros(len(edges), bool)
    for outline in solids:
        shapely.prepare(outline.polygon)
        inner = np.flatnonzero(shapely.contains_xy(outline.polygon, *edges.T))
        rim = outline.polygon.boundary
        shapely.prepare(rim)
        is_hidden[inner] |= ~shapely.dwithin(rim, shapely.points(edges[inner]), HIDDEN)
    points = np.concatenate([own, edges[~is_hidden]])
    low = np.array(world.low)
    high = low + world.size
    inside = np.ones(len(points), bool)
    for axis, edge in enumerate(world.edges):
        if edge == "solid":
            inside &= points[:, axis] >= low[axis] - HIDDEN
            inside &= points[:, axis] <= high[axis] + HIDDEN
    return np.unique(points[inside], axis=0)


def reference_place(world: World, solids: list[Solid]) -> np.ndarray | None:
    """The place (2,) that rings without corners are divided from; None where there is none.

    Across wrapping edges the world has no such place: there an obstacle and its images are alike.
    """
    if world.wraps.any() or not solids:
        return None
    if world.mission is not None and world.mission.goal is not None:
        return np.array(world.mission.goal.route[0])
    centre = shapely.centroid(shapely.MultiPolygon([part.polygon for part in solids]))
    return np.array([centre.x, centre.y])


def ring_points(ring: OutlineRing, spacing: float, towards: np.ndarray | None) -> np.ndarray:
    """The points along a ring, (m, 2)."""
    corners = ring.corners
    starts = np.concatenate([[0.0], np.cumsum(ring.length)])
    if not len(corners):
        number = steps(starts[-1], spacing)
        return ring.at(nearest_along(ring, towards) + starts[-1] * np.arange(number) / number)
    begins = starts[corners]
    long = np.diff(np.append(begins, begins[0] + starts[-1]))
    numbers = steps(long, spacing)
    part = np.repeat(np.arange(len(corners)), numbers)
    step = np.arange(len(part)) - np.repeat(np.cumsum(numbers) - numbers, numbers)
    return ring.at(begins[part] + long[part] * (step + 0.5) / numbers[part])


def nearest_along(ring: OutlineRing, place: np.ndarray | None) -> float:
    """How far along a ring its nearest place to a place is, length.

    Where there is no such place, or all of a circle is as near, it is the furthest along x.
    """
    ring_part = ring.divided(MOST_SWEEP)
    starts = np.concatenate([[0.0], np.cumsum(ring_part.length)])
    away = math.inf if place is None else float(np.hypot(*(place - ring_part.centre).T).max())
    if place is None or away < CENTRAL * abs(ring_part.radius[0]):
        place = ring_part.start.mean(axis=0) + np.array([1e3 * starts[-1], 0.0])
    distance, share, _ = distance_to_edge(
        edge_rows(ring_part), np.broadcast_to(place, ring_part.start.shape)
    )
    k = int(np.argmin(distance))
    return float(starts[k] + share[k] * ring_part.length[k])


def steps(length: Any, spacing: float) -> Any:
    """Into how many steps of at most `spacing` lengths are divided, 1 or more."""
    return np.maximum(1, np.ceil(np.asarray(length) / spacing * (1.0 - 1e-9))).astype(int)


def box_lines(world: World, margin: float) -> list[np.ndarray]:
    """Points along the solid edges of the box, their ends among them."""
    (x, y), (u, v) = world.low, np.array(world.low) + world.size
    lines = []
    for axis, edge in enumerate(world.edges):
        start, end = np.array([x, y]), np.array([u, v])
        if world.wraps[1 - axis]:
            start[1 - axis] -= margin
            end[1 - axis] += margin
        for at in (start[axis], end[axis]) if edge == "solid" else ():
            start[axis] = end[axis] = at
            lines.append(along_line(start, end, world.boundary_spacing))
    return lines


def along_line(start: np.ndarray, end: np.ndarray, spacing: float) -> np.ndarray:
    """Points that divide a line evenly, both ends among them, (m, 2)."""
    share = np.linspace(0.0, 1.0, int(steps(math.dist(start, end), spacing)) + 1)[:, None]
    return (1.0 - share) * start + share * end


def sorted_points(
    points: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray, float, float, float, int, int, np.ndarray, int]:
    """Points (M, 2) sorted by cells of side >= reach / 2: nine fields of the surroundings.

    They are x, y, left, front, inverse, columns, rows, first point of each cell, and room for all
    that can lie within reach of any place.
    """
    if not len(points):
        return np.empty(0), np.empty(0), 0.0, 0.0, 0.0, 0, 0, np.zeros(1, np.int32), 0
    low = points.min(axis=0)
    width, depth = np.maximum(points.max(axis=0) - low, 1e-9)
    # No more than a few cells per point, and an end of a range stays in the cell it is in.
    side = max(0.5 * reach, math.sqrt(width * depth / (4.0 * len(points)))) * (1.0 + 1e-9)
    side = max(side, max(width, depth) / (4.0 * len(points) + 16.0))
    inverse = 1.0 / side
    columns, rows = int(width * inverse) + 1, int(depth * inverse) + 1
    column, row = np.floor((points - low) * inverse).astype(int).T
    cell = row * columns + column
    order = np.lexsort((points[:, 0], points[:, 1], cell))
    count = np.bincount(cell, minlength=columns * rows)
    start = np.concatenate([[0], np.cumsum(count)]).astype(np.int32)
    x, y = np.ascontiguousarray(points[order].T)
    corner = float(low[0]), float(low[1])
    most_points = fullest(count.reshape(rows, columns)) + 1
    return x, y, *corner, inverse, columns, rows, start, most_points


def fullest(count: np.ndarray) -> int:
    """The most points in any 5 x 5 cells, which hold all places within reach of their middle."""
    total = np.zeros(np.array(count.shape) + 5, np.int64)
    total[3:-2, 3:-2] = count
    total = total.cumsum(axis=0).cumsum(axis=1)
    box = total[5:, 5:] - total[:-5, 5:] - total[5:, :-5] + total[:-5, :-5]
    return int(box.max())
