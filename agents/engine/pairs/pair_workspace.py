"""What a thread writes down for itself while agents act eight at a time."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from agents.engine.heeding import COLUMNS
from agents.engine.vector_lanes import WIDTH

X, Y, Z, UX, UY, UZ, SPEED = range(7)
"""Rows of the table in which the moves of eight agents are written down."""
CHOSEN = 256
"""Candidates that are picked out at a time."""


class PairWorkspace(NamedTuple):
    """What a thread writes down for itself."""

    table: np.ndarray
    """Sums and moves of eight agents, (SPEED + 1 or as many sums, 8)."""
    ids: np.ndarray
    """Their numbers, (8,)."""
    chosen: np.ndarray
    """Slots of candidates that are within reach, (CHOSEN,)."""
    least: np.ndarray
    """The least squares of distances of eight agents so far, in order, (k, 8)."""
    memory: np.ndarray
    """What eight agents keep to themselves, (PRIVATE, 8), where they answer at once."""
    found: np.ndarray
    """Boundary points around one agent: indices, int32 (points,)."""
    points: np.ndarray
    """Their coordinates, (2, points)."""
    spare: np.ndarray
    """For the rule's own working with them, (4, points)."""
    one_cell: np.ndarray
    """The shape of a grid of one cell, (3,)."""
    all_slots: np.ndarray
    """Where the slots of that cell begin and end, (2,)."""
    relations: np.ndarray
    """What eight agents have to do with each kind, (K COLUMNS, 8)."""


def empty_notes(
    number: int, private: int, points: int, index: Any, nearest: int = 1, kinds: int = 0
) -> PairWorkspace:
    """Notes of nothing yet; slots are numbered by `index`.

    For so many sums, numbers that each agent keeps to itself, boundary points around one, nearest
    agents, and kinds.
    """
    return PairWorkspace(
        np.zeros((max(SPEED + 1, number), WIDTH)),
        np.zeros(WIDTH, np.int64),
        np.zeros(CHOSEN, np.uint64),
        np.zeros((nearest, WIDTH)),
        np.zeros((private, WIDTH)),
        np.zeros(points, np.int32),
        np.zeros((2, points)),
        np.zeros((4, points)),
        np.ones(3, np.int64),
        np.zeros(2, index),
        np.zeros((kinds * COLUMNS, WIDTH)),
    )
