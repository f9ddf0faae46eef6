"""Agents that catch others: who is caught at the end of a tick, and what becomes of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from agents.engine.heeding import CAUGHT
from agents.kinds import Relation
from agents.motion.gated_motion import GatedMotion
from agents.observables.neighbours import separation, tree
from agents.state.agent_rows import select_rows
from agents.state.start import free_positions, random_headings

SEEDS = 2**63
STRIDE = 0x9E3779B97F4A7C15
"""Between the seeds of places at two ticks, where who is caught begins anew."""


class Claims(NamedTuple):
    """Rows of hunters and of those whom they catch, int (M,) each."""

    hunters: np.ndarray
    prey: np.ndarray


def nearest_claims(claimant: np.ndarray, distance: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Which claims (M,) are each claimant's nearest; of equally near ones that of the lowest
    identity. Indices, one for each claimant, int."""
    order = np.lexsort((ids, distance, claimant))
    first = np.unique(claimant[order], return_index=True)[1]
    nearest: np.ndarray = order[first]
    return nearest


class HuntingMotion(GatedMotion):
    """State and ticks of a flock in which some kinds catch others.

    At the end of a tick each hunter claims the nearest of those that it has come within its
    distance of; if two claim one, the nearer has it. Nothing of it is in the compiled loop, which
    then runs one tick at a time.
    """

    def end_tick(self, before: np.ndarray) -> None:
        """End a tick that somebody else has run through the loop, from the places (N, dim) on."""
        self._came_from = self.ids.copy(), before
        self._count_ticks(1)

    def _catch(self) -> None:
        """Let each hunter catch one at most, by every relation in turn."""
        came_from = self._steps()
        self._came_from = None
        for hunter_kind, prey_kind, relation in self.kinds.catchers:
            step = np.zeros_like(self.position)
            if came_from is not None and len(came_from) == len(self.ids):
                step = came_from
            hunters = np.flatnonzero((self.arrays.kind == hunter_kind) & self.active)
            prey = np.flatnonzero((self.arrays.kind == prey_kind) & self.active)
            if len(hunters) and len(prey):
                claims = self._claims(hunters, prey, relation.catch, step)
                if len(claims.prey):
                    remaining = self._take_caught(claims, relation)
                    came_from = None if came_from is None else came_from[remaining]

    def _steps(self) -> np.ndarray | None:
        """How far each went in the last tick, (N, dim), length; None where it is not known."""
        if self._came_from is None or not np.array_equal(self._came_from[0], self.ids):
            return None
        size, images = self.world.size, self.world.images
        step: np.ndarray = separation(self._came_from[1], self.position, size, images)
        return step

    def _claims(
        self, hunters: np.ndarray, prey: np.ndarray, reach: float, step: np.ndarray
    ) -> Claims:
        """Who catches whom, of rows of hunters and of prey that came within `reach`, length.

        Within a tick agents go straight on, by `step` (N, dim). Nobody catches itself, where agents
        of a kind chase each other.
        """
        size, images = self.world.size, self.world.images
        ahead = (
            np.linalg.norm(step[hunters], axis=1).max() + np.linalg.norm(step[prey], axis=1).max()
        )
        near = tree(self.position[prey], size, images).query_ball_point(
            tree(self.position[hunters], size, images).data, reach + ahead
        )
        counts = [len(found) for found in near]
        hunter = hunters.repeat(counts)
        other = prey[np.concatenate([np.array(found, int) for found in near])]
        now = separation(self.position[hunter], self.position[other], size, images)
        moved = step[other] - step[hunter]
        length2 = (moved**2).sum(axis=1)
        # The least distance on the straight way from before the tick to now.
        back = np.clip((now * moved).sum(axis=1) / np.where(length2 > 0.0, length2, 1.0), 0.0, 1.0)
        distance = np.linalg.norm(now - back[:, None] * moved, axis=1)
        is_caught = (distance <= reach) & (hunter != other)
        hunter, other, distance = hunter[is_caught], other[is_caught], distance[is_caught]
        mine = nearest_claims(hunter, distance, self.ids[other])
        hunter, other, distance = hunter[mine], other[mine], distance[mine]
        theirs = nearest_claims(other, distance, self.ids[hunter])
        return Claims(hunter[theirs], other[theirs])

    def _take_caught(self, claims: Claims, relation: Relation) -> np.ndarray:
        """Do with those who are caught as the relation says; the rows that remain."""
        rows = claims.prey
        ids = self.ids[rows]
        self.catches = self.catches.with_more(
            self.tick, ids, self.ids[claims.hunters], self.position[rows]
        )
        everybody = np.arange(len(self.ids))
        if relation.caught == "taken":
            remaining = np.delete(everybody, rows)
            self._set_arrays(select_rows(self.arrays, remaining))
            self._match_members()
            return remaining
        if relation.caught == "frozen":
            self.arrays.kind[rows] = CAUGHT
            self.speed[rows] = 0.0
        elif relation.caught == "moved":
            seed = (self.seed + (self.tick + 1) * STRIDE) % SEEDS
            gap = self._start_gap(self.arrays.own[rows], self.arrays.kind[rows])
            self.position[rows] = free_positions(self.world, ids, seed, gap=gap)
            self.heading[rows] = random_headings(seed, ids, self.world.dim)
            self.arrays.memory[:, rows] = self.model.initial_columns[:, None]
        return everybody
