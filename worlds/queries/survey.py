"""Turns a world into `Surroundings`: edges, cells and points that compiled code can query."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from worlds.input_error import InputError
from worlds.mission import Goal, Mission
from worlds.queries.arc_outlines import MOST_SWEEP, Solid, chorded, corner_rows, edge_rows
from worlds.queries.boundary import boundary_points, sorted_points
from worlds.queries.cell_listing import Chunks, list_solids
from worlds.queries.solid_outlines import solids, spheres
from worlds.queries.surroundings import Surroundings
from worlds.world import World

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

    Equal worlds share all arrays but that of the goal, which moves. Raises InputError for an
    obstacle whose outline crosses itself, and for a world that has not drawn its random obstacles.
    """
    kept = surveyed(world, float(reach))
    return kept._replace(goal=kept.goal.copy())


@lru_cache(KEPT)
def surveyed(world: World, reach: float) -> Surroundings:
    """What `survey` finds."""
    if world.random is not None:
        raise InputError(
            f"the random obstacles of {world.name} are not drawn: worlds.generators.drawn"
        )
    found = solids(world, reach)
    outlines = [one for _, parts in found for one in parts]
    spans = [span for span, parts in found for _ in parts]
    ball = np.array([(*centre, r) for centre, r in spheres(world, reach)]).reshape(-1, 4)
    edges = outline_edges(outlines)
    plane = solid_planes(world)
    points = np.empty((0, 2))
    if world.dim == 2:
        points = boundary_points(world, outlines, reach)
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
        *list_solids(
            [one.polygon for one in outlines],
            ball,
            edges.chunks,
            reach,
            max((one.slack for one in outlines), default=0.0),
        ),
        *sorted_points(points, reach),
        in_space(mission.path.waypoints if mission.path else ()),
        mission.path.switch if mission.path else 0.0,
        mission.path.closed if mission.path else False,
        *goal_route(mission.goal),
    )


def outline_edges(solids: list[Solid]) -> Edges:
    """Edges with the solid on their left, corners and chunks of all rings, one after another."""
    edges, corners, afters = [], [], []
    firsts, lasts, owners = [], [], []
    first = 0
    for solid, outline in enumerate(solids):
        for whole in outline.rings:
            ring = whole.divided(MOST_SWEEP)
            n = len(ring.start)
            edges.append(edge_rows(ring))
            corners.append(corner_rows(ring))
            afters.append(first + np.roll(np.arange(n), -1))
            starts = np.arange(first, first + n, CHUNK)
            firsts.append(starts)
            lasts.append(np.minimum(starts + CHUNK, first + n))
            owners.append(np.full(len(starts), solid))
            first += n
    if not first:
        none = np.empty(0, np.int32)
        empty = Chunks(none, none, none, np.empty(0, object))
        return Edges(np.empty((0, 11)), np.empty((0, 3)), none, empty)
    edge = np.concatenate(edges)
    low, high = np.concatenate(firsts), np.concatenate(lasts)
    chunks = Chunks(low, high, np.concatenate(owners), chorded(edge, low, high))
    after = np.concatenate(afters).astype(np.int32)
    return Edges(edge, np.concatenate(corners), after, chunks)


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
