"""Order within each connected group, and how large the groups are."""

from __future__ import annotations

import numpy as np

from agents.observables.groups import group_sizes


def means(labels: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The mean of values (N, K) over each group, (G, K). `labels` is int (N,), each of 0..G-1."""
    size = group_sizes(labels)
    columns = [np.bincount(labels, column, len(size)) for column in values.T]
    return np.stack(columns, axis=1) / size[:, None]


def polarisations(labels: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Polarisation of each group, (G,), in [0, 1]: the length of its mean heading.

    Parameters
    ----------
    labels: int (N,), the group of each agent, each of 0..G-1 at least once (`group_labels`).
    heading: (N, dim) unit vectors.

    >>> east, west = [1.0, 0.0], [-1.0, 0.0]
    >>> polarisations(np.array([0, 0, 1]), np.array([east, west, west])).tolist()
    [0.0, 1.0]
    """
    return np.minimum(1.0, np.linalg.norm(means(labels, heading), axis=1))


def centres(labels: np.ndarray, position: np.ndarray, size, images) -> np.ndarray:
    """The centre of each group, (G, dim), length; along axes with images the mean on the circle.

    `position` is (N, dim), `size` (dim,) the sides of the box, `images` (dim,) bool.
    """
    position, size = np.asarray(position, float), np.asarray(size, float)
    turn = 2.0 * np.pi * position / size
    angle = np.arctan2(means(labels, np.sin(turn)), means(labels, np.cos(turn)))
    around = angle % (2.0 * np.pi) / (2.0 * np.pi) * size
    return np.where(images, around, means(labels, position))


def angular_momenta(
    labels: np.ndarray, position: np.ndarray, heading: np.ndarray, size, images
) -> np.ndarray:
    """Angular momentum of each group about its own centre, (G,), in [0, 1].

    As `agents.observables.rotation.angular_momentum`, for every group: `labels` int (N,), each of
    0..G-1, `position` and `heading` (N, dim), `size` (dim,), `images` (dim,) bool. A lone agent has
    0.
    """
    size = np.asarray(size, float)
    lone = group_sizes(labels)[labels] == 1
    apart = position - centres(labels, position, size, images)[labels]
    apart = apart - np.where(images, size * np.round(apart / size), 0.0)
    apart[lone] = 0.0
    length = np.linalg.norm(apart, axis=1, keepdims=True)
    along = np.divide(apart, length, out=np.zeros_like(apart), where=length > 0.0)
    if position.shape[1] == 2:
        turning = (along[:, 0] * heading[:, 1] - along[:, 1] * heading[:, 0])[:, None]
    else:
        turning = np.cross(along, heading)
    return np.minimum(1.0, np.linalg.norm(means(labels, turning), axis=1))


def size_histogram(labels: np.ndarray) -> dict[int, int]:
    """How many groups have each size that occurs, largest size first.

    `labels` is int (N,), each of 0..G-1.

    >>> size_histogram(np.array([0, 0, 0, 1, 2]))
    {3: 1, 1: 2}
    """
    value, count = np.unique(group_sizes(labels), return_counts=True)
    return {int(v): int(c) for v, c in zip(value[::-1], count[::-1], strict=True)}


def group_table(
    labels: np.ndarray, position: np.ndarray, heading: np.ndarray, size, images
) -> dict[int, dict[str, float]]:
    """Agents, polarisation and angular momentum of each group, by its label.

    `labels` is int (N,), each of 0..G-1, 0 for the largest group as `group_labels` has it;
    `position` and `heading` (N, dim), `size` (dim,), `images` (dim,) bool.
    """
    columns = (
        group_sizes(labels),
        polarisations(labels, heading),
        angular_momenta(labels, position, heading, size, images),
    )
    return {
        group: {"agents": int(n), "polarisation": float(phi), "angular-momentum": float(m)}
        for group, (n, phi, m) in enumerate(zip(*columns, strict=True))
    }
