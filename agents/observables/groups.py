"""Connected groups of the r-graph, and how firmly it is connected."""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, laplacian
from scipy.sparse.linalg import eigsh

from agents.observables.array_checks import integers, labels_of, pairs

DENSE_UP_TO = 400
"""Agents up to which the Laplacian's eigenvalues are found by the dense method."""
CROWDED = 40
"""Neighbours per agent from which iterating is quicker than factorising, in the plane too."""


def graph(n: int, links: np.ndarray) -> coo_array:
    """The adjacency matrix (n, n) of undirected links (M, 2), rows in [0, n). Raises InputError."""
    links = pairs(links, n)
    i, j = links[:, 0], links[:, 1]
    ones = np.ones(2 * len(links))
    return coo_array((ones, (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(n, n))


def group_labels(n: int, links: np.ndarray) -> np.ndarray:
    """The group of each agent, int (n,): 0 the largest, then by size, ties by first row.

    `links` (M, 2) are undirected pairs of rows in [0, n). Raises InputError.
    """
    links = pairs(links, n)
    return ranked(connected_components(graph(n, links), directed=False)[1]) if n else np.arange(0)


def ranked(label: np.ndarray) -> np.ndarray:
    """Groups numbered by their size, int (N,): 0 the largest, ties by the first row.

    `label` is int (N,), any numbers. Raises InputError.

    >>> ranked(np.array([7, 3, 3, 5])).tolist()
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
