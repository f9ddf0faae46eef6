"""Connected groups straight from positions, without a list of all who are within reach.

Cells so small that all in one cell are within reach of each other are joined to the cells around
them as soon as one pair is found: crowded flocks have few cells, and sparse ones few pairs.
"""

from __future__ import annotations

import math

import numpy as np

from agents.engine.cache import kept
from agents.observables.array_checks import box, length, spread, together, vectors
from agents.observables.groups import ranked
from agents.observables.neighbours import into_the_box
from worlds.compilation import compiled


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
def some_pair(position, first, a, b, side, r2):
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


@kept
def join(position, cells, first, side, count, far, r2, parent, linked):
    """Join the cells (C, 3) that have agents within reach of each other.

    `position` is (N, 3), sorted by cell, `first` (C + 1,) the first row of each cell, `side` (3,)
    the box along axes seen across the seam and 0 along others, `count` (3,) the cells along them,
    `far` (3,) how many cells away an agent within reach can be. `parent` (C,) begins with each cell
    alone and ends with the one that stands for its component; `linked` (C,) tells which cells have
    another within reach, or two spots of their own.
    """
    for a in range(cells.shape[0]):
        for i in range(first[a] + 1, first[a + 1]):
            for axis in range(3):
                if position[i, axis] != position[first[a], axis]:
                    linked[a] = True
        for dx in range(far[0] + 1):
            for dy in range(-far[1], far[1] + 1):
                for dz in range(-far[2], far[2] + 1):
                    b = find(
                        cells,
                        round_trip(cells[a, 0] + dx, count[0]),
                        round_trip(cells[a, 1] + dy, count[1]),
                        round_trip(cells[a, 2] + dz, count[2]),
                    )
                    if b >= 0 and b != a:
                        one, other = root(parent, a), root(parent, b)
                        if one != other and some_pair(position, first, a, b, side, r2):
                            parent[max(one, other)] = min(one, other)
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
    stay, position = together(position=vectors("position", position))
    size, images = box(size, images, position.shape[1])
    r = length("r", r)
    n, dim = position.shape
    if n == 0 or r == 0.0:
        return spread(stay, np.arange(n), -1)
    inside = into_the_box(position, size, images)
    most = r / math.sqrt(dim) * (1.0 - 1e-9)
    around = np.maximum(1, np.ceil(np.asarray(size, float) / most))
    width = np.where(images, size / around, most)
    cell = np.floor(inside / width).astype(np.int64)
    cell = np.where(images, np.minimum(cell, around.astype(np.int64) - 1), cell)
    order = np.lexsort(cell.T[::-1])
    missing = ((0, 0), (0, 3 - dim))
    cells, first = np.unique(cell[order], axis=0, return_index=True)
    of_agent = np.repeat(np.arange(len(cells)), np.diff(first, append=n))
    parent, linked = np.arange(len(cells)), np.zeros(len(cells), bool)
    join(
        np.pad(inside[order], missing),
        np.pad(cells, missing),
        np.append(first, n),
        np.pad(np.where(images, size, 0.0), (0, 3 - dim)),
        np.pad(np.where(images, around, 0).astype(np.int64), (0, 3 - dim)),
        np.pad((np.floor(r / width) + 1).astype(np.int64), (0, 3 - dim)),
        r * r,
        parent,
        linked,
    )
    label = np.empty(n, np.int64)
    label[order] = np.where(linked[of_agent], parent[of_agent], len(cells) + np.arange(n))
    return spread(stay, ranked(label), -1)
