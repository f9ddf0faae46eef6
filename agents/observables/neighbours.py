"""Who is near whom: the graph of agents within a distance r, and what follows from it directly."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from agents.engine.cache import compile_to_disk
from agents.observables.array_checks import (
    box,
    drop_bad_rows,
    flags,
    integers,
    length,
    numbers,
    pairs,
    spread,
    vectors,
)
from agents.observables.groups import graph, rank_groups
from worlds.compilation import compiled
from worlds.input_error import InputError

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


def wrap_into_box(position: np.ndarray, size, images) -> np.ndarray:
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
    from scipy.spatial import cKDTree

    _, position = drop_bad_rows(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    if not images.any():
        return cKDTree(position)
    return cKDTree(wrap_into_box(position, size, images), boxsize=np.where(images, size, 0.0))


def links(position: np.ndarray, r: float, size, images) -> np.ndarray:
    """Pairs (i < j) with 0 < |x_i - x_j| <= r: rows, int (M, 2), sorted.

    Parameters
    ----------
    position: (N, dim), length; a row that is no number has no pairs, and a warning tells of it.
    r: >= 0, length.
    size: (dim,) sides of the box > 0; images: (dim,) bool, axes seen across the seam.

    Raises InputError.
    """
    finite, position = drop_bad_rows(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    r = length("r", r)
    if len(position) < 2:
        return np.empty((0, 2), np.int64)
    position_tree = tree(position, size, images)
    pairs = position_tree.query_pairs(r, output_type="ndarray")
    offset = separation(
        position_tree.data[pairs[:, 0]], position_tree.data[pairs[:, 1]], size, images
    )
    pairs = pairs[(offset != 0.0).any(axis=1)].astype(np.int64)
    pairs = pairs if finite is None else np.flatnonzero(finite)[pairs]
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def nearest_of(offset: np.ndarray, k: int) -> np.ndarray:
    """Rows of the k nearest places, nearest first: apart (M, dim) -> int (k or fewer,).

    A place at distance 0 is nobody's neighbour, and nor is one that is no number.
    """
    d2 = (offset**2).sum(axis=1)
    others = np.flatnonzero(d2 > 0.0)
    return others[np.argsort(d2[others], kind="stable")[:k]]


def nearest_links(position: np.ndarray, k: int, size, images) -> np.ndarray:
    """Pairs (i < j) of which one is among the k nearest of the other: rows, int (M, 2), sorted.

    The rest as `links`. Raises InputError.
    """
    finite, position = drop_bad_rows(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    if len(position) < 2:
        return np.empty((0, 2), np.int64)
    position_tree = tree(position, size, images)
    many = min(len(position), k + 1)
    while True:
        distance, near = position_tree.query(position_tree.data, many)
        is_neighbour = (distance > 0.0) & ((distance > 0.0).cumsum(axis=1) <= k)
        if many == len(position) or is_neighbour.sum(axis=1).min() == k:
            break
        many = min(len(position), 2 * many)  # several are in one spot
    row = np.repeat(np.arange(len(position)), is_neighbour.sum(axis=1))
    pairs = np.unique(np.sort(np.column_stack([row, near[is_neighbour]]), axis=1), axis=0)
    return pairs if finite is None else np.flatnonzero(finite)[pairs]


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
    _, position = drop_bad_rows(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    r = length("r", r)
    if len(position) == 0:
        return 0.0
    position_tree = tree(position, size, images)
    on_one_spot, within = position_tree.count_neighbors(position_tree, [0.0, r])
    return float(within - on_one_spot) / len(position)


def nearest_neighbour(position: np.ndarray, size, images) -> np.ndarray:
    """Distance from each agent to its nearest other, (N,), length; inf for a lone agent.

    `position` (N, dim), length: a row that is no number has nan, and a warning tells of it. `size`
    (dim,) sides of the box > 0, `images` (dim,) bool. Raises InputError.
    """
    finite, position = drop_bad_rows(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    if len(position) < 2:
        return spread(finite, np.full(len(position), np.inf), np.nan)
    position_tree = tree(position, size, images)
    distance, _ = position_tree.query(position_tree.data, k=2)
    return spread(finite, distance[:, 1], np.nan)


# Connected groups straight from positions, without a list of all who are within reach.
#
# Cells so small that all in one cell are within reach of each other are joined to the cells around
# them as soon as one pair is found: crowded flocks have few cells, and sparse ones few pairs.


@compiled
def root(parent, c):
    """The cell that stands for the component of cell c; halves the way there."""
    while parent[c] != c:
        parent[c] = parent[parent[c]]
        c = parent[c]
    return c


@compiled
def find(cells, x, y, z):
    """The row of cells (C, 3), sorted, that is (x, y, z), or -1."""
    low, high = 0, cells.shape[0]
    while low < high:
        mid = (low + high) // 2
        a, b, c = cells[mid, 0], cells[mid, 1], cells[mid, 2]
        if a < x or (a == x and (b < y or (b == y and c < z))):
            low = mid + 1
        else:
            high = mid
    if low < cells.shape[0] and cells[low, 0] == x and cells[low, 1] == y and cells[low, 2] == z:
        return low
    return -1


@compiled
def round_trip(cell, count):
    """A cell's number along an axis, taken round if `count` cells close on themselves; 0: open."""
    return cell % count if count > 0 else cell


@compiled
def has_close_pair(position, first, a, b, side, r2):
    """Whether an agent of cell a and one of cell b are on two spots within reach of each other."""
    for i in range(first[a], first[a + 1]):
        for j in range(first[b], first[b + 1]):
            d2 = 0.0
            for axis in range(3):
                d = position[j, axis] - position[i, axis]
                if side[axis] > 0.0:
                    d -= side[axis] * math.floor(d / side[axis] + 0.5)
                d2 += d * d
            if 0.0 < d2 <= r2:
                return True
    return False


@compile_to_disk
def join(position, cells, first, side, count, offsets, r2, parent, linked):
    """Join the cells (C, 3) that have agents within reach of each other.

    `position` is (N, 3), sorted by cell, `first` (C + 1,) the first row of each cell, `side` (3,)
    the box along axes seen across the seam and 0 along others, `count` (3,) the cells along them,
    `offsets` (3,) how many cells away an agent within reach can be. `parent` (C,) begins with each
    cell alone and ends with the one that stands for its component; `linked` (C,) tells which cells
    have another within reach, or two spots of their own.
    """
    for a in range(cells.shape[0]):
        for i in range(first[a] + 1, first[a + 1]):
            for axis in range(3):
                if position[i, axis] != position[first[a], axis]:
                    linked[a] = True
        for dx in range(offsets[0] + 1):
            for dy in range(-offsets[1], offsets[1] + 1):
                for dz in range(-offsets[2], offsets[2] + 1):
                    b = find(
                        cells,
                        round_trip(cells[a, 0] + dx, count[0]),
                        round_trip(cells[a, 1] + dy, count[1]),
                        round_trip(cells[a, 2] + dz, count[2]),
                    )
                    if b >= 0 and b != a:
                        root_a, root_b = root(parent, a), root(parent, b)
                        if root_a != root_b and has_close_pair(position, first, a, b, side, r2):
                            parent[max(root_a, root_b)] = min(root_a, root_b)
                            linked[a] = linked[b] = True
    for a in range(cells.shape[0]):
        parent[a] = root(parent, a)


def groups_within(position: np.ndarray, r: float, size, images) -> np.ndarray:
    """The connected group of each agent in the graph of pairs with 0 < |x_i - x_j| <= r.

    Parameters
    ----------
    position: (N, dim), length. r: >= 0, length.
    size: (dim,) sides of the box > 0; images: (dim,) bool, axes seen across the seam.

    Returns
    -------
    int (N,): 0 the largest group, then by size, ties by first row, as `groups.group_labels`; -1 for
    rows that are no numbers, of which a warning tells. Raises InputError.

    >>> on_a_line = np.array([[0.0, 0.0], [5.0, 0.0], [6.0, 0.0]])
    >>> groups_within(on_a_line, 1.0, np.ones(2), np.zeros(2, bool)).tolist()
    [1, 0, 0]
    """
    finite, position = drop_bad_rows(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    r = length("r", r)
    n, dim = position.shape
    if n == 0 or r == 0.0:
        return spread(finite, np.arange(n), -1)
    inside = wrap_into_box(position, size, images)
    largest_side = r / math.sqrt(dim) * (1.0 - 1e-9)
    cell_counts = np.maximum(1, np.ceil(np.asarray(size, float) / largest_side))
    width = np.where(images, size / cell_counts, largest_side)
    cell = np.floor(inside / width).astype(np.int64)
    cell = np.where(images, np.minimum(cell, cell_counts.astype(np.int64) - 1), cell)
    order = np.lexsort(cell.T[::-1])
    padding = ((0, 0), (0, 3 - dim))
    cells, first = np.unique(cell[order], axis=0, return_index=True)
    of_agent = np.repeat(np.arange(len(cells)), np.diff(first, append=n))
    parent, linked = np.arange(len(cells)), np.zeros(len(cells), bool)
    join(
        np.pad(inside[order], padding),
        np.pad(cells, padding),
        np.append(first, n),
        np.pad(np.where(images, size, 0.0), (0, 3 - dim)),
        np.pad(np.where(images, cell_counts, 0).astype(np.int64), (0, 3 - dim)),
        np.pad((np.floor(r / width) + 1).astype(np.int64), (0, 3 - dim)),
        r * r,
        parent,
        linked,
    )
    label = np.empty(n, np.int64)
    label[order] = np.where(linked[of_agent], parent[of_agent], len(cells) + np.arange(n))
    return spread(finite, rank_groups(label), -1)


# Layers below the information agents: hops through the r-graph (Liu et al. 2021, (2) to (4)).


def layers(links: np.ndarray, informed: np.ndarray) -> np.ndarray:
    """Layer of each agent, int (N,): 1 information agent, 2 in contact with one; N + 1 unknown.

    `links` are undirected pairs of rows (M, 2), `informed` (N,) bool. Raises InputError.
    """
    informed = flags("informed", informed)
    from scipy.sparse.csgraph import dijkstra

    links = pairs(links, len(informed))
    n = len(informed)
    source = np.flatnonzero(informed)
    if len(source) == 0:
        return np.full(n, n + 1)
    hops = dijkstra(
        graph(n, links).tocsr(), directed=False, indices=source, unweighted=True, min_only=True
    )
    return np.where(np.isfinite(hops), hops + 1, n + 1).astype(np.int64)


def layer_histogram(layer: np.ndarray) -> dict[int, int]:
    """Number of agents of each layer that occurs; N + 1 stands for unknown.

    `layer` is int (N,), >= 1, as `layers` has it. Raises InputError.

    >>> layer_histogram(np.array([1, 2, 2]))
    {1: 1, 2: 2}
    """
    value, count = np.unique(integers("layer", layer, 1), return_counts=True)
    return {int(v): int(c) for v, c in zip(value, count, strict=True)}
