"""Agents keep their identities while rows come and go."""

from __future__ import annotations

import numpy as np


def rows_of(before: np.ndarray, now: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows in `before` of those identities in `now` that are there, and which they are, bool."""
    if not len(before):
        return np.empty(0, dtype=int), np.zeros(len(now), dtype=bool)
    order = np.argsort(before)
    place = np.minimum(np.searchsorted(before, now, sorter=order), len(before) - 1)
    row = order[place]
    known = before[row] == now
    return row[known], known
