"""Naive versions of what is measured, from positions (N, dim) and headings (N, dim)."""

import math

import numpy as np

from .topology import distances

AGREED = 0.9984  # Deg_con^d of Liu et al., Aerospace 2021, section 3.1


def polarisation(heading):
    """Length of the mean heading, 0 to 1."""
    return math.sqrt((heading.mean(axis=0) ** 2).sum())


def wrapped(angle):
    """An angle difference (rad) brought into (-pi, pi]."""
    angle = math.fmod(angle, math.tau)
    if angle > math.pi:
        return angle - math.tau
    if angle <= -math.pi:
        return angle + math.tau
    return angle


def direction(heading):
    """Degrees from the x axis to the sum of the headings, by the cosine; (N, dim) unit vectors."""
    total = [sum(axis) for axis in zip(*heading, strict=True)]
    return math.degrees(math.acos(total[0] / math.hypot(*total)))


def fast_in_front(offset, velocity):
    """Spearman's rank correlation by the differences of ranks, where no two are equal.

    `offset` (N, dim) from the centre, `velocity` (N, dim).
    """
    way = [sum(axis) for axis in zip(*velocity, strict=True)]
    speed = [math.hypot(*v) for v in velocity]
    ahead = [sum(a * b for a, b in zip(x, way, strict=True)) for x in offset]
    n = len(speed)
    ranks = [[sum(b < a for b in values) for a in values] for values in (speed, ahead)]
    squares = sum((a - b) ** 2 for a, b in zip(*ranks, strict=True))
    return 1.0 - 6.0 * squares / (n * (n * n - 1))


def consistency(theta, theta_ref):
    """Deg_con of equations (28, 29) from angles theta (N,) and a reference angle, all in rad."""
    square = sum(wrapped(t - theta_ref) ** 2 for t in theta)
    return 1 - math.sqrt(square) / (len(theta) * math.pi)


def consistency_of_headings(heading, reference):
    """Equations (28, 29) in any dimension: the angle between each heading and a unit vector.

    The angle is 2 atan2(|u - v|, |u + v|), exact near 0 and pi where acos is not.
    """
    square = 0.0
    for u in heading:
        apart = math.dist(u, reference)
        along = math.dist(u, [-v for v in reference])
        square += (2 * math.atan2(apart, along)) ** 2
    return 1 - math.sqrt(square) / (len(heading) * math.pi)


def convergence_time(series, level=AGREED):
    """k_con of equation (27): last tick below `level`, plus 1; None if it is still below."""
    below = [k for k, value in enumerate(series) if value < level]
    if not below:
        return 0
    return None if below[-1] == len(series) - 1 else below[-1] + 1


def nearest_neighbour_distance(position, size, edges):
    """Distance of each agent to the nearest other one, (N,); inf for a lone agent."""
    distance = distances(position, size, edges)
    n = len(position)
    return np.array([min([math.inf, *np.delete(distance[i], i)]) for i in range(n)])


def groups(touch):
    """Connected groups of the contact graph: labels (N,), by first member, and their sizes."""
    n = len(touch)
    label = np.full(n, -1)
    sizes = []
    for first in range(n):
        if label[first] >= 0:
            continue
        label[first] = len(sizes)
        pending, size = [first], 0
        while pending:
            i = pending.pop()
            size += 1
            for j in range(n):
                if touch[i, j] and label[j] < 0:
                    label[j] = len(sizes)
                    pending.append(j)
        sizes.append(size)
    return label, sizes


def largest_group(touch):
    """Number of agents in the largest connected group."""
    return max(groups(touch)[1])


def mean_neighbours(touch):
    """Mean number of neighbours per agent."""
    return sum(sum(row) for row in touch.astype(int)) / len(touch)


def algebraic_connectivity(touch):
    """Second-smallest eigenvalue of the Laplacian of the contact graph (Fiedler); 0 for N < 2."""
    if len(touch) < 2:
        return 0.0
    laplacian = np.diag(touch.sum(axis=1)) - touch.astype(float)
    return float(np.sort(np.linalg.eigvalsh(laplacian))[1])


def layer_histogram(layer):
    """How many agents are in layers 1, 2, ..., N, and last in none (N + 1 = unknown): (N + 1,)."""
    n = len(layer)
    return np.array([sum(value == k for value in layer) for k in range(1, n + 2)])
