"""Layers below the information agents: hops through the r-graph (Liu et al. 2021, (2) to (4))."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import dijkstra

from agents.observables.array_checks import flags, integers, pairs
from agents.observables.groups import graph


def layers(links: np.ndarray, informed: np.ndarray) -> np.ndarray:
    """Layer of each agent, int (N,): 1 information agent, 2 in contact with one; N + 1 unknown.

    `links` are undirected pairs of rows (M, 2), `informed` (N,) bool. Raises InputError.
    """
    informed = flags("informed", informed)
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
