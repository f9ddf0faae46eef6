"""Turn a world into `Surroundings`: edges, cells and points that compiled code can query."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import shapely

from worlds.input_error import InputError
from worlds.mission import Goal, Mission
from worlds.queries.boundary import boundary_points, sorted_points
from worlds.queries.outlines import (
    MOST_SWEEP,
    Solid,
    chord_lines,
    corner_rows,
    edge_rows,
    solids,
    spheres,
)
from worlds.queries.surroundings import Surroundings
from worlds.world import World

# Which solids, and which of their edges, can be nearest to a place in each cell of the plan.

CELLS_PER_CHUNK = 32
CELLS_PER_BALL = 64
MOST_CELLS = 2**15
LEAST_CELLS = 2**8
MOST_ENTRIES = 2**16
"""About how many solids all cells together may list."""
WIDER = 1.0 + 1e-6
"""Cells are taken larger by this factor, so that rounding never hides an edge."""

BOX_MARGIN = 1e-9
"""By how much boxes of outlines are wider, for each unit of length that they reach out."""


class Chunks(NamedTuple):
    """Runs of consecutive edges of one outline that are listed together, (C,) each."""

    first: np.ndarray
    last: np.ndarray
    """One past the last edge."""
    solid: np.ndarray
    """The outline that they belong to, ascending."""
    line: np.ndarray
    """The edges as a shapely line."""


class Listing(NamedTuple):
    """The cells of the surroundings, see `worlds.queries.surroundings.Surroundings`."""

    left: float
    front: float
    inverse: float
    columns: int
    rows: int
    cell_start: np.ndarray
    entry_solid: np.ndarray
    entry_least: np.ndarray
    entry_run: np.ndarray
    run: np.ndarray


class Cells(NamedTuple):
    """Square cells over the plan."""

    left: float
    front: float
    side: float
    columns: int
    rows: int

    @property
    def half(self) -> float:
        """Half a cell's diagonal."""
        return self.side * math.sqrt(0.5) * WIDER

    def centres(self) -> np.ndarray:
        """The cells' centres, row after row, (columns * rows, 2)."""
        x = self.left + (np.arange(self.columns) + 0.5) * self.side
        y = self.front + (np.arange(self.rows) + 0.5) * self.side
        return np.column_stack([np.tile(x, self.rows), np.repeat(y, self.columns)])


class Pairs(NamedTuple):
    """Cells and the solids listed in them, (L,) each."""

    cell: np.ndarray
    solid: np.ndarray
    least: np.ndarray
    """Lower bound of the solid's signed distance to any place in the cell."""


def list_solids(
    solids: list[shapely.Polygon], ball: np.ndarray, chunks: Chunks, reach: float, slack: float
) -> Listing:
    """List outlines, and spheres (S, 4) after them, in the cells within `reach` of them.

    With d the distance from a cell's centre to a solid and h half its diagonal, all edges of the
    solid within d + 2 h are listed: no other can be nearest to a place in the cell. Polygons and
    chunks may be up to `slack` (length) away from the outlines that they stand for.
    """
    nothing = np.empty(0, np.int32)
    if not solids and not len(ball):
        start = np.zeros(1, np.int64)
        return Listing(
            0.0, 0.0, 0.0, 0, 0, start, nothing, np.empty(0), start.copy(), nothing.reshape(0, 2)
        )
    outlines = np.array(solids, object)
    cells = lay_cells(outlines, ball, len(chunks.first), reach)
    centres = shapely.points(cells.centres())
    tree = shapely.STRtree(centres)
    flat, hits = near_outlines(tree, outlines, chunks, cells, reach, slack)
    round_ = near_balls(tree, ball, len(solids), cells, reach)
    cell, solid, least_distance = (
        np.concatenate(parts) for parts in zip(flat, round_, strict=True)
    )
    order = np.lexsort((solid, least_distance, cell))
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    owner, run = runs(rank[hits[0]], hits[1], chunks)
    number = cells.columns * cells.rows
    return Listing(
        cells.left,
        cells.front,
        1.0 / cells.side,
        cells.columns,
        cells.rows,
        starts(cell, number),
        solid[order].astype(np.int32),
        np.ascontiguousarray(least_distance[order]),
        starts(owner, len(order)),
        run,
    )


def lay_cells(outlines: np.ndarray, ball: np.ndarray, chunks: int, reach: float) -> Cells:
    """Square cells over all places within reach of a solid, more of them where there are more."""
    round_ = np.column_stack([ball[:, :2] - ball[:, 3:], ball[:, :2] + ball[:, 3:]])
    bounds = np.concatenate([shapely.bounds(outlines).reshape(-1, 4), round_])
    bounds += np.array([-reach, -reach, reach, reach]) * WIDER
    low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    width, depth = high - low
    each = (bounds[:, 2:] - bounds[:, :2]).prod(axis=1).sum() / (width * depth)
    number = CELLS_PER_CHUNK * chunks + CELLS_PER_BALL * len(ball)
    number = min(max(number, LEAST_CELLS), MOST_CELLS, max(MOST_ENTRIES / each, LEAST_CELLS))
    side = max(math.sqrt(width * depth / number), max(width, depth) / number)
    columns, rows = max(1, math.ceil(width / side)), max(1, math.ceil(depth / side))
    return Cells(float(low[0]), float(low[1]), float(side), columns, rows)


def near_outlines(
    tree: shapely.STRtree,
    outlines: np.ndarray,
    chunks: Chunks,
    cells: Cells,
    reach: float,
    slack: float,
) -> tuple[Pairs, tuple[np.ndarray, np.ndarray]]:
    """The outlines within reach of each cell; and pairs of (one of these, chunk to look at)."""
    half = cells.half
    shapely.prepare(outlines)
    solid, cell = tree.query(outlines, predicate="dwithin", distance=reach + half + slack)
    order = np.argsort(solid, kind="stable")
    solid, cell = solid[order], cell[order]
    centre = tree.geometries[cell]
    first = np.searchsorted(chunks.solid, np.arange(len(outlines) + 1))
    number = np.diff(first)
    single = np.flatnonzero(number[solid] == 1)
    away = np.empty(len(solid))
    away[single] = shapely.distance(chunks.line[first[solid[single]]], centre[single])
    listed = [(single, first[solid[single]])]
    of_solid = np.searchsorted(solid, np.arange(len(outlines) + 1))
    for body in np.flatnonzero(number > 1):
        rows = slice(of_solid[body], of_solid[body + 1])
        own = shapely.STRtree(chunks.line[first[body] : first[body + 1]])
        (cell_row, _), distance = own.query_nearest(
            centre[rows], return_distance=True, all_matches=False
        )
        away[rows][cell_row] = distance
        reach_of_cell = away[rows] + 2.0 * (half + slack)
        cell_hit, hit = own.query(centre[rows], predicate="dwithin", distance=reach_of_cell)
        listed.append((cell_hit + rows.start, hit + first[body]))
    inside = shapely.intersects(outlines[solid], centre)
    least_distance = np.where(inside, -away, away) - half - slack
    cell_hit, hit = (np.concatenate(column) for column in zip(*listed, strict=True))
    return Pairs(cell, solid, least_distance), (cell_hit, hit)


def near_balls(
    tree: shapely.STRtree, ball: np.ndarray, first: int, cells: Cells, reach: float
) -> Pairs:
    """The spheres within reach of each cell of the plan; they are numbered from `first` on."""
    middle = shapely.points(ball[:, :2])
    reach_of_ball = ball[:, 3] + reach + cells.half
    ball_hit, cell = tree.query(middle, predicate="dwithin", distance=reach_of_ball)
    away = shapely.distance(middle[ball_hit], tree.geometries[cell]) - ball[ball_hit, 3]
    return Pairs(cell, ball_hit + first, away - cells.half)


def runs(owner: np.ndarray, chunk: np.ndarray, chunks: Chunks) -> tuple[np.ndarray, np.ndarray]:
    """The edges of listed chunks as runs, chunks that follow each other joined.

    Returns the owner of each run, ascending, and its first and one past its last edge, (R, 2).
    """
    order = np.lexsort((chunk, owner))
    owner, chunk = owner[order], chunk[order]
    new = np.ones(len(owner), bool)
    new[1:] = (owner[1:] != owner[:-1]) | (chunk[1:] != chunk[:-1] + 1)
    first = np.flatnonzero(new)
    last = np.append(first[1:], len(owner))[: len(first)] - 1
    edges = np.column_stack([chunks.first[chunk[first]], chunks.last[chunk[last]]])
    return owner[first], np.ascontiguousarray(edges, np.int32).reshape(-1, 2)


def starts(owner: np.ndarray, number: int) -> np.ndarray:
    """Where the rows of each of `number` owners begin when sorted by owner, int64 (number + 1,)."""
    count = np.bincount(owner, minlength=number)
    return np.concatenate([[0], np.cumsum(count)]).astype(np.int64)


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


def survey_world(world: World, reach: float) -> Surroundings:
    """The surroundings of a world, for queries up to a distance `reach` (length) from a surface.

    Equal worlds share all arrays but that of the goal, which moves. Raises InputError for an
    obstacle whose outline crosses itself, and for a world that has not drawn its random obstacles.
    """
    surveys = build_surroundings(world, float(reach))
    return surveys._replace(goal=surveys.goal.copy())


@lru_cache(KEPT)
def build_surroundings(world: World, reach: float) -> Surroundings:
    """Build the surroundings of a world; `survey_world` keeps them for the next who asks."""
    if world.random is not None:
        raise InputError(
            f"the random obstacles of {world.name} are not drawn: worlds.generators.draw_obstacles"
        )
    solid_parts = solids(world, reach)
    outlines = [part for _, parts in solid_parts for part in parts]
    spans = [span for span, parts in solid_parts for _ in parts]
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
        outline_boxes(outlines),
        ball,
        edges.edge,
        edges.corner,
        edges.after,
        *list_solids(
            [outline.polygon for outline in outlines],
            ball,
            edges.chunks,
            reach,
            max((one.slack for one in outlines), default=0.0),
        ),
        *sorted_points(points, reach),
        pad_to_space(mission.path.waypoints if mission.path else ()),
        mission.path.switch if mission.path else 0.0,
        mission.path.closed if mission.path else False,
        *goal_route(mission.goal),
    )


def outline_boxes(outlines: list[Solid]) -> np.ndarray:
    """Least x, y and largest x, y of each outline, wider by more than rounding is, (B, 4)."""
    boxes = shapely.bounds([outline.polygon for outline in outlines]).reshape(-1, 4)
    slack = np.array([outline.slack for outline in outlines]).reshape(-1, 1)
    margin = slack + BOX_MARGIN * (1.0 + np.abs(boxes).max(axis=1, initial=0.0, keepdims=True))
    return boxes + margin * np.array([-1.0, -1.0, 1.0, 1.0])


def outline_edges(solids: list[Solid]) -> Edges:
    """Edges with the solid on their left, corners and chunks of all rings, one after another."""
    edges, corners, following_edges = [], [], []
    firsts, lasts, owners = [], [], []
    first = 0
    for solid, outline in enumerate(solids):
        for outline_ring in outline.rings:
            ring = outline_ring.divided(MOST_SWEEP)
            n = len(ring.start)
            edges.append(edge_rows(ring))
            corners.append(corner_rows(ring))
            following_edges.append(first + np.roll(np.arange(n), -1))
            starts = np.arange(first, first + n, CHUNK)
            firsts.append(starts)
            lasts.append(np.minimum(starts + CHUNK, first + n))
            owners.append(np.full(len(starts), solid))
            first += n
    if not first:
        none = np.empty(0, np.int32)
        no_chunks = Chunks(none, none, none, np.empty(0, object))
        return Edges(np.empty((0, 11)), np.empty((0, 3)), none, no_chunks)
    edge = np.concatenate(edges)
    low, high = np.concatenate(firsts), np.concatenate(lasts)
    chunks = Chunks(low, high, np.concatenate(owners), chord_lines(edge, low, high))
    after = np.concatenate(following_edges).astype(np.int32)
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


def pad_to_space(points: tuple[tuple[float, ...], ...]) -> np.ndarray:
    """Points with three coordinates, (n, 3)."""
    padded = np.zeros((len(points), 3))
    for row, point in enumerate(points):
        padded[row, : len(point)] = point
    return padded


def goal_route(goal: Goal | None) -> tuple[np.ndarray, np.ndarray, float, bool, np.ndarray]:
    """The last five fields of the surroundings: the gamma agent's route, and where it begins."""
    route = pad_to_space(goal.route if goal else ())
    legs = np.linalg.norm(np.diff(route, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(legs)])[: len(route)]
    start = np.zeros((2, 3))
    start[: len(route[:1])] = route[:1]
    return route, length, goal.speed if goal else 0.0, goal.closed if goal else False, start
