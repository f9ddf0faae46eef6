"""Connected groups of the r-graph, and how firmly it is connected."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from agents.observables.array_checks import (
    box,
    drop_bad_rows,
    integers,
    labels_of,
    numbers,
    pairs,
    same_length,
    units,
    vectors,
)
from agents.observables.order import outward_directions, rounding

if TYPE_CHECKING:
    from scipy.sparse import coo_array

DENSE_UP_TO = 400
"""Agents up to which the Laplacian's eigenvalues are found by the dense method."""
CROWDED = 40
"""Neighbours per agent from which iterating is quicker than factorising, in the plane too."""


def graph(n: int, links: np.ndarray) -> coo_array:
    """The adjacency matrix (n, n) of undirected links (M, 2), rows in [0, n). Raises InputError."""
    from scipy.sparse import coo_array

    links = pairs(links, n)
    i, j = links[:, 0], links[:, 1]
    ones_of_links = np.ones(2 * len(links))
    return coo_array(
        (ones_of_links, (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(n, n)
    )


def group_labels(n: int, links: np.ndarray) -> np.ndarray:
    """The group of each agent, int (n,): 0 the largest, then by size, ties by first row.

    `links` (M, 2) are undirected pairs of rows in [0, n). Raises InputError.
    """
    from scipy.sparse.csgraph import connected_components

    links = pairs(links, n)
    return (
        rank_groups(connected_components(graph(n, links), directed=False)[1]) if n else np.arange(0)
    )


def rank_groups(label: np.ndarray) -> np.ndarray:
    """Groups numbered by their size, int (N,): 0 the largest, ties by the first row.

    `label` is int (N,), any numbers. Raises InputError.

    >>> rank_groups(np.array([7, 3, 3, 5])).tolist()
    [1, 0, 0, 2]
    """
    _, first, of_row, size = np.unique(
        integers("label", label, -math.inf),
        return_index=True,
        return_inverse=True,
        return_counts=True,
    )
    rank = np.empty(len(size), np.int64)
    rank[np.lexsort((first, -size))] = np.arange(len(size))
    return rank[of_row]


def group_sizes(labels: np.ndarray) -> np.ndarray:
    """Agents of each group, int (G,), largest first as `group_labels` numbers them.

    `labels` is int (N,), -1 for agents in no group, which are not counted. Raises InputError.
    """
    label = labels_of(labels)
    return np.bincount(label[label >= 0]) if len(label) else np.empty(0, np.int64)


def algebraic_connectivity(n: int, links: np.ndarray, dim: int = 2) -> float:
    """The second-smallest eigenvalue of the graph Laplacian (Fiedler 1973); 0 if not connected.

    `links` (M, 2) are undirected pairs of rows in [0, n). Of use from 2 agents on; 0 for fewer.
    `dim` tells only how to go about it: the Laplacian of agents in the plane that have few
    neighbours is quickly factorised, in space or in a crowd that takes long and much memory, and
    iterating does not. Raises InputError.
    """
    from scipy.sparse.csgraph import laplacian
    from scipy.sparse.linalg import eigsh

    links = pairs(links, n)
    if n < 2 or group_labels(n, links).max() > 0:
        return 0.0
    matrix = laplacian(graph(n, links).tocsr())
    if n <= DENSE_UP_TO:
        return float(max(0.0, np.linalg.eigvalsh(matrix.toarray())[1]))
    start = np.random.default_rng(0).random(n)
    if dim == 2 and 2 * len(links) <= CROWDED * n:
        values = eigsh(matrix, k=2, sigma=-1e-3, v0=start)[0]
    else:
        values = eigsh(matrix, k=2, which="SA", v0=start, tol=1e-10)[0]
    return float(max(0.0, np.sort(values)[1]))


# Order within each connected group, and how large the groups are.
#
# Labels are int (N,), the group of each agent, 0..G-1, as `groups_within` and `group_labels` have
# them; -1 is an agent in none. Rows of which a number is missing are left out, with a warning; a
# group of which nobody stays has nan. What is no such array raises InputError.


def select_grouped(labels: np.ndarray, **arrays: np.ndarray) -> tuple[np.ndarray, ...]:
    """The size of each group (G,), and labels and arrays of those in a group that are numbers."""
    label = labels_of(labels)
    same_length(labels=label, **arrays)
    if label.size and label.min() < 0:
        inside = label >= 0
        label, arrays = label[inside], {name: array[inside] for name, array in arrays.items()}
    groups = int(label.max(initial=-1)) + 1
    finite, *finite_arrays = drop_bad_rows(**arrays)
    label = label if finite is None else label[finite]
    return np.bincount(label, minlength=groups), label, *finite_arrays


def group_means(size: np.ndarray, labels: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The mean of values (N, K) over each group, (G, K), of groups of these sizes (G,)."""
    columns = [np.bincount(labels, column, len(size)) for column in values.T]
    sums = np.stack(columns, axis=1)
    shares = np.full(sums.shape, np.nan)
    return np.divide(sums, size[:, None], out=shares, where=size[:, None] > 0)


def means(labels: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The mean of values (N, K) over each group, (G, K)."""
    size, label, values = select_grouped(labels, values=numbers("values", values, axes=2))
    return group_means(size, label, values)


def polarisations(labels: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Polarisation of each group, (G,), in [0, 1]: the length of its mean heading.

    Parameters
    ----------
    labels: int (N,), the group of each agent.
    heading: (N, dim) unit vectors.

    >>> east, west = [1.0, 0.0], [-1.0, 0.0]
    >>> polarisations(np.array([0, 0, 1]), np.array([east, west, west])).tolist()
    [0.0, 1.0]
    """
    size, label, heading = select_grouped(labels, heading=vectors("heading", heading))
    return lengths(group_means(size, label, units(heading)))


def lengths(mean: np.ndarray) -> np.ndarray:
    """Lengths of mean unit vectors (G, dim), at most 1 whatever the rounding; (G,)."""
    return np.minimum(1.0, np.linalg.norm(mean, axis=1))


def centres(labels: np.ndarray, position: np.ndarray, size, images) -> np.ndarray:
    """The centre of each group, (G, dim), length; along axes with images the mean on the circle.

    `position` is (N, dim), `size` (dim,) the sides of the box > 0, `images` (dim,) bool.
    """
    agents, label, position = select_grouped(labels, position=vectors("position", position))
    return middles(agents, label, position, *box(size, images, position.shape[1]))


def middles(agents, label, position, size, images) -> np.ndarray:
    """`centres` of groups of these many agents, of arrays that are checked."""
    turn = 2.0 * np.pi * position / size
    sine, cosine = (
        group_means(agents, label, np.sin(turn)),
        group_means(agents, label, np.cos(turn)),
    )
    mean_place = np.arctan2(sine, cosine) % (2.0 * np.pi) / (2.0 * np.pi) * size
    return np.where(images, mean_place, group_means(agents, label, position))


def angular_momenta(
    labels: np.ndarray, position: np.ndarray, heading: np.ndarray, size, images
) -> np.ndarray:
    """Angular momentum of each group about its own centre, (G,), in [0, 1].

    As `agents.observables.order.angular_momentum`, for every group: `labels` int (N,),
    `position` (N, dim), length, `heading` (N, dim), unit vectors, `size` (dim,) > 0, `images`
    (dim,) bool. A lone agent has 0.
    """
    position, heading = vectors("position", position), vectors("heading", heading)
    agents, label, position, heading = select_grouped(labels, position=position, heading=heading)
    return momenta(agents, label, position, units(heading), *box(size, images, position.shape[1]))


def momenta(agents, label, position, heading, size, images) -> np.ndarray:
    """`angular_momenta` of groups of these many agents, of arrays that are checked."""
    offset = position - middles(agents, label, position, size, images)[label]
    offset = offset - np.where(images, size * np.round(offset / size), 0.0)
    offset[agents[label] == 1] = 0.0
    largest = np.zeros(len(agents))
    np.maximum.at(largest, label, np.max(np.abs(position), axis=1, initial=0.0))
    along = outward_directions(offset, rounding(agents, largest, size, images)[label, None])
    if position.shape[1] == 2:
        turning = (along[:, 0] * heading[:, 1] - along[:, 1] * heading[:, 0])[:, None]
    else:
        turning = np.cross(along, heading)
    return lengths(group_means(agents, label, turning))


def size_histogram(labels: np.ndarray) -> dict[int, int]:
    """How many groups have each size that occurs, largest size first.

    >>> size_histogram(np.array([0, 0, 0, 1, 2]))
    {3: 1, 1: 2}
    """
    size = group_sizes(labels)
    value, count = np.unique(size[size > 0], return_counts=True)
    return {int(v): int(c) for v, c in zip(value[::-1], count[::-1], strict=True)}


def group_table(
    labels: np.ndarray, position: np.ndarray, heading: np.ndarray, size, images
) -> dict[int, dict[str, float]]:
    """Agents, polarisation and angular momentum of each group, by its label.

    `labels` is int (N,), 0 for the largest group as `group_labels` has it; `position` (N, dim),
    length, `heading` (N, dim), unit vectors, `size` (dim,) > 0, `images` (dim,) bool.
    """
    position, heading = vectors("position", position), vectors("heading", heading)
    agents, label, position, heading = select_grouped(labels, position=position, heading=heading)
    columns = (
        agents,
        lengths(group_means(agents, label, units(heading))),
        momenta(agents, label, position, heading, *box(size, images, position.shape[1])),
    )
    return {
        group: {"agents": int(n), "polarisation": float(phi), "angular-momentum": float(m)}
        for group, (n, phi, m) in enumerate(zip(*columns, strict=True))
    }
