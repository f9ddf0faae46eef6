"""Who is near whom: the graph of agents within a distance r, and what follows from it directly."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from agents.observables.array_checks import box, length, numbers, spread, together, vectors
from worlds.input_error import InputError


def into_the_box(position: np.ndarray, size, images) -> np.ndarray:
    """Positions (N, dim), those along axes in `images` brought into [0, size). Raises InputError.

    Row by row: what is nan stays nan.
    """
    position = vectors("position", position)
    size, images = box(size, images, position.shape[1])
    inside = np.where(images, np.mod(position, size), position)
    return np.where(images & (inside >= size), 0.0, inside)


def tree(position: np.ndarray, size, images) -> cKDTree:
    """A k-d tree of positions (N, dim), periodic along the axes in `images` of length `size`.

    Rows that are no numbers are left out, with a warning. Raises InputError.
    """
    _, position = together(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    if not images.any():
        return cKDTree(position)
    return cKDTree(into_the_box(position, size, images), boxsize=np.where(images, size, 0.0))


def links(position: np.ndarray, r: float, size, images) -> np.ndarray:
    """Pairs (i < j) with 0 < |x_i - x_j| <= r: rows, int (M, 2), sorted.

    Parameters
    ----------
    position: (N, dim), length; a row that is no number has no pairs, and a warning tells of it.
    r: >= 0, length.
    size: (dim,) sides of the box > 0; images: (dim,) bool, axes seen across the seam.

    Raises InputError.
    """
    stay, position = together(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    r = length("r", r)
    if len(position) < 2:
        return np.empty((0, 2), np.int64)
    found = tree(position, size, images)
    pairs = found.query_pairs(r, output_type="ndarray")
    apart = separation(found.data[pairs[:, 0]], found.data[pairs[:, 1]], size, images)
    pairs = pairs[(apart != 0.0).any(axis=1)].astype(np.int64)
    pairs = pairs if stay is None else np.flatnonzero(stay)[pairs]
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def nearest_of(apart: np.ndarray, k: int) -> np.ndarray:
    """Rows of the k nearest places, nearest first: apart (M, dim) -> int (k or fewer,).

    A place at distance 0 is nobody's neighbour, and nor is one that is no number.
    """
    d2 = (apart**2).sum(axis=1)
    there = np.flatnonzero(d2 > 0.0)
    return there[np.argsort(d2[there], kind="stable")[:k]]


def nearest_links(position: np.ndarray, k: int, size, images) -> np.ndarray:
    """Pairs (i < j) of which one is among the k nearest of the other: rows, int (M, 2), sorted.

    The rest as `links`. Raises InputError.
    """
    stay, position = together(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    if len(position) < 2:
        return np.empty((0, 2), np.int64)
    found = tree(position, size, images)
    many = min(len(position), k + 1)
    while True:
        distance, near = found.query(found.data, many)
        counted = (distance > 0.0) & ((distance > 0.0).cumsum(axis=1) <= k)
        if many == len(position) or counted.sum(axis=1).min() == k:
            break
        many = min(len(position), 2 * many)  # several are in one spot
    one = np.repeat(np.arange(len(position)), counted.sum(axis=1))
    pairs = np.unique(np.sort(np.column_stack([one, near[counted]]), axis=1), axis=0)
    return pairs if stay is None else np.flatnonzero(stay)[pairs]


def separation(a: np.ndarray, b: np.ndarray, size, images) -> np.ndarray:
    """Vectors from a to the nearest image of b, (..., dim), length; nan where one is. Or
    InputError.

    `a` and `b` are places (..., dim) that broadcast, `size` (dim,) > 0, `images` (dim,) bool.
    """
    a, b = numbers("a", a), numbers("b", b)
    dim = np.size(size)
    size, images = box(size, images, dim)
    try:
        fits = np.broadcast_shapes(a.shape, b.shape)[-1:] == (dim,)
    except ValueError:
        fits = False
    if not fits:
        raise InputError(
            f"places of shapes {a.shape} and {b.shape} do not match a box of {dim} axes"
        )
    d = b - a
    return np.where(images, d - size * np.round(d / size), d)


def mean_neighbours(position: np.ndarray, r: float, size, images) -> float:
    """Mean number of neighbours within r, those on one's own spot left out; 0 for an empty flock.

    Arguments as for `links`; rows left out are not counted. Pairs are counted, not listed: quick in
    a crowd too.
    """
    _, position = together(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    r = length("r", r)
    if len(position) == 0:
        return 0.0
    found = tree(position, size, images)
    on_one_spot, within = found.count_neighbors(found, [0.0, r])
    return float(within - on_one_spot) / len(position)


def nearest_neighbour(position: np.ndarray, size, images) -> np.ndarray:
    """Distance from each agent to its nearest other, (N,), length; inf for a lone agent.

    `position` (N, dim), length: a row that is no number has nan, and a warning tells of it. `size`
    (dim,) sides of the box > 0, `images` (dim,) bool. Raises InputError.
    """
    stay, position = together(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    if len(position) < 2:
        return spread(stay, np.full(len(position), np.inf), np.nan)
    found = tree(position, size, images)
    distance, _ = found.query(found.data, k=2)
    return spread(stay, distance[:, 1], np.nan)
