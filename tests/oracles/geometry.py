"""Signed distances to solids in space, naively, straight from their definitions."""

import numpy as np


def to_segment(place, start, end):
    """Distance of a place on the plan to a segment."""
    place, start, end = (np.asarray(v, float) for v in (place, start, end))
    way = end - start
    t = np.clip(np.dot(place - start, way) / np.dot(way, way), 0.0, 1.0)
    return float(np.linalg.norm(place - start - t * way))


def in_polygon(place, points):
    """Whether a place on the plan is inside a polygon: a ray to +x crosses it an odd number of
    times."""
    inside = False
    for (ax, ay), (bx, by) in zip(points, np.roll(points, -1, axis=0), strict=True):
        if (ay > place[1]) != (by > place[1]):
            x = ax + (place[1] - ay) / (by - ay) * (bx - ax)
            inside ^= bool(place[0] < x)
    return inside


def to_polygon(place, points):
    """Signed distance of a place on the plan to a polygon, negative inside."""
    ends = np.roll(points, -1, axis=0)
    away = min(to_segment(place, a, b) for a, b in zip(points, ends, strict=True))
    return -away if in_polygon(place, points) else away


def to_prism(place, points, bottom, top):
    """Signed distance of a place to an upright prism."""
    flat = to_polygon(place[:2], np.asarray(points, float))
    below, over = bottom - place[2], place[2] - top
    if flat <= 0.0 and below <= 0.0 and over <= 0.0:
        return max(flat, below, over)
    return float(np.hypot(max(flat, 0.0), max(below, over, 0.0)))


def to_sphere(place, centre, radius):
    """Signed distance of a place to a sphere."""
    return float(np.linalg.norm(np.subtract(place, centre)) - radius)


def to_box_edges(place, low, high):
    """Signed distance of a place to the walls of a box around it, negative outside."""
    return float(min(np.min(np.subtract(place, low)), np.min(np.subtract(high, place))))


def to_obstacle(place, obstacle):
    """Signed distance of a place to a sphere, prism or box of `worlds.obstacles`."""
    if obstacle.shape == "sphere":
        return to_sphere(place, obstacle.centre, obstacle.radius)
    if obstacle.shape == "prism":
        return to_prism(place, obstacle.points, obstacle.bottom, obstacle.top)
    (x, y, z), (u, v, w) = obstacle.low, obstacle.high
    return to_prism(place, [(x, y), (u, y), (u, v), (x, v)], z, w)
