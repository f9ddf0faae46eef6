"""The Vicsek rule of the k nearest neighbours (Ballerini et al. 2008), agent by agent."""

import numpy as np

from .topology import distances


def nearest(position, k, size, edges, active=None):
    """For each agent the rows of the k nearest, nearest first; none in its own spot."""
    apart = distances(position, size, edges)
    there = np.ones(len(position), bool) if active is None else active
    found = []
    for i in range(len(position)):
        rows = [j for j in range(len(position)) if there[j] and apart[i, j] > 0]
        found.append(sorted(rows, key=lambda j: apart[i, j])[:k])
    return found


def is_clear(position, k, size, edges, margin=1e-9):
    """No agent's k-th nearest is, within `margin`, as far as its next, or in its spot."""
    apart = np.sort(distances(position, size, edges), axis=1)
    for row in apart:
        row = row[row > 0]
        if len(row) and row[0] < margin:
            return False
        if len(row) > k and row[k] - row[k - 1] < margin:
            return False
    return True


def means(position, heading, k, size, edges):
    """Sum of the headings of the k nearest and the agent's own, (N, dim)."""
    rows = nearest(position, k, size, edges)
    return np.array([heading[i] + sum(heading[j] for j in rows[i]) for i in range(len(rows))])
