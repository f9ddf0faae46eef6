"""Where the nearest neighbours are, ahead or aside: the structure of a flock (Ballerini 2008)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from agents.observables.array_checks import (
    box,
    drop_bad_rows,
    integers,
    numbers,
    vectors,
)
from agents.observables.neighbours import separation, tree
from worlds.input_error import InputError


class Anisotropy(NamedTuple):
    """How directions to the k-th neighbour lie to the flock's direction; K ranks."""

    gamma: np.ndarray
    """(K,) in [0, 1]: 1 if the k-th neighbours are all aside, 0 if ahead and behind; at random 1/3
    in space and 1/2 in the plane. NaN where nobody is that far inside."""
    distance: np.ndarray
    """(K,) the mean distance of the k-th neighbour, length; NaN as above."""
    individuals: np.ndarray
    """(K,) int, how many were far enough inside."""


def neighbour_anisotropy(
    position: np.ndarray,
    direction: np.ndarray,
    size: np.ndarray,
    images: np.ndarray,
    neighbours: int = 20,
) -> Anisotropy:
    """gamma_k = (W_k . V)^2, W_k the direction in which k-th neighbours are the fewest.

    W_k is the eigenvector of the smallest eigenvalue of `M_k = <u u^T>`, u the direction to the
    k-th neighbour (Ballerini et al. 2008). Only individuals count whose k-th neighbour is nearer
    than the border of the flock, its convex hull: at the border all neighbours are to one side, and
    the shape of the flock alone would look like a structure. Seen across the seam of a box that
    closes along all axes there is no border.

    Parameters
    ----------
    position: (N, dim); rows that are no numbers are left out, with a warning.
    direction: (dim,) of the flock, not 0. size: (dim,) sides > 0; images: (dim,) bool.
    neighbours: K >= 1.

    Raises InputError.
    """
    _, position = drop_bad_rows(position=vectors("position", position))
    dim = position.shape[1]
    size, images = box(size, images, dim)
    count = int(integers("neighbours", neighbours, 1))
    towards = numbers("direction", direction)
    if towards.shape != (dim,) or not 0.0 < float(np.vdot(towards, towards)) < math.inf:
        raise InputError(f"direction = {towards.tolist()} is no vector of {dim} axes that is not 0")
    towards = towards / np.linalg.norm(towards)
    n = len(position)
    gamma, mean = np.full(count, np.nan), np.full(count, np.nan)
    individuals = np.zeros(count, np.int64)
    if n < dim + 2:
        return Anisotropy(gamma, mean, individuals)
    inside = border_distance(position, images)
    ranks = min(count, n - 1)
    known = tree(position, size, images)
    distance, row = known.query(known.data, ranks + 1)
    distance, row = distance[:, 1:], row[:, 1:]
    counts = (distance < inside[:, None]) & (distance > 0.0)
    apart = separation(known.data[:, None], known.data[row], size, images)
    unit = apart * np.where(counts, 1.0 / np.where(counts, distance, 1.0), 0.0)[..., None]
    matrices = np.einsum("nka,nkb->kab", unit, unit)
    least = np.linalg.eigh(matrices)[1][:, :, 0]
    individuals[:ranks] = many = counts.sum(axis=0)
    some = many > 0
    gamma[:ranks][some] = np.minimum(1.0, (least[some] @ towards) ** 2)
    mean[:ranks][some] = (distance * counts).sum(axis=0)[some] / many[some]
    return Anisotropy(gamma, mean, individuals)


def border_distance(position: np.ndarray, images: np.ndarray) -> np.ndarray:
    """How far each place (N, dim) is inside the convex hull of all, (N,), length.

    Infinite if all axes have images; 0 for all where places lie on a line or a plane.
    """
    from scipy.spatial import ConvexHull, QhullError

    if np.all(images):
        return np.full(len(position), np.inf)
    try:
        planes = ConvexHull(position).equations
    except QhullError:
        return np.zeros(len(position))
    return -(position @ planes[:, :-1].T + planes[:, -1]).max(axis=1)


def isotropic_gamma(dim: int) -> tuple[float, float]:
    """Mean and standard deviation of gamma for a structure that is the same all round.

    >>> isotropic_gamma(3)[0] == 1 / 3, isotropic_gamma(2)[0], round(isotropic_gamma(2)[1], 4)
    (True, 0.5, 0.3536)
    """
    return (1.0 / 3.0, math.sqrt(4.0 / 45.0)) if dim == 3 else (0.5, math.sqrt(1.0 / 8.0))


def range_of_structure(gamma: np.ndarray, dim: int) -> float:
    """n_c: how many neighbours it takes until gamma falls to what no structure has.

    `gamma` is (K,) by rank from 1 on. Straight between ranks; NaN if it begins below or never falls
    so far.

    >>> range_of_structure(np.array([0.7, 0.5, 0.4, 0.2]), 2), range_of_structure(np.ones(3), 3)
    (2.0, nan)
    """
    even = isotropic_gamma(dim)[0]
    gamma = numbers("gamma", gamma, axes=1)
    below = np.flatnonzero(gamma <= even)
    if not len(below) or below[0] == 0 or not np.isfinite(gamma[: below[0]]).all():
        return math.nan
    k = int(below[0])
    return float(k + (gamma[k - 1] - even) / (gamma[k - 1] - gamma[k]))
