"""How close the agents of a run have come to each other and to what is solid."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.observables.following import (
    bring_clearances,
    bring_pairs,
    least_clearances,
    nearest_pairs,
)

MOST_AGENTS = 256
"""Of a larger flock the distances between agents are not kept: there are too many pairs."""


@dataclass
class MinimumDistances:
    """Least distances over the run, every tick of it."""

    flock: Flock
    pairs: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    """Least squared distance of each two rows so far, (N, N) above the diagonal, length^2."""
    keeps: bool = True
    """Whether anything is kept; not of a flock that is put here and there."""
    clearance: np.ndarray = field(default_factory=lambda: np.empty(0))
    """Least signed distance of each row to a surface so far, (N,), length; inf far from all."""

    @property
    def wanted(self) -> bool:
        """Whether the flock is watched: few agents, on a mission or among what is solid.

        Where agents crash there is no need: the crashes tell how close they came.
        """
        world = self.flock.world
        few = len(self.flock.ids) <= MOST_AGENTS and not self.flock.can_crash
        return self.keeps and few and (world.mission is not None or world.is_solid)

    @property
    def kernels(self) -> tuple[Any, ...]:
        """What is compiled to watch it."""
        return (bring_pairs, bring_clearances) if self.wanted else ()

    def run(self, ticks: int) -> None:
        """Run the flock, and watch it if it is to be watched."""
        if not self.wanted:
            self.flock.advance(ticks)
            return
        self.watch(self.flock.position[None])
        self.watch(self.flock.trace(ticks))

    def watch(self, trace: np.ndarray) -> None:
        """Take in the positions (T, N, dim) of some ticks."""
        n = trace.shape[1]
        if len(self.clearance) != n:
            self.pairs, self.clearance = np.full((n, n), np.inf), np.full(n, np.inf)
        by_axis = np.ascontiguousarray(trace.transpose(0, 2, 1))
        if not self.flock.world.images.any():
            nearest_pairs(by_axis, self.pairs)
        least_clearances(by_axis, self.flock.engine.surroundings, self.clearance)

    @property
    def least(self) -> tuple[float, float]:
        """The least squared distance of two agents so far, and the least one to a surface."""
        return float(self.pairs.min(initial=np.inf)), float(self.clearance.min(initial=np.inf))

    def take(self, least: tuple[float, float]) -> None:
        """Go on from what was the `least` at an earlier tick, whichever agents it was."""
        self.pairs[:], self.clearance[:] = np.inf, np.inf
        self.pairs[:1, 1:2], self.clearance[:1] = least

    def values(self) -> dict[str, float]:
        """What has been seen: least distances over the run, and who is inside something now."""
        if not self.wanted:
            return {}
        position = self.flock.position[None]
        self.watch(position)
        found = {}
        if not self.flock.world.images.any():
            found["least-gap"] = float(np.sqrt(self.pairs.min(initial=np.inf)))
        if self.flock.world.is_solid:
            now = np.full(position.shape[1], np.inf)
            by_axis = np.ascontiguousarray(position.transpose(0, 2, 1))
            least_clearances(by_axis, self.flock.engine.surroundings, now)
            found["least-clearance"] = float(self.clearance.min(initial=np.inf))
            found["inside"] = float(np.count_nonzero(now < 0.0))
        return found
