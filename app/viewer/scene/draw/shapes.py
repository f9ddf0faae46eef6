"""The few meshes of the scene, all of unit size about their own centre."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

Mesh = tuple[np.ndarray, np.ndarray]
"""Vertices (V, 3) and triangles (F, 3), anticlockwise seen from outside."""


def dart() -> Mesh:
    """A swept-wing dart one unit long: nose on +x, wings level, a ridge above and a keel below.

    The ridge splits the top into two facets, so with flat shading the nose reads from any side; the
    notch between the wings is deep enough that it does at a length of 8 pixels.
    """
    vertices = np.array(
        [
            [0.60, 0.00, 0.00],  # 0 nose
            [-0.40, 0.36, 0.00],  # 1 left wing tip
            [-0.40, -0.36, 0.00],  # 2 right wing tip
            [-0.13, 0.00, 0.18],  # 3 ridge
            [-0.13, 0.00, -0.13],  # 4 keel
        ]
    )
    faces = np.array([[0, 1, 3], [0, 3, 2], [0, 4, 1], [0, 2, 4], [1, 4, 3], [2, 3, 4]])
    return vertices, faces


def ring(inner: float, corners: int = 96) -> Mesh:
    """A flat ring of outer radius 1 in the plane z = 0, facing up."""
    angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(corners)])
    index = np.arange(corners)
    after = (index + 1) % corners
    faces = np.concatenate(
        [
            np.column_stack([index, index + corners, after + corners]),
            np.column_stack([index, after + corners, after]),
        ]
    )
    return np.concatenate([inner * circle, circle]), faces


def torus(tube: float = 0.04, corners: int = 72, sides: int = 10) -> Mesh:
    """A round ring of radius 1 in the plane z = 0, `tube` thick to each side."""
    around = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)[:, None]
    across = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)[None, :]
    radius = 1.0 + tube * np.cos(across)
    height = np.broadcast_to(tube * np.sin(across), (corners, sides))
    vertices = np.stack([radius * np.cos(around), radius * np.sin(around), height], axis=-1)
    return vertices.reshape(-1, 3), _grid_triangles(corners, sides, closed=True)


def ball(corners: int = 40, sides: int = 20) -> Mesh:
    """The unit sphere by meridians and parallels."""
    around = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)[:, None]
    down = np.linspace(0.0, np.pi, sides)[None, :]
    height = np.broadcast_to(np.cos(down), (corners, sides))
    vertices = np.stack([np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), height], -1)
    return vertices.reshape(-1, 3), _grid_triangles(corners, sides, closed=False)[:, ::-1]


def _grid_triangles(corners: int, sides: int, closed: bool) -> np.ndarray:
    """Triangles over a grid of vertices, closed along its first axis and perhaps its second."""
    spans = sides if closed else sides - 1
    i, j = (part.ravel() for part in np.meshgrid(range(corners), range(spans), indexing="ij"))
    ahead, beside = (i + 1) % corners, (j + 1) % sides
    corner, right = i * sides + j, ahead * sides + j
    far, left = ahead * sides + beside, i * sides + beside
    return np.concatenate(
        [np.column_stack([corner, right, far]), np.column_stack([corner, far, left])]
    )


def circle(corners: int = 128) -> np.ndarray:
    """The unit circle in the plane z = 0 as line segments, (corners, 2, 3)."""
    angle = np.linspace(0.0, 2.0 * np.pi, corners + 1)
    around = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(corners + 1)])
    return np.stack([around[:-1], around[1:]], axis=1)


def great_circles() -> np.ndarray:
    """Three great circles of the unit sphere, across x, y and z, as line segments (S, 2, 3)."""
    level = circle(96)
    return np.concatenate([level, level[..., [2, 0, 1]], level[..., [0, 2, 1]]])


def box_edges(half: np.ndarray) -> np.ndarray:
    """Edges, (12, 2, 3) or (4, 2, 3) if flat, of a box about the origin of half sides (3,)."""
    corners = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    pairs = [
        (a, b)
        for a in range(8)
        for b in range(a + 1, 8)
        if np.count_nonzero(corners[a] != corners[b]) == 1
    ]
    if half[2] == 0.0:
        pairs = [(a, b) for a, b in pairs if corners[a][2] > 0.0 and corners[b][2] > 0.0]
    return np.array([[corners[a], corners[b]] for a, b in pairs]) * half


def dashes(way: np.ndarray, dash: float, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """A line through points (K, 3) as dashes: segments (M, 2, 3), and the leg (M,) each is on.

    The dash and the gap after it are fitted to each leg, so that both its ends are drawn.

    >>> dashes(np.array([[0.0, 0, 0], [5.0, 0, 0]]), 1.0, 1.0)[0][:, :, 0].tolist()
    [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]
    """
    pieces, legs = [np.empty((0, 2, 3))], [np.empty(0, dtype=int)]
    for leg, (start, end) in enumerate(pairwise(way)):
        length = float(np.linalg.norm(end - start))
        if length == 0.0:
            continue
        count = max(1, round((length + gap) / (dash + gap)))
        stretch = length / (count * (dash + gap) - gap)
        first = np.arange(count) * (dash + gap) * stretch
        share = np.column_stack([first, first + dash * stretch]) / length
        pieces.append(start + share[..., None] * (end - start))
        legs.append(np.full(count, leg))
    return np.concatenate(pieces), np.concatenate(legs)


def dart_length(count: int, half: np.ndarray) -> float:
    """Length of a dart with which `count` of them fill a box of half sides (3,) neither thin nor
    thick: most of their mean spacing, less in space, where those behind show between those before;
    but of a few agents no more than fits the eye.
    """
    share = 0.85 if half[2] == 0.0 else 0.45
    return float(min(share * spacing(count, half), 0.088 * np.max(half)))


def spacing(count: int, half: np.ndarray) -> float:
    """Mean spacing of `count` places that fill a box of half sides (3,), which may be flat."""
    sides = 2.0 * half[half > 0.0]
    return float((np.prod(sides) / max(count, 1)) ** (1.0 / len(sides)))
