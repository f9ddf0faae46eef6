"""A world as compiled code sees it: its solids, boundary points, path and goal.

`worlds.queries.survey.survey_world` makes it. Everything has three coordinates; flat worlds have
z = 0. A *solid* is one connected outline (the union of flat obstacles that overlap), one sphere or
one solid edge of the box. Queries, all compiled:

    at = nearest_surface(surroundings, x, y, z)        the nearest surface of all, a `Surface`
    at = surface_within(surroundings, x, y, z, r)      the same if it is within r: found sooner
    d = signed_distance(surroundings, x, y, z)         its distance only
    free = line_of_sight(surroundings, ax, ay, az, bx, by, bz)
    n = points_within(surroundings, x, y, r, found)    boundary points
    set_goal(surroundings, time)                       moves the goal in surroundings.goal

and one surface for each solid around, without any memory of its own:

    around = solids_around(surroundings, x, y)
    for k in range(around.number):
        at = surface(surroundings, around, k, x, y, z)
        if at.distance < math.inf:               # else it is out of surroundings.reach
            ... solid_of(surroundings, around, k)      its id, 0 to the number of solids - 1
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from worlds.compilation import compiled
from worlds.queries.sight_lines import line_of_sight
from worlds.queries.surface import (
    NearbySolids,
    Surface,
    nearest_surface,
    signed_distance,
    solid_of,
    solids_around,
    surface,
    surface_within,
)

__all__ = [
    "NearbySolids",
    "Surface",
    "Surroundings",
    "line_of_sight",
    "nearest_surface",
    "points_within",
    "set_goal",
    "signed_distance",
    "solid_of",
    "solids_around",
    "surface",
    "surface_within",
]


class Surroundings(NamedTuple):
    """A world's solids, boundary points, path and goal; arrays are C-contiguous."""

    reach: float
    """Distance up to which surfaces and boundary points are found, length."""
    solids: int
    """Number of edges, spheres and solid planes; 0 means that nothing is solid."""

    plane: np.ndarray
    """Solid edges of the box: unit normal into the box and offset, float64 (P, 4)."""
    span: np.ndarray
    """Bottom and top of each outline, infinite in two dimensions, float64 (B, 2)."""
    box: np.ndarray
    """Least x, y and largest x, y of each outline, a little wider than it is, float64 (B, 4)."""
    ball: np.ndarray
    """Centre and radius of each sphere, float64 (S, 4)."""

    edge: np.ndarray
    """Start x, y; end x, y; (end - start) / length^2; unit normal to the free side; and, of an arc,
    its circle's centre x, y and radius, < 0 where the solid is outside of it: 0 where the edge is
    straight, (E, 11). No arc turns by more than a quarter of pi."""
    corner: np.ndarray
    """Unit normal where each edge starts, and 1 if the outline is smooth there, (E, 3)."""
    after: np.ndarray
    """The edge that starts where this one ends, int32 (E,)."""

    left: float
    """Least x of the cells."""
    front: float
    """Least y of the cells."""
    inverse: float
    """Cells per length."""
    columns: int
    """Cells along x; 0 without obstacles."""
    rows: int
    """Cells along y."""
    cell_start: np.ndarray
    """First entry of each cell, rows one after another, int64 (columns * rows + 1,)."""
    entry_solid: np.ndarray
    """The solid of each entry, int32 (L,)."""
    entry_least: np.ndarray
    """A lower bound of its signed distance to any place in the cell, ascending, float64 (L,)."""
    entry_run: np.ndarray
    """First run of each entry, int64 (L + 1,)."""
    run: np.ndarray
    """First and one past the last edge of each run, int32 (R, 2)."""

    point_x: np.ndarray
    """Boundary points, sorted by cell, float64 (M,); none in three dimensions."""
    point_y: np.ndarray
    point_left: float
    point_front: float
    point_inverse: float
    point_columns: int
    point_rows: int
    point_start: np.ndarray
    """First point of each cell, int32 (point_columns * point_rows + 1,)."""
    most_points: int
    """Room that `points_within` needs: more than can lie within reach of any place."""

    path: np.ndarray
    """Waypoints of the information agents, float64 (W, 3); W = 0 without a path."""
    switch: float
    """Distance at which the next waypoint is taken, length."""
    closed: bool
    """Whether the first waypoint follows on the last."""
    route: np.ndarray
    """Waypoints of the gamma agent, float64 (G, 3); G = 0 without a goal."""
    route_length: np.ndarray
    """Length of the route up to each of them, float64 (G,)."""
    route_speed: float
    """Length per unit of time."""
    route_closed: bool
    """Whether the gamma agent goes round."""
    goal: np.ndarray
    """Position and velocity of the gamma agent now, float64 (2, 3); `set_goal` writes it."""


@compiled
def band(low, high, origin, inverse, number):
    """First cell along an axis that the interval [low, high] touches, and one past the last."""
    first = max(math.floor((low - origin) * inverse), 0.0)
    last = min(math.floor((high - origin) * inverse) + 1.0, float(number))
    return int(min(first, 2.0**30)), int(max(last, 0.0))


@compiled
def points_within(surroundings, x, y, r, rows):
    """Fill `rows` (int32) with the boundary points within r of (x, y); returns how many.

    r is at most surroundings.reach; `rows` needs room for surroundings.most_points. The points
    are (surroundings.point_x, surroundings.point_y).
    """
    if surroundings.point_x.shape[0] == 0:
        return 0
    inverse, columns = surroundings.point_inverse, surroundings.point_columns
    left, right = band(x - r, x + r, surroundings.point_left, inverse, columns)
    front, back = band(y - r, y + r, surroundings.point_front, inverse, surroundings.point_rows)
    n = 0
    if left >= right:
        return n
    for row in range(front, back):
        first = surroundings.point_start[row * columns + left]
        last = surroundings.point_start[row * columns + right]
        for k in range(first, last):
            dx, dy = surroundings.point_x[k] - x, surroundings.point_y[k] - y
            rows[n] = k
            n += 1 if dx * dx + dy * dy <= r * r else 0
    return n


@compiled
def leg_of(surroundings, k):
    """The k-th leg of the gamma agent's route: vector and length. The last leg closes it."""
    points = surroundings.route.shape[0]
    next_point = (k + 1) % points
    dx = surroundings.route[next_point, 0] - surroundings.route[k, 0]
    dy = surroundings.route[next_point, 1] - surroundings.route[k, 1]
    dz = surroundings.route[next_point, 2] - surroundings.route[k, 2]
    return dx, dy, dz, math.sqrt(dx * dx + dy * dy + dz * dz)


@compiled
def set_goal(surroundings, time):
    """Write position and velocity of the gamma agent at a time >= 0 into surroundings.goal.

    It goes along its route at constant speed and stays at the end, or goes round a closed one.
    """
    points = surroundings.route.shape[0]
    if points == 0:
        return
    travelled = surroundings.route_speed * time
    last = points - 1
    if surroundings.route_closed:
        _, _, _, back = leg_of(surroundings, last)
        total = surroundings.route_length[last] + back
        travelled = travelled - total * math.floor(travelled / total) if total > 0.0 else 0.0
    k = 0
    while k < last and travelled >= surroundings.route_length[k + 1]:
        k += 1
    dx, dy, dz, length = leg_of(surroundings, k)
    moves = (
        length > 0.0 and surroundings.route_speed > 0.0 and (k < last or surroundings.route_closed)
    )
    share = (travelled - surroundings.route_length[k]) / length if moves else 0.0
    speed = surroundings.route_speed / length if moves else 0.0
    surroundings.goal[0, 0] = surroundings.route[k, 0] + share * dx
    surroundings.goal[0, 1] = surroundings.route[k, 1] + share * dy
    surroundings.goal[0, 2] = surroundings.route[k, 2] + share * dz
    surroundings.goal[1, 0] = speed * dx
    surroundings.goal[1, 1] = speed * dy
    surroundings.goal[1, 2] = speed * dz
