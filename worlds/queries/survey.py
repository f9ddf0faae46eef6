"""Turns a world into `Surroundings`: edges, cells and points that compiled code can query."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import shapely

from worlds.mission import Goal, Mission
from worlds.queries.boundary import boundary_points, sorted_points
from worlds.queries.listing import Chunks, list_solids
from worlds.queries.outlines import outlines, spheres
from worlds.queries.surroundings import Surroundings
from worlds.refusal import Refusal
from worlds.world import World

SMOOTH = np.cos(np.radians(20.0))
"""Cosine of the least turn at a corner; where an outline turns less it is part of a curve."""
CHUNK = 4
"""Most edges of one outline that are listed together."""


class Edges(NamedTuple):
    """The edges of all outlines, see `worlds.queries.surroundings.Surroundings`."""

    edge: np.ndarray
    corner: np.ndarray
    after: np.ndarray
    chunks: Chunks


KEPT = 16
"""Surroundings that are kept for flocks that are made in the same world."""


def survey(world: World, reach: float) -> Surroundings:
    """The surroundings of a world, for queries up to a distance `reach` (length) from a surface.

    Equal worlds share all arrays but that of the goal, which moves. Raises Refusal for an obstacle
    whose outline crosses itself, and for a world that has not drawn its random obstacles.
    """
    kept = surveyed(world, float(reach))
    return kept._replace(goal=kept.goal.copy())


@lru_cache(KEPT)
def surveyed(world: World, reach: float) -> Surroundings:
    """What `survey` finds."""
    if world.random is not None:
        raise Refusal(
            f"the random obstacles of {world.name} are not drawn: worlds.generators.drawn"
        )
    united = outlines(world, reach)
    solids: list[shapely.Polygon] = []
    spans: list[tuple[float, float]] = []
    for span, outline in united.items():
        parts = shapely.get_parts(shapely.orient_polygons(outline))
        solids.extend(parts)
        spans.extend([span] * len(parts))
    ball = np.array([(*centre, r) for centre, r in spheres(world, reach)]).reshape(-1, 4)
    edges = outline_edges(solids)
    plane = solid_planes(world)
    points = np.empty((0, 2))
    if world.dim == 2:
        points = boundary_points(world, list(united.values()), reach)
    mission = world.mission or Mission()
    return Surroundings(
        reach,
        len(edges.edge) + len(ball) + len(plane),
        plane,
        np.array(spans, float).reshape(-1, 2),
        ball,
        edges.edge,
        edges.corner,
        edges.after,
        *list_solids(solids, ball, edges.chunks, reach),
        *sorted_points(points, reach),
        in_space(mission.path.waypoints if mission.path else ()),
        mission.path.switch if mission.path else 0.0,
        mission.path.closed if mission.path else False,
        *goal_route(mission.goal),
    )


def outline_edges(solids: list[shapely.Polygon]) -> Edges:
    """Edges with the solid on their left, corners and chunks of all rings, one after another."""
    edges, corners, afters = [], [], []
    firsts, lasts, owners = [], [], []
    first = 0
    for solid, polygon in enumerate(solids):
        for ring in (polygon.exterior, *polygon.interiors):
            edge, corner = ring_edges(shapely.get_coordinates(ring))
            n = len(edge)
            edges.append(edge)
            corners.append(corner)
            afters.append(first + np.roll(np.arange(n), -1))
            starts = np.arange(first, first + n, CHUNK)
            firsts.append(starts)
            lasts.append(np.minimum(starts + CHUNK, first + n))
            owners.append(np.full(len(starts), solid))
            first += n
    if not first:
        none = np.empty(0, np.int32)
        empty = Chunks(none, none, none, np.empty(0, object))
        return Edges(np.empty((0, 8)), np.empty((0, 3)), none, empty)
    edge = np.concatenate(edges)
    low, high = np.concatenate(firsts), np.concatenate(lasts)
    chunks = Chunks(low, high, np.concatenate(owners), chunk_lines(edge, low, high))
    after = np.concatenate(afters).astype(np.int32)
    return Edges(edge, np.concatenate(corners), after, chunks)


def ring_edges(ring: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (n, 8) and corners (n, 3) of a closed ring of points (n + 1, 2), solid on its left."""
    start, end = ring[:-1], ring[1:]
    way = end - start
    length = np.hypot(*way.T)[:, None]
    along = way / length
    normal = np.column_stack([along[:, 1], -along[:, 0]])
    before = np.roll(normal, 1, axis=0)
    smooth = (normal * before).sum(axis=1) >= SMOOTH
    # Where the outline turns right back there is no sum of normals: the way out is straight on.
    total = normal + before
    size = np.hypot(*total.T)[:, None]
    total = np.where(size > 1e-9, total / np.maximum(size, 1e-9), -along)
    return np.hstack([start, end, way / length**2, normal]), np.column_stack([total, smooth])


def chunk_lines(edge: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The chunks low to high of consecutive edges as lines, (C,) of shapely."""
    sizes = high - low + 1
    which = np.repeat(np.arange(len(low)), sizes)
    within = np.arange(len(which)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    at = low[which] + within
    ends = at == high[which]
    place = np.where(ends[:, None], edge[at - ends, 2:4], edge[np.minimum(at, len(edge) - 1), :2])
    return shapely.linestrings(place, indices=which)


def solid_planes(world: World) -> np.ndarray:
    """Solid edges of the box: unit normal into the box and offset, (P, 4)."""
    planes = []
    for axis, edge in enumerate(world.edges):
        if edge == "solid":
            normal = np.zeros(4)
            normal[axis], normal[3] = 1.0, world.low[axis]
            planes.append(normal)
            planes.append(np.append(-normal[:3], -(world.low[axis] + world.size[axis])))
    return np.array(planes).reshape(-1, 4)


def in_space(points: tuple[tuple[float, ...], ...]) -> np.ndarray:
    """Points with three coordinates, (n, 3)."""
    found = np.zeros((len(points), 3))
    for row, point in enumerate(points):
        found[row, : len(point)] = point
    return found


def goal_route(goal: Goal | None) -> tuple[np.ndarray, np.ndarray, float, bool, np.ndarray]:
    """The last five fields of the surroundings: the gamma agent's route, and where it begins."""
    route = in_space(goal.route if goal else ())
    legs = np.linalg.norm(np.diff(route, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(legs)])[: len(route)]
    now = np.zeros((2, 3))
    now[: len(route[:1])] = route[:1]
    return route, length, goal.speed if goal else 0.0, goal.closed if goal else False, now
