"""Shapes of what an agent notices, about its nose on +x and of radius 1."""

from __future__ import annotations

import numpy as np

from app.viewer.scene.draw.shapes import Mesh

AROUND, ALONG = 64, 40
"""Facets of a dome round the nose, and from the nose to the back of a whole one."""


def dome(half: float, start: float = 0.0) -> Mesh:
    """The part of the sphere from `start` to `half` (rad, up to pi) off the nose, facing out."""
    rows = max(2, int(np.ceil(ALONG * (half - start) / np.pi)) + 1)
    off = np.linspace(start, half, rows)[None, :, None]
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)[:, None, None]
    across = np.concatenate([0.0 * turn, np.cos(turn), np.sin(turn)], axis=2)
    vertices = np.cos(off) * np.array([1.0, 0.0, 0.0]) + np.sin(off) * across
    return vertices.reshape(-1, 3), _strips(AROUND, rows)


def cone(half: float) -> Mesh:
    """The side of the cone from the middle to the sphere's circle at `half` (rad) off the nose."""
    turn = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    rim = np.column_stack(
        [
            np.full(AROUND, np.cos(half)),
            np.sin(half) * np.cos(turn),
            np.sin(half) * np.sin(turn),
        ]
    )
    here = np.arange(AROUND)
    faces = np.column_stack([np.zeros(AROUND, int), 1 + (here + 1) % AROUND, 1 + here])
    return np.concatenate([np.zeros((1, 3)), rim]), faces


def sector(inner: float, start: float, half: float) -> Mesh:
    """A flat ring from radius `inner` to 1, between `start` and `half` (rad) off the nose on both
    sides, facing up."""
    count = max(2, int(np.ceil(96 * (half - start) / np.pi)) + 1)
    off = np.linspace(start, half, count)
    vertices: list[np.ndarray] = []
    faces: list[np.ndarray] = []
    for side in (1, -1):
        spoke = np.column_stack([np.cos(off), side * np.sin(off), np.zeros(count)])
        first = 2 * len(vertices) * count
        here, there = first + np.arange(count - 1), first + count + np.arange(count - 1)
        quads = [
            np.column_stack([here, there, there + 1]),
            np.column_stack([here, there + 1, here + 1]),
        ]
        faces += [quad[:, ::side] for quad in quads]
        vertices.append(np.concatenate([inner * spoke, spoke]))
    return np.concatenate(vertices), np.concatenate(faces)


def arc(half: float) -> np.ndarray:
    """The arc from -half to +half (rad) off the nose in the plane z = 0, segments (K, 2, 3)."""
    count = max(2, int(np.ceil(128 * half / np.pi)))
    off = np.linspace(-half, half, count + 1)
    points = np.column_stack([np.cos(off), np.sin(off), np.zeros(count + 1)])
    return np.stack([points[:-1], points[1:]], axis=1)


def arcs(half: float) -> np.ndarray:
    """Two arcs across the nose, level and upright, and the circle where they end, (K, 2, 3)."""
    level = arc(half)
    lines = [level, level[..., [0, 2, 1]]]
    if half < np.pi:
        turn = np.linspace(0.0, 2.0 * np.pi, AROUND + 1)
        rim = np.column_stack(
            [
                np.full(AROUND + 1, np.cos(half)),
                np.sin(half) * np.cos(turn),
                np.sin(half) * np.sin(turn),
            ]
        )
        lines.append(np.stack([rim[:-1], rim[1:]], axis=1))
    return np.concatenate(lines)


def spokes(half: float, flat: bool) -> np.ndarray:
    """Lines from the middle to the edge of what is seen, (K, 2, 3): two, in space four."""
    c, s = np.cos(half), np.sin(half)
    ends = [[c, s, 0.0], [c, -s, 0.0]] + ([] if flat else [[c, 0.0, s], [c, 0.0, -s]])
    return np.stack([np.zeros((len(ends), 3)), np.array(ends)], axis=1)


def _strips(around: int, rows: int) -> np.ndarray:
    """Triangles over a grid of vertices (around, rows), closed along its first axis."""
    i, j = (part.ravel() for part in np.meshgrid(range(around), range(rows - 1), indexing="ij"))
    here, beside = i * rows + j, ((i + 1) % around) * rows + j
    return np.concatenate(
        [
            np.column_stack([here, here + 1, beside + 1]),
            np.column_stack([here, beside + 1, beside]),
        ]
    )
