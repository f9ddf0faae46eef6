"""Angular momentum: how much a group mills about its centre (Couzin et al. 2002, (5))."""

from __future__ import annotations

import numpy as np


def centre(position: np.ndarray, size: np.ndarray, images: np.ndarray) -> np.ndarray:
    """The group's centre (dim,), length; along axes with images the mean on the circle.

    `position` (N, dim), `size` (dim,) sides of the box, `images` (dim,) bool.
    """
    position = np.asarray(position, float)
    turn = 2.0 * np.pi * position / size
    round_ = np.arctan2(np.sin(turn).mean(axis=0), np.cos(turn).mean(axis=0)) % (2.0 * np.pi)
    return np.where(images, round_ / (2.0 * np.pi) * size, position.mean(axis=0))


def angular_momentum(
    position: np.ndarray, heading: np.ndarray, size: np.ndarray, images: np.ndarray
) -> float:
    """|1/N sum of r_ic x u_i| in [0, 1], r_ic the direction from the group's centre to agent i.

    `position` and `heading` are (N, dim), `size` (dim,), `images` (dim,) bool. An agent at the
    centre adds nothing; an empty group has 0.

    >>> ring = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    >>> round_the_centre = np.array([[0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]])
    >>> angular_momentum(ring, round_the_centre, np.ones(2), np.zeros(2, bool))
    1.0
    """
    if len(position) == 0:
        return 0.0
    size = np.asarray(size, float)
    apart = position - centre(position, size, images)
    apart = apart - np.where(images, size * np.round(apart / size), 0.0)
    length = np.linalg.norm(apart, axis=1, keepdims=True)
    along = np.divide(apart, length, out=np.zeros_like(apart), where=length > 0.0)
    if position.shape[1] == 2:
        return float(abs(along[:, 0] @ heading[:, 1] - along[:, 1] @ heading[:, 0]) / len(along))
    return float(np.linalg.norm(np.cross(along, heading).mean(axis=0)))
