"""Degree of consistency with a reference heading, and the time to reach it (Liu et al. 2021)."""

from __future__ import annotations

import math

import numpy as np

from agents.engine.arrays import EngineStopCondition
from agents.observables.array_checks import column, headings, numbers
from worlds.compilation import compiled
from worlds.input_error import InputError

DESIRED = 0.9984
"""Deg_con^d, the degree at which Liu et al. 2021 call a flock consistent (section 3.1)."""
HOLD = 60
"""Ticks for which it must hold before it is believed."""


@compiled
def squared_angle(heading, i, x, y, z):
    """Square of the angle (rad) between row i and a unit vector; exact for small and large."""
    dx, dy = heading[i, 0] - x, heading[i, 1] - y
    sx, sy = heading[i, 0] + x, heading[i, 1] + y
    distance2 = dx * dx + dy * dy
    along = sx * sx + sy * sy
    if heading.shape[1] == 3:
        dz, sz = heading[i, 2] - z, heading[i, 2] + z
        distance2 += dz * dz
        along += sz * sz
    angle = 2.0 * math.atan2(math.sqrt(distance2), math.sqrt(along))
    return angle * angle


@compiled
def mean_direction(heading):
    """Unit vector (x, y, z) of the mean heading; (1, 0, 0) if it vanishes."""
    x = y = z = 0.0
    for i in range(heading.shape[0]):
        x += heading[i, 0]
        y += heading[i, 1]
        if heading.shape[1] == 3:
            z += heading[i, 2]
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-12:
        return 1.0, 0.0, 0.0
    return x / length, y / length, z / length


@compiled
def is_consistent(flock, numbers):
    """Whether the squared angles (rad^2) to the reference sum to at most a bound.

    `numbers` are the bound and the reference (x, y, z), or the bound alone where it is the mean
    heading; what a run of the engine may go on until.
    """
    heading, bound = flock.heading, numbers[0]
    if numbers.shape[0] > 1:
        x, y, z = numbers[1], numbers[2], numbers[3]
    else:
        x, y, z = mean_direction(heading)
    total = 0.0
    for i in range(heading.shape[0]):
        total += squared_angle(heading, i, x, y, z)
        if total > bound:
            return False
    return True


def reference_vector(heading: np.ndarray, reference) -> np.ndarray:
    """A unit vector: an angle (rad, 2-D), a vector, or None for the direction of the mean heading.

    The mean direction of headings that cancel out, or of nobody, is the first axis. Raises
    InputError.
    """
    if reference is None:
        reference = heading.mean(axis=0) if len(heading) else np.zeros(heading.shape[1])
        if np.linalg.norm(reference) * len(heading) < 1e-12:
            reference = np.eye(heading.shape[1])[0]
    vector = np.atleast_1d(numbers("reference", reference))
    if vector.shape == (1,) and math.isfinite(vector[0]):
        return np.array([math.cos(vector[0]), math.sin(vector[0])])
    size = float(np.linalg.norm(vector)) if vector.shape in ((2,), (3,)) else math.nan
    if not 0.0 < size < math.inf:
        raise InputError(
            f"reference = {vector.tolist()} is not allowed: a finite angle (rad), or a vector that "
            "is not zero, is needed"
        )
    return vector / size


def consistency(heading: np.ndarray, reference=None) -> float:
    """Degree of consistency Deg_con of headings with a reference (Liu et al. 2021 (28), (29)).

    Parameters
    ----------
    heading: (N, dim) unit vectors; rows that are no numbers are left out, with a warning.
    reference: theta^d as an angle (rad, 2-D) or a vector (dim,); None takes the mean heading, as
        for models that do not converge to a given direction.

    Returns
    -------
    1 - sqrt(sum of squared angles) / (N pi), in [0, 1]; 1 for an empty flock. Raises InputError.

    >>> consistency(np.array([[1.0, 0.0], [1.0, 0.0]]), 0.0)
    1.0
    """
    heading = headings(heading)
    n, dim = heading.shape
    target = reference_vector(heading, reference)
    if len(target) != dim:
        raise InputError(f"reference has {len(target)} axes and heading {dim}")
    if n == 0:
        return 1.0
    distance = np.linalg.norm(heading - target, axis=1)
    along = np.linalg.norm(heading + target, axis=1)
    angle = 2.0 * np.arctan2(distance, along)
    return 1.0 - float(np.linalg.norm(angle)) / (n * math.pi)


def convergence_time(degrees, desired: float = DESIRED) -> int | None:
    """k_con (27): the first tick from which the degree of consistency stays at `desired` or above.

    `degrees` (K,) holds Deg_con for k = 0, 1, 2, ...; None if its last value is below `desired`, or
    without values. A tick whose value is nan is not known to be at `desired`, and so is not. Raises
    InputError.

    >>> convergence_time([0.5, 0.9990, 0.7, 0.9985, 0.9990])
    3
    """
    degree = column("degrees", degrees)
    unmet = np.flatnonzero(~(degree >= desired))
    k = 0 if unmet.size == 0 else int(unmet[-1]) + 1
    return k if k < len(degree) else None


def stop_when_consistent(
    n: int, reference, desired: float = DESIRED, hold: int = HOLD
) -> EngineStopCondition:
    """When n agents are consistent: Deg_con >= desired has held for `hold` ticks. Or InputError."""
    bound = ((1.0 - desired) * n * math.pi) ** 2
    if reference is None:
        return EngineStopCondition(np.array([bound]), hold, -1)
    vector = reference_vector(np.empty((0, 2)), reference)
    return EngineStopCondition(np.array([bound, *vector, 0.0][:4]), hold, -1)
