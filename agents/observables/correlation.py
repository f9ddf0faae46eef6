"""How far the velocity fluctuations of a flock hang together (Cavagna et al. 2010)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from agents.engine.cache import compile_to_disk
from agents.observables.array_checks import box, drop_bad_rows, length, vectors
from agents.observables.neighbours import nearest_neighbour

LARGEST = 4000
"""Agents of which all pairs are taken; of a larger flock, so many drawn by chance, always the same.
"""
BINS = 1000
"""Bins of distance at most."""
STILL = 1e-12
"""Fluctuations smaller than this share of the speed are rounding errors, not fluctuations."""


class Correlation(NamedTuple):
    """The connected correlation of velocity fluctuations by distance, in bins that have pairs."""

    distance: np.ndarray
    """Mean distance of the pairs of each bin, (B,), length, rising."""
    value: np.ndarray
    """C(r) of each bin, (B,); 1 would be at r = 0."""
    pairs: np.ndarray
    """Pairs of each bin, (B,) int."""


@compile_to_disk
def pair_sums(position, fluctuation, side, width, pairs, distance, product):
    """Add up all pairs i < j by distance: their number, distances and scalar products.

    `position` and `fluctuation` are (3, N), `side` (3,) the sides of the box along axes seen across
    the seam and 0 along others; `width` of a bin, length; `pairs`, `distance` and `product` (B,)
    are added to, the last bin taking all beyond.
    """
    n, last = position.shape[1], pairs.shape[0] - 1
    turns_x = 1.0 / side[0] if side[0] > 0.0 else 0.0
    turns_y = 1.0 / side[1] if side[1] > 0.0 else 0.0
    turns_z = 1.0 / side[2] if side[2] > 0.0 else 0.0
    for i in range(n):
        x, y, z = position[0, i], position[1, i], position[2, i]
        u, v, w = fluctuation[0, i], fluctuation[1, i], fluctuation[2, i]
        for j in range(i + 1, n):
            dx, dy, dz = position[0, j] - x, position[1, j] - y, position[2, j] - z
            dx -= side[0] * math.floor(dx * turns_x + 0.5)
            dy -= side[1] * math.floor(dy * turns_y + 0.5)
            dz -= side[2] * math.floor(dz * turns_z + 0.5)
            r = math.sqrt(dx * dx + dy * dy + dz * dz)
            b = min(int(r / width), last)
            pairs[b] += 1
            distance[b] += r
            product[b] += u * fluctuation[0, j] + v * fluctuation[1, j] + w * fluctuation[2, j]


def bin_width(position: np.ndarray, size, images) -> float:
    """The width of a bin of distance, length: the median distance to the nearest neighbour.

    Or what makes BINS bins of the largest distance that can be, if that is more. Arguments as for
    `correlation`; 1 if all are on one spot or fewer than two are there.
    """
    _, position = drop_bad_rows(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    if len(position) < 2:
        return 1.0
    sides = np.where(images, np.asarray(size, float) / 2.0, np.ptp(position, axis=0))
    near = np.median(nearest_neighbour(position, size, images))
    return float(max(near, np.linalg.norm(sides) / BINS)) or 1.0


def correlation(
    position: np.ndarray, velocity: np.ndarray, size, images, width: float | None = None
) -> Correlation | None:
    """C(r): the mean of u_i . u_j over pairs at distance r, over the mean of u_i . u_i.

    u_i = v_i - <v> is how an agent's velocity differs from the flock's. Cavagna et al. 2010,
    without the pair of an agent with itself. Of more than LARGEST agents a sample is taken.

    Parameters
    ----------
    position, velocity: (N, dim), length and length/time; headings do where all speeds are equal.
        Rows of which a number is missing are left out, with a warning.
    size: (dim,) sides of the box > 0; images: (dim,) bool, axes along which distances cross the
        seam.
    width: of a bin, length > 0; None takes `bin_width`.

    Returns
    -------
    None for fewer than two agents, or if all velocities are the same. Since fluctuations add up to
    nothing, some bin is always below 0. Raises InputError.
    """
    position, velocity = vectors("position", position), vectors("velocity", velocity)
    _, position, velocity = drop_bad_rows(position=position, velocity=velocity)
    size, images = box(size, images, position.shape[1])
    width = None if width is None else length("width", width, positive=True)
    n = len(position)
    if n > LARGEST:
        rows = np.sort(np.random.default_rng(0).choice(n, LARGEST, replace=False))
        position, velocity, n = position[rows], velocity[rows], LARGEST
    if n < 2:
        return None
    fluctuation = velocity - velocity.mean(axis=0)
    power = float(np.mean(np.sum(fluctuation**2, axis=1)))
    if power <= STILL**2 * float(np.mean(np.sum(velocity**2, axis=1))):
        return None
    width = bin_width(position, size, images) if width is None else width
    side = np.pad(np.where(images, size, 0.0), (0, 3 - position.shape[1]))
    pairs, distance, product = np.zeros(BINS, np.int64), np.zeros(BINS), np.zeros(BINS)
    place, change = axis_columns(position), axis_columns(fluctuation)
    pair_sums(place, change, side, width, pairs, distance, product)
    has_pairs = pairs > 0
    count = pairs[has_pairs]
    return Correlation(distance[has_pairs] / count, product[has_pairs] / count / power, count)


def axis_columns(vectors: np.ndarray) -> np.ndarray:
    """Vectors (N, dim) as contiguous columns (3, N), with zeros for what is missing."""
    return np.ascontiguousarray(np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1]))).T)


def correlation_length(
    position: np.ndarray, velocity: np.ndarray, size, images, width: float | None = None
) -> float:
    """xi, length: where C(r) is 0 for the first time (Cavagna et al. 2010).

    Parameters as for `correlation`. Between bins, and between C(0) = 1 and the first bin, C is
    taken as straight. nan where there is no C(r).

    >>> apart = np.array([[0.0, 0.0], [3.0, 0.0]])
    >>> across = np.array([[1.0, 0.5], [1.0, -0.5]])
    >>> correlation_length(apart, across, np.ones(2), np.zeros(2, bool))
    1.5
    """
    curve = correlation(position, velocity, size, images, width)
    if curve is None:
        return math.nan
    r = np.concatenate([[0.0], curve.distance])
    c = np.concatenate([[1.0], curve.value])
    k = int(np.argmax(c <= 0.0))
    return float(r[k - 1] + (r[k] - r[k - 1]) * c[k - 1] / (c[k - 1] - c[k]))
