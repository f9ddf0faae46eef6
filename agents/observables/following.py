"""Who keeps up with the information agents, and how close things came, over a run's positions."""

from __future__ import annotations

import math

import numpy as np

from agents.engine.cache import kept
from worlds.ground import nearest_surface


@kept
def nearest_pairs(trace, least2):
    """Bring `least2` (N, N), the least squared distance of each pair so far, up to date.

    `trace` is (T, dim, N), positions of T ticks, length. Only least2[i, j] with i < j is used.
    """
    ticks, dim, n = trace.shape
    for t in range(ticks):
        for i in range(n):
            for j in range(i + 1, n):
                dx = trace[t, 0, j] - trace[t, 0, i]
                dy = trace[t, 1, j] - trace[t, 1, i]
                d2 = dx * dx + dy * dy
                if dim == 3:
                    dz = trace[t, 2, j] - trace[t, 2, i]
                    d2 += dz * dz
                least2[i, j] = min(least2[i, j], d2)


@kept
def least_clearances(trace, ground, least):
    """Bring `least` (N,), each agent's least signed distance to a surface, up to date.

    `trace` is (T, dim, N), positions of T ticks, length.
    """
    ticks, dim, n = trace.shape
    if ground.solids == 0:
        return
    for t in range(ticks):
        for i in range(n):
            z = trace[t, 2, i] if dim == 3 else 0.0
            at = nearest_surface(ground, trace[t, 0, i], trace[t, 1, i], z)
            least[i] = min(least[i], at.distance)


@kept
def keep_following(trace, informed, r, follows, reached, queue):
    """Clear `follows` (N,) for agents that at some tick are cut off from the information agents.

    An agent follows while it is in the component of an information agent in the graph of all pairs
    within r (length). `trace` is (T, dim, N), `informed` (N,) bool; `reached` (N,) bool and
    `queue` (N,) int are working space. Liu et al. 2021, section 3.2.
    """
    ticks, dim, n = trace.shape
    for t in range(ticks):
        tail = 0
        for i in range(n):
            reached[i] = informed[i]
            if informed[i]:
                queue[tail] = i
                tail += 1
        at = 0
        while at < tail:
            i = queue[at]
            at += 1
            for j in range(n):
                if not reached[j]:
                    d2 = 0.0
                    for axis in range(dim):
                        d = trace[t, axis, j] - trace[t, axis, i]
                        d2 += d * d
                    if d2 <= r * r:
                        reached[j] = True
                        queue[tail] = j
                        tail += 1
        for i in range(n):
            follows[i] = follows[i] and reached[i]


KERNELS = (nearest_pairs, least_clearances, keep_following)


def spread_bound(n: int, d: float) -> float:
    """How far from its goal the outermost of n agents may be that stand around it at distance d.

    1.35 times the radius of a hexagonal lattice of spacing d (length) with n places.

    >>> round(spread_bound(30, 4.0), 2)
    15.53
    """
    return 1.35 * d * math.sqrt(n * math.sqrt(3.0) / (2.0 * math.pi))


def settling_tick(distance: np.ndarray, within: float) -> int | None:
    """The first index from which `distance` (T,) stays <= `within`, both length; None if never.

    >>> settling_tick(np.array([5.0, 1.0, 3.0, 1.5, 1.0]), 2.0)
    3
    """
    away = np.flatnonzero(~(distance <= within))
    if len(away) == 0:
        return 0
    return int(away[-1]) + 1 if away[-1] + 1 < len(distance) else None
