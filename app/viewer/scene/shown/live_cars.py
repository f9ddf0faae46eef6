"""What the picture has to know of a room with real cars, beside places and headings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

STATES = TRACKED, LATE, LOST, STOPPED, SIMULATED = (
    "tracked",
    "late",
    "lost",
    "stopped",
    "simulated",
)
"""What a car in the picture may be."""


@dataclass(frozen=True)
class Live:
    """A room at one tick. The real cars come first, then the simulated ones."""

    names: tuple[str, ...]
    """Of all N cars in the picture; one that was never seen is not in it."""
    roster: tuple[str, ...]
    """Of all cars of the room, seen or not, in an order that stays."""
    states: tuple[str, ...]
    """One of `STATES` each."""
    ages: np.ndarray
    """(N,) seconds since each was last seen; 0 for simulated ones."""
    fence: float
    """How far inside the area the cars are stopped, m."""
    arm: str
    """safe, armed or emergency."""

    def are(self, *states: str) -> np.ndarray:
        """Which of the cars are in one of these states, (N,) bool."""
        return np.array([state in states for state in self.states], dtype=bool)
