"""Measure how far places are from everything solid, for whole arrays of places."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import shapely

from worlds.queries.outlines import (
    MOST_SWEEP,
    chord_lines,
    distance_to_edge,
    edge_rows,
    solids,
    spheres,
)
from worlds.world import World

KEPT = 16
"""Worlds whose outlines are kept."""


class Outlines(NamedTuple):
    """All outlines of one span of heights."""

    bottom: float
    top: float
    polygon: shapely.MultiPolygon
    """With chords for arcs."""
    slack: float
    """How far these may be from the arcs, length; 0 where there are none."""
    edge: np.ndarray
    """The edges, (E, 11), see `Surroundings.edge`."""
    lines: shapely.STRtree
    """Each edge as a line, with chords for arcs."""


def clearance(world: World, position: np.ndarray) -> np.ndarray:
    """Signed distance of each place to the nearest solid surface, (N, dim) -> (N,), length.

    Negative inside an obstacle or beyond a solid edge, inf in a world where nothing is solid. Where
    solids overlap, the depth inside is that of the deepest one, a lower bound of the union's.
    Obstacles are seen across wrapping edges.
    """
    position = np.asarray(position, float)
    distance = np.full(len(position), np.inf)
    for axis, edge in enumerate(world.edges):
        if edge == "solid":
            up = position[:, axis] - world.low[axis]
            distance = np.minimum(distance, np.minimum(up, world.size[axis] - up))
    for outlines in prepared_outlines(world):
        flat = plan_distance(outlines, position[:, :2])
        if world.dim == 3:
            height = np.maximum(outlines.bottom - position[:, 2], position[:, 2] - outlines.top)
            outside = np.hypot(np.maximum(flat, 0.0), np.maximum(height, 0.0))
            flat = np.where(outside > 0.0, outside, np.maximum(flat, height))
        distance = np.minimum(distance, flat)
    for centre, radius in spheres(world, math.inf):
        away = np.linalg.norm(position - np.array(centre), axis=1) - radius
        distance = np.minimum(distance, away)
    return distance


@lru_cache(KEPT)
def prepared_outlines(world: World) -> list[Outlines]:
    """The outlines of a world, with all images across wrapping edges, ready to be asked."""
    outline_sets = []
    for (bottom, top), parts in solids(world, math.inf):
        rings = [ring.divided(MOST_SWEEP) for part in parts for ring in part.rings]
        edge = np.concatenate([edge_rows(ring) for ring in rings])
        each = np.arange(len(edge))
        polygon = shapely.MultiPolygon([outline.polygon for outline in parts])
        shapely.prepare(polygon)
        lines = shapely.STRtree(chord_lines(edge, each, each + 1))
        slack = max(one.slack for one in parts)
        outline_sets.append(Outlines(bottom, top, polygon, slack, edge, lines))
    return outline_sets


def plan_distance(outlines: Outlines, position: np.ndarray) -> np.ndarray:
    """Signed distance of places in the plane (N, 2) to outlines, negative inside, (N,).

    What can be nearest is looked for among chords; then the arcs themselves are asked.
    """
    place = shapely.points(position)
    away = shapely.distance(outlines.polygon.boundary, place)
    sign = np.where(shapely.contains_xy(outlines.polygon, *position.T), -1.0, 1.0)
    if outlines.slack == 0.0:
        return sign * away
    row, edge = outlines.lines.query(
        place, predicate="dwithin", distance=away + 2.0 * outlines.slack
    )
    exact, _, side = distance_to_edge(outlines.edge[edge], position[row])
    order = np.lexsort((exact, row))
    first = order[np.unique(row[order], return_index=True)[1]]
    away[row[first]] = exact[first]
    return np.where(side[first] != 0.0, side[first], sign[row[first]]) * away[row[first]]
