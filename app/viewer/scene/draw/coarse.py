"""Places and attitudes as browsers are sent them: so fine that nobody sees it, and no finer.

What lies beyond is noise, of which a line that packs what it carries can make nothing.
"""

from __future__ import annotations

import math

import numpy as np

FINE = 2.0**-10
"""The widest step. The displayed world is about 10 units wide: where that is 4 000 pixels, a step
is 0.4 of them."""
OF_LENGTH = 1 / 256
"""A step as a share of an agent's length, at most: one may come close to small ones."""

ROUND = 1024
"""Azimuths of who is level; as few are found again by what packs, and 0.35 degrees are no pixel."""
OTHERWISE = 2.0**-11
"""Step of the attitudes of others."""

half = np.pi * np.arange(2 * ROUND) / ROUND
LEVEL = np.column_stack([np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)]).astype(np.float32)
"""All attitudes of who is level, (2 ROUND, 4)."""


def places(at: np.ndarray, length: float) -> np.ndarray:
    """Places (N, 3) of agents of some length, in steps that are a power of 2, float32.

    >>> places(np.array([[1.0 / 3.0, 0.0, 0.0]]), length=0.2)[0, 0]
    np.float32(0.3334961)
    """
    step = min(FINE, 2.0 ** math.floor(math.log2(max(OF_LENGTH * length, 1e-9))))
    return in_steps(at, step)


def turned(wxyz: np.ndarray) -> np.ndarray:
    """Attitudes (N, 4) to one of not too many, float32.

    >>> turned(np.array([[1.0, 0.0, 0.0, 0.001]])).tolist()
    [[1.0, 0.0, 0.0, 0.0]]
    """
    if wxyz[:, 1:3].any():
        return in_steps(wxyz, OTHERWISE)
    place = np.rint(np.arctan2(wxyz[:, 3], wxyz[:, 0]) * (ROUND / np.pi)).astype(int)
    return LEVEL[place % (2 * ROUND)]


def in_steps(numbers: np.ndarray, step: float) -> np.ndarray:
    """Numbers to the nearest step, float32."""
    return np.asarray(np.rint(np.multiply(numbers, 1.0 / step)) * step, np.float32)
