"""A reward: what each steered agent gains in a tick."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from agents.flock import Flock
from agents.observables.neighbours import separation


@dataclass(frozen=True)
class StepResult:
    """A flock after a tick, and the agents that are rewarded for it by a function of one's own."""

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


class PlayerTick(NamedTuple):
    """A player after a tick, as compiled rewards see it."""

    flock: Any
    """Its flock's `agents.engine.arrays.Arrays`."""
    surroundings: Any
    tables: Any
    """What is known of all flocks, `app.learning.batch_step.BatchTables`."""
    e: int
    """The number of its flock."""
    m: int
    """Its number among the flock's players."""


@dataclass(frozen=True)
class Reward:
    """What steered agents are to learn."""

    name: str
    summary: str
    """One sentence for who chooses."""
    gain: Any
    """What a player gains in a tick, compiled: `PlayerTick` -> float."""
    needs_goal: bool = False
    """Whether it is for worlds with a goal alone."""
