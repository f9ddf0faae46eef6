"""Meshes of what is solid in a world: outlines drawn up into prisms, and panes for its edges."""

from __future__ import annotations

import numpy as np
import shapely

from app.viewer.scene.draw.shapes import Mesh

NO_MESH: Mesh = (np.empty((0, 3)), np.empty((0, 3), dtype=int))


def prism(outline: shapely.Geometry, bottom: float, top: float) -> Mesh:
    """The closed mesh of polygons, with their holes, drawn up from `bottom` to `top`."""
    polygons = [part for part in shapely.get_parts(outline) if part.geom_type == "Polygon"]
    return join_meshes(
        [_extrude(shapely.remove_repeated_points(part), bottom, top) for part in polygons]
    )


def _extrude(polygon: shapely.Polygon, bottom: float, top: float) -> Mesh:
    """One polygon drawn up; its corners are shared by the caps and the sides."""
    polygon = shapely.orient_polygons(polygon)
    rings = [shapely.get_coordinates(ring)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
    corners = np.concatenate(rings)
    count = len(corners)
    sides, first = [], 0
    for ring in rings:
        index = first + np.arange(len(ring))
        after = first + (np.arange(len(ring)) + 1) % len(ring)
        sides += [
            np.column_stack([index, after, after + count]),
            np.column_stack([index, after + count, index + count]),
        ]
        first += len(ring)
    cap = _cap(polygon, corners)
    vertices = np.concatenate(
        [np.column_stack([corners, np.full(count, z)]) for z in (bottom, top)]
    )
    return vertices, np.concatenate([cap[:, ::-1], cap + count, *sides])


def _cap(polygon: shapely.Polygon, corners: np.ndarray) -> np.ndarray:
    """Triangles over a polygon, anticlockwise, as rows of its corners (C, 2)."""
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    points = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    order = np.lexsort(corners.T[::-1])
    known_points = corners[order] @ np.array([1.0, 1j])
    wanted_points = points.reshape(-1, 2) @ np.array([1.0, 1j])
    faces = order[np.searchsorted(known_points, wanted_points)].reshape(-1, 3)
    a, b, c = (corners[faces[:, k]] for k in range(3))
    ab, ac = b - a, c - a
    backwards = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0] < 0.0
    faces[backwards] = faces[backwards][:, ::-1]
    return faces


def rims(outline: shapely.Geometry, height: float) -> np.ndarray:
    """The lines along polygons' outlines at a height, (K, 2, 3)."""
    lines = []
    for part in shapely.get_parts(outline):
        if part.geom_type == "Polygon":
            for ring in (part.exterior, *part.interiors):
                points = shapely.get_coordinates(ring)
                lines.append(np.stack([points[:-1], points[1:]], axis=1))
    flat = np.concatenate(lines) if lines else np.empty((0, 2, 2))
    return np.concatenate([flat, np.full((*flat.shape[:2], 1), height)], axis=2)


def uprights(outline: shapely.Geometry, bottom: float, top: float) -> np.ndarray:
    """The upright edges of prisms, where an outline turns by more than 20 degrees, (K, 2, 3)."""
    faces = []
    for part in shapely.get_parts(outline):
        if part.geom_type == "Polygon":
            for ring in (part.exterior, *part.interiors):
                corner = shapely.get_coordinates(ring)[:-1]
                ahead = np.roll(corner, -1, axis=0) - corner
                ahead /= np.linalg.norm(ahead, axis=1)[:, None]
                straight = np.einsum("ij,ij->i", ahead, np.roll(ahead, 1, axis=0))
                faces.append(corner[straight < np.cos(np.deg2rad(20.0))])
    at = np.concatenate(faces) if faces else np.empty((0, 2))
    ends = [np.column_stack([at, np.full(len(at), z)]) for z in (bottom, top)]
    return np.stack(ends, axis=1)


def join_meshes(meshes: list[Mesh]) -> Mesh:
    """Several meshes as one."""
    if not meshes:
        return NO_MESH
    counts = np.cumsum([0] + [len(vertices) for vertices, _ in meshes])
    return (
        np.concatenate([vertices for vertices, _ in meshes]),
        np.concatenate(
            [faces + first for (_, faces), first in zip(meshes, counts[:-1], strict=True)]
        ),
    )


def border(low: np.ndarray, high: np.ndarray, solid: np.ndarray, width: float) -> shapely.Geometry:
    """The strips of a `width` outside a flat box along its solid edges; (2,) each, solid bool."""
    grown = width * np.asarray(solid, dtype=float)
    outer = shapely.box(*(low[:2] - grown), *(high[:2] + grown))
    return shapely.difference(outer, shapely.box(*low[:2], *high[:2]))


def panes(low: np.ndarray, high: np.ndarray, solid: np.ndarray) -> Mesh:
    """A rectangle for each solid face of a box in space; (3,) each, solid bool."""
    panes = []
    for axis in np.flatnonzero(solid):
        others = [other for other in range(3) if other != axis]
        for at in (low[axis], high[axis]):
            corners = np.empty((4, 3))
            corners[:, axis] = at
            corners[:, others[0]] = np.array([low, high, high, low])[:, others[0]]
            corners[:, others[1]] = np.array([low, low, high, high])[:, others[1]]
            panes.append((corners, np.array([[0, 1, 2], [0, 2, 3]])))
    return join_meshes(panes)
