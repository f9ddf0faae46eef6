"""Naive versions of what is measured of groups, of fluctuations and of a run, pair by pair."""

import math

import numpy as np

from .topology import offsets


def groups_of(labels):
    """The rows of each group 0, 1, ..., a list of lists."""
    return [[i for i, g in enumerate(labels) if g == k] for k in range(max(labels) + 1)]


def length_of_mean(vectors):
    """The length of the mean of vectors."""
    dim, n = len(vectors[0]), len(vectors)
    return math.sqrt(sum((sum(v[axis] for v in vectors) / n) ** 2 for axis in range(dim)))


def fluctuations(velocity):
    """Each velocity without the mean of all."""
    n, dim = len(velocity), len(velocity[0])
    mean = [sum(v[axis] for v in velocity) / n for axis in range(dim)]
    return [[v[axis] - mean[axis] for axis in range(dim)] for v in velocity]


def correlation(position, velocity, size, edges, width):
    """Bins that have pairs: mean distance, C(r) and number of pairs, three lists."""
    u = fluctuations(velocity)
    n = len(u)
    at_no_distance = sum(sum(c * c for c in one) for one in u) / n
    off = offsets(np.asarray(position), size, edges)
    bins = {}
    for i in range(n):
        for j in range(i + 1, n):
            r = math.sqrt(sum(float(d) ** 2 for d in off[i, j]))
            product = sum(a * b for a, b in zip(u[i], u[j], strict=True))
            bins.setdefault(math.floor(r / width), []).append((r, product))
    found = [bins[k] for k in sorted(bins)]
    return (
        [sum(r for r, _ in pairs) / len(pairs) for pairs in found],
        [sum(c for _, c in pairs) / len(pairs) / at_no_distance for pairs in found],
        [len(pairs) for pairs in found],
    )


def first_zero(distance, value):
    """Where straight lines from (0, 1) through the points first come to 0."""
    before = (0.0, 1.0)
    for r, c in zip(distance, value, strict=True):
        if c <= 0.0:
            return before[0] + before[1] / (before[1] - c) * (r - before[0])
        before = (r, c)
    return math.nan


def susceptibility(series, n):
    """N times the mean square less the square of the mean."""
    k = len(series)
    return n * (sum(x * x for x in series) / k - (sum(series) / k) ** 2)


def binder(series):
    """1 - <x^4> / (3 <x^2>^2)."""
    k = len(series)
    return 1.0 - (sum(x**4 for x in series) / k) / (3.0 * (sum(x**2 for x in series) / k) ** 2)
