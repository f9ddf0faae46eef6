"""Connected groups of the r-graph, and how firmly it is connected."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, laplacian
from scipy.sparse.linalg import eigsh

DENSE_UP_TO = 400
"""Agents up to which the Laplacian's eigenvalues are found by the dense method."""


def graph(n: int, links: np.ndarray) -> coo_array:
    """The adjacency matrix (n, n) of undirected links (M, 2)."""
    i, j = links[:, 0], links[:, 1]
    ones = np.ones(2 * len(links))
    return coo_array((ones, (np.concatenate([i, j]), np.concatenate([j, i]))), shape=(n, n))


def group_labels(n: int, links: np.ndarray) -> np.ndarray:
    """The group of each agent, int (n,): 0 the largest, then by size, ties by first row."""
    if n == 0:
        return np.empty(0, np.int64)
    count, label = connected_components(graph(n, links), directed=False)
    size = np.bincount(label, minlength=count)
    first = np.full(count, n)
    np.minimum.at(first, label, np.arange(n))
    rank = np.empty(count, np.int64)
    rank[np.lexsort((first, -size))] = np.arange(count)
    return rank[label]


def group_sizes(labels: np.ndarray) -> np.ndarray:
    """Sizes of the groups, largest first."""
    return np.bincount(labels) if len(labels) else np.empty(0, np.int64)


def algebraic_connectivity(n: int, links: np.ndarray) -> float:
    """The second-smallest eigenvalue of the graph Laplacian (Fiedler 1973); 0 if not connected.

    Of use from 2 agents on; 0 for fewer.
    """
    if n < 2 or group_labels(n, links).max() > 0:
        return 0.0
    matrix = laplacian(graph(n, links).tocsr())
    if n <= DENSE_UP_TO:
        return float(max(0.0, np.linalg.eigvalsh(matrix.toarray())[1]))
    start = np.random.default_rng(0).random(n)
    return float(max(0.0, np.sort(eigsh(matrix, k=2, sigma=-1e-3, v0=start)[0])[1]))
