"""Boundary points: places along outlines, close enough to stand for the surface."""

from __future__ import annotations

import math

import numpy as np
import shapely

from worlds.world import World

HIDDEN = 1e-9
"""A point deeper than this in what is solid is no surface, length."""


def boundary_points(world: World, united: list[shapely.Geometry], margin: float) -> np.ndarray:
    """Points along the united outlines and the solid edges of the box, (M, 2), length.

    Each ring is divided evenly, into steps of at most `world.boundary_spacing` along it; its
    corners are not among the points. With corners among them counterclockwise flocks of Wu et al.
    2023 leave agents behind at sharp ones.
    Points that lie in a solid or beyond a solid edge are left out. Solid edges go on by `margin`
    (length) across a wrapping edge.
    """
    rings = [
        shapely.get_coordinates(ring)
        for outline in united
        for part in shapely.get_parts(shapely.orient_polygons(outline))
        for ring in (part.exterior, *part.interiors)
    ]
    found = [along_line(ring, world.boundary_spacing) for ring in rings]
    found += box_lines(world, margin)
    low = np.array(world.low)
    high = low + world.size
    points = np.concatenate(found) if found else np.empty((0, 2))
    hidden = np.zeros(len(points), bool)
    for axis, edge in enumerate(world.edges):
        if edge == "solid":
            hidden |= (points[:, axis] < low[axis] - HIDDEN) | (
                points[:, axis] > high[axis] + HIDDEN
            )
    for outline in united:
        shapely.prepare(outline)
        inner = np.flatnonzero(shapely.contains_xy(outline, *points.T))
        rim = outline.boundary
        shapely.prepare(rim)
        hidden[inner] |= ~shapely.dwithin(rim, shapely.points(points[inner]), HIDDEN)
    return np.unique(points[~hidden], axis=0)


def box_lines(world: World, margin: float) -> list[np.ndarray]:
    """Points along the solid edges of the box, each place once."""
    (x, y), (u, v) = world.low, np.array(world.low) + world.size
    if world.edges == ("solid", "solid"):
        ring = np.array([(x, y), (u, y), (u, v), (x, v), (x, y)])
        return [along_line(ring, world.boundary_spacing)]
    found = []
    for axis, edge in enumerate(world.edges):
        start, end = np.array([x, y]), np.array([u, v])
        if world.wraps[1 - axis]:
            start[1 - axis] -= margin
            end[1 - axis] += margin
        for at in (start[axis], end[axis]) if edge == "solid" else ():
            start[axis] = end[axis] = at
            line = np.array([start, end])
            found.append(np.concatenate([along_line(line, world.boundary_spacing), line[1:]]))
    return found


def along_line(line: np.ndarray, spacing: float) -> np.ndarray:
    """Points that divide a line (n, 2) evenly, its start among them but not its end, (m, 2)."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    number = max(1, math.ceil(length[-1] / spacing * (1.0 - 1e-12)))
    at = length[-1] * np.arange(number) / number
    return np.column_stack([np.interp(at, length, axis) for axis in line.T])


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
    least = float(low[0]), float(low[1])
    most = fullest(count.reshape(rows, columns)) + 1
    return x, y, *least, inverse, columns, rows, start, most


def fullest(count: np.ndarray) -> int:
    """The most points in any 5 x 5 cells, which hold all places within reach of their middle."""
    total = np.zeros(np.array(count.shape) + 5, np.int64)
    total[3:-2, 3:-2] = count
    total = total.cumsum(axis=0).cumsum(axis=1)
    box = total[5:, 5:] - total[:-5, 5:] - total[5:, :-5] + total[:-5, :-5]
    return int(box.max())
