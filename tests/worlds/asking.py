"""The compiled queries of a surroundings, for many places at once."""

import numpy as np

from agents.engine.cache import compile_to_disk
from worlds.queries.surroundings import (
    line_of_sight,
    nearest_surface,
    points_within,
    set_goal,
    signed_distance,
    solid_of,
    solids_around,
    surface,
    surface_within,
)


@compile_to_disk
def _surfaces(surroundings, place, out):
    for i in range(place.shape[0]):
        x, y, z = place[i, 0], place[i, 1], place[i, 2]
        at = nearest_surface(surroundings, x, y, z)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = at.distance, at.x, at.y, at.z
        out[i, 4], out[i, 5], out[i, 6], out[i, 7] = at.nx, at.ny, at.nz, at.smooth
        out[i, 8] = signed_distance(surroundings, x, y, z)


@compile_to_disk
def _surfaces_within(surroundings, place, r, out):
    for i in range(place.shape[0]):
        at = surface_within(surroundings, place[i, 0], place[i, 1], place[i, 2], r)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = at.distance, at.x, at.y, at.z
        out[i, 4], out[i, 5], out[i, 6], out[i, 7] = at.nx, at.ny, at.nz, at.smooth


@compile_to_disk
def _each(surroundings, place, out):
    for i in range(place.shape[0]):
        x, y, z = place[i, 0], place[i, 1], place[i, 2]
        around = solids_around(surroundings, x, y)
        for k in range(around.number):
            at = surface(surroundings, around, k, x, y, z)
            solid = solid_of(surroundings, around, k)
            out[i, solid, 0], out[i, solid, 1] = at.distance, at.x
            out[i, solid, 2], out[i, solid, 3] = at.y, at.z
            out[i, solid, 4] += 1.0


@compile_to_disk
def _sights(surroundings, start, end, out):
    for i in range(start.shape[0]):
        out[i] = line_of_sight(
            surroundings, start[i, 0], start[i, 1], start[i, 2], end[i, 0], end[i, 1], end[i, 2]
        )


@compile_to_disk
def _points(surroundings, x, y, r, found):
    return points_within(surroundings, x, y, r, found)


@compile_to_disk
def _goal(surroundings, time):
    set_goal(surroundings, time)


def in_space(place):
    """Places (N, 2) or (N, 3) with three coordinates, float64 (N, 3)."""
    place = np.atleast_2d(np.asarray(place, float))
    return np.hstack([place, np.zeros((len(place), 3 - place.shape[1]))])


class Answer:
    """What `nearest_surface` and `signed_distance` say; rows are places."""

    def __init__(self, surroundings, place):
        place = in_space(place)
        out = np.empty((len(place), 9))
        _surfaces(surroundings, place, out)
        self.distance, self.smooth, self.signed = out[:, 0], out[:, 7], out[:, 8]
        self.point, self.normal = out[:, 1:4], out[:, 4:7]


def surfaces_within(surroundings, place, r):
    """What `surface_within` says: distance, point, normal, whether it is smooth; (N, 8)."""
    place = in_space(place)
    out = np.empty((len(place), 8))
    _surfaces_within(surroundings, place, r, out)
    return out


def each_solid(surroundings, place, solids):
    """For each place and solid: distance (inf where none), x, y, z, how often; (N, solids, 5)."""
    place = in_space(place)
    out = np.zeros((len(place), solids, 5))
    out[:, :, 0] = np.inf
    _each(surroundings, place, out)
    return out


def sights(surroundings, start, end):
    """Whether each end is seen from its start, (N,) bool."""
    start, end = in_space(start), in_space(end)
    out = np.empty(len(start), bool)
    _sights(surroundings, start, end, out)
    return out


def within(surroundings, x, y, r):
    """Indices of the boundary points within r of a place."""
    found = np.full(surroundings.most_points, -1, np.int32)
    return found[: _points(surroundings, x, y, r, found)]


def goal_at(surroundings, time):
    """Position and velocity of the gamma agent, (2, 3)."""
    _goal(surroundings, time)
    return surroundings.goal.copy()
