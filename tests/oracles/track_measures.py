"""Naive versions of what is measured of tracks, one individual and one frame at a time."""

import math

import numpy as np


def parabola(places, k):
    """Value, slope and curvature in the middle of the parabola through places at offsets k."""
    c, b, a = np.polyfit(k, places, 2)
    return a, b, 2.0 * c


def smoothed(position, frames, step):
    """Place, velocity and acceleration (T, N, dim) by a fit in each window; NaN where one is not
    whole."""
    m = frames // 2
    results = [np.full(position.shape, np.nan) for _ in range(3)]
    k = np.arange(-m, m + 1)
    for t in range(m, len(position) - m):
        for i in range(position.shape[1]):
            window = position[t - m : t + m + 1, i]
            if np.isfinite(window).all():
                for axis in range(position.shape[2]):
                    place, slope, bend = parabola(window[:, axis], k)
                    for array, value in zip(
                        results, (place, slope / step, bend / step**2), strict=True
                    ):
                        array[t, i, axis] = value
    return results


def nearest_image(offset, size, images):
    """An offset to the nearest image."""
    return [d - s * math.floor(d / s + 0.5) if w else d
            for d, s, w in zip(offset, size, images, strict=True)]  # fmt: skip


def neighbour_counts(position, heading, turn, size, images, reach, bins):
    """Neighbours, and turns summed and counted, in cells [behind to ahead, left to right]."""
    pairs, sums, counted = (np.zeros((bins, bins)) for _ in range(3))
    for x, u, turns in zip(position, heading, turn, strict=True):
        for i in range(len(x)):
            if not np.isfinite([*x[i], *u[i]]).all():
                continue
            for j in range(len(x)):
                if i == j or not np.isfinite(x[j]).all():
                    continue
                dx, dy = nearest_image(x[j] - x[i], size, images)
                angle = math.atan2(u[i][1], u[i][0])
                ahead = dx * math.cos(angle) + dy * math.sin(angle)
                left = -dx * math.sin(angle) + dy * math.cos(angle)
                if abs(ahead) < reach and abs(left) < reach:
                    row = min(int((ahead + reach) / (2 * reach) * bins), bins - 1)
                    column = min(int((-left + reach) / (2 * reach) * bins), bins - 1)
                    pairs[row, column] += 1
                    if math.isfinite(turns[i]):
                        counted[row, column] += 1
                        sums[row, column] += turns[i]
    return pairs, sums, counted


def delay_curve(first, second, longest):
    """C(tau) for tau from -longest to longest of headings (T, dim); NaN for too few frames."""
    curve = []
    for lag in range(-longest, longest + 1):
        products = [
            float(np.dot(first[t], second[t + lag]))
            for t in range(len(first))
            if 0 <= t + lag < len(first) and np.isfinite([*first[t], *second[t + lag]]).all()
        ]
        curve.append(np.mean(products) if len(products) >= 2 * longest + 1 else math.nan)
    return curve


def gamma(position, direction, k):
    """gamma_k of all individuals, in an open space, whatever the border."""
    matrix = np.zeros((position.shape[1],) * 2)
    for i in range(len(position)):
        apart = sorted((math.dist(position[i], x), j) for j, x in enumerate(position) if j != i)
        _, j = apart[k - 1]
        unit = (position[j] - position[i]) / math.dist(position[i], position[j])
        matrix += np.outer(unit, unit)
    least = np.linalg.eigh(matrix / len(position))[1][:, 0]
    return float(least @ (direction / np.linalg.norm(direction))) ** 2
