"""Solids as functions of a place: signed distance and unit normal, for naive oracles.

`place` is (dim,); the distance is negative inside, the normal points away from the solid.
"""

import numpy as np
import shapely
from shapely.ops import nearest_points


def outline(geometry):
    """A flat obstacle, from its shapely outline."""

    def at(place):
        point = shapely.Point(place)
        nearest = nearest_points(geometry.boundary, point)[0]
        away = np.asarray(place) - np.array([nearest.x, nearest.y])
        d = np.linalg.norm(away)
        return (-d, -away / d) if geometry.contains(point) else (d, away / d)

    return at


def flat(obstacle):
    """A flat obstacle of `worlds.obstacles` that touches no other."""
    if obstacle.shape == "disc":
        return sphere(obstacle.centre, obstacle.radius)
    return outline(obstacle.footprint())


def sphere(centre, radius):
    """A ball, or a disc that is truly round."""

    def at(place):
        away = np.asarray(place) - np.asarray(centre)
        d = np.linalg.norm(away)
        return d - radius, away / d

    return at


def wall(axis, where, side):
    """A plane across an axis at `where`; free on the side +1 or -1."""

    def at(place):
        normal = np.zeros(len(place))
        normal[axis] = side
        return side * (place[axis] - where), normal

    return at


def box(low, high):
    """The solid edges of a box: a wall on each side of each axis."""
    ends = [(axis, where, 1.0) for axis, where in enumerate(low)]
    ends += [(axis, where, -1.0) for axis, where in enumerate(high)]
    return [wall(*end) for end in ends]


def nearest(solids, place):
    """Distance and normal of the solid that is nearest to a place; inf without any."""
    found = [solid(place) for solid in solids]
    if not found:
        return np.inf, np.zeros(len(place))
    return min(found, key=lambda one: one[0])
