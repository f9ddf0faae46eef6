"""A reward: what each steered agent gains in a tick."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from agents.flock import Flock
from agents.observables.neighbours import separation


@dataclass(frozen=True)
class StepResult:
    """A flock after a tick, and the agents that are rewarded for it."""

    flock: Flock
    ids: np.ndarray
    """Identities of the agents that were steered in the tick, (S,)."""
    rows: np.ndarray
    """Their rows now, -1 for who is gone, (S,)."""
    is_over: np.ndarray
    """Who was caught or has crashed in the tick, (S,) bool."""

    @property
    def others(self) -> np.ndarray:
        """Rows of all other agents that have not been caught, (M,)."""
        rows = np.flatnonzero(self.flock.active)
        return rows[~np.isin(self.flock.ids[rows], self.ids)]

    def distances(self, rows: np.ndarray) -> np.ndarray:
        """From each of the steered agents to each agent of rows (M,), (S, M); inf for who is
        gone."""
        flock = self.flock
        distance = np.full((len(self.ids), len(rows)), np.inf)
        here = self.rows >= 0
        away = separation(
            flock.position[self.rows[here], None],
            flock.position[None, rows],
            flock.world.size,
            flock.world.images,
        )
        distance[here] = np.linalg.norm(away, axis=2)
        return distance


@dataclass(frozen=True)
class Reward:
    """What steered agents are to learn."""

    name: str
    summary: str
    """One sentence for who chooses."""
    compute: Callable[[StepResult], np.ndarray]
    """What each gains in a tick, (S,)."""
