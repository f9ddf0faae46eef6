"""Stability of a periodic flight: Floquet's multipliers."""

from __future__ import annotations

import numpy as np

from agents.flight.aircraft import Aircraft
from agents.flight.flight_motion import MOVING, Controls, integrate

STEP = 1e-5
"""Difference of the state, m/s, rad/s and rad, by which the derivative is taken."""


def monodromy(craft: Aircraft, controls: Controls, start: np.ndarray) -> np.ndarray:
    """What a wing beat makes of a small difference in u, w, q, theta and the slowed inflows.

    `start` is the state (SIZE,) at the beginning of a beat; returns a matrix in the order of
    `motion.MOVING`, taken by central differences. Raises InputError.
    """
    moves = STEP * np.eye(start.size)[MOVING]
    starts = np.concatenate((start + moves, start - moves))
    beat = controls.flapping.period
    ends = integrate(craft, controls, starts, beat, np.array([beat]))[0][:, MOVING]
    return (ends[: len(moves)] - ends[len(moves) :]).T / (2.0 * STEP)


def multipliers(matrix: np.ndarray) -> np.ndarray:
    """Floquet's multipliers of a monodromy matrix, complex, the largest first.

    A flight is stable where all are inside of the unit circle.

    >>> multipliers(np.diag([0.1, -0.5]))
    array([-0.5+0.j,  0.1+0.j])
    """
    found = np.linalg.eigvals(matrix)
    return found[np.argsort(-np.abs(found), kind="stable")]
