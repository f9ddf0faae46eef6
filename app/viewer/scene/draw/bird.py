"""A bird in two meshes, one unit long: nose on +x, wings level when they are not beaten.

The wings are one mesh with the height |y|: a scale of (1, cos a, sin a) turns both up by the angle
a about the shoulders, so a beat takes no more than a scale for each bird.
"""

from __future__ import annotations

import numpy as np

from app.viewer.scene.draw.shapes import Mesh

SIDES = 6
"""Facets round the body."""
STATIONS = (
    (0.43, 0.018, 0.016, -0.010),
    (0.38, 0.048, 0.046, 0.004),
    (0.30, 0.062, 0.060, 0.008),
    (0.20, 0.064, 0.060, 0.000),
    (0.06, 0.090, 0.082, -0.008),
    (-0.10, 0.078, 0.070, -0.004),
    (-0.26, 0.036, 0.032, 0.004),
)
"""Sections of the body from the beak backwards: x, half the width, half the height, middle."""
BEAK, RUMP = (0.52, 0.0, -0.016), (-0.34, 0.0, 0.006)
TAIL = ((-0.24, 0.030), (-0.56, 0.130), (-0.50, 0.0))
"""The tail's left half: root, outer feather, middle; x and y."""
SHOULDER = 0.02
"""Height of the wings over the body's axis."""
TIP = 0.88
"""Distance of a wing tip from the axis, as a multiple of a bird's length."""
WING = (
    (0.15, 0.03, 0.03),
    (0.21, 0.32, 0.31),
    (0.13, 0.56, 0.55),
    (-0.13, TIP, TIP),
    (-0.05, 0.54, 0.60),
    (-0.13, 0.30, 0.34),
    (-0.15, 0.03, 0.05),
)
"""The left wing round its edge from the shoulder outwards: x, y, and y again as the height's."""
PANELS = ((0, 5, 1), (0, 6, 5), (1, 4, 2), (1, 5, 4), (2, 4, 3))


def body() -> Mesh:
    """Beak, trunk and a flat tail."""
    turn = 2.0 * np.pi * (np.arange(SIDES) + 0.5) / SIDES
    rings = [
        np.column_stack(
            [np.full(SIDES, x), wide * np.cos(turn), middle + high * np.sin(turn)],
        )
        for x, wide, high, middle in STATIONS
    ]
    here = np.arange(SIDES)
    after = (here + 1) % SIDES
    faces = [np.column_stack([np.zeros(SIDES, int), 2 + here, 2 + after])]
    for ring in range(len(STATIONS) - 1):
        front, back = 2 + SIDES * ring, 2 + SIDES * (ring + 1)
        faces.append(np.column_stack([front + here, back + here, back + after]))
        faces.append(np.column_stack([front + here, back + after, front + after]))
    last = 2 + SIDES * (len(STATIONS) - 1)
    faces.append(np.column_stack([np.ones(SIDES, int), last + after, last + here]))
    trunk = np.concatenate([[BEAK, RUMP], *rings])
    (root, rw), (outer, ow), (middle, _) = TAIL
    tail = np.array(
        [
            [root, rw, 0.012],
            [outer, ow, 0.0],
            [middle, 0.0, 0.012],
            [outer, -ow, 0.0],
            [root, -rw, 0.012],
        ]
    )
    first = len(trunk)
    faces.append(first + np.array([[0, 1, 2], [0, 2, 4], [4, 2, 3]]))
    return np.concatenate([trunk, tail]), np.concatenate(faces)


def wings() -> Mesh:
    """Both wings turned up by 45 degrees about their shoulders, sqrt(2) times too long."""
    left = np.array(WING)
    right = left * np.array([1.0, -1.0, 1.0])
    panels = np.array(PANELS)
    return np.concatenate([left, right]), np.concatenate([panels, len(left) + panels[:, ::-1]])


def beaten(angle: np.ndarray) -> np.ndarray:
    """Scales (N, 3) of the wings' mesh that turn both wings up by an angle (N,), rad.

    >>> beaten(np.array([0.0])).tolist()
    [[1.0, 1.0, 0.0]]
    """
    return np.column_stack([np.ones(len(angle)), np.cos(angle), np.sin(angle)])
