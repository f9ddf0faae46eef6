"""A flock with one player, stepped by `Flock` itself and rewarded one agent after the other."""

from __future__ import annotations

import numpy as np

from agents.flock import Flock
from agents.motion.agent_view import AgentView, wishes_of_actions


class LonePlayer:
    """The run of a seed, and of those that follow from it once it has ended."""

    def __init__(self, spec, reward, ticks, k, seed):
        self.flock, self.reward, self.ticks = Flock(spec), reward, ticks
        self.rng = np.random.default_rng(seed)
        self.view = AgentView(self.flock, k, 1)
        self.restart()

    def restart(self):
        """Begin the next run; what the player sees."""
        self.flock.restart(int(self.rng.integers(2**31)))
        self.player = int(self.flock.ids[self.flock.rows_of("robot")][0])
        return self.see()

    @property
    def row(self):
        """Where the player is, None once it is gone."""
        rows = np.flatnonzero(self.flock.ids == self.player)
        return int(rows[0]) if len(rows) and self.flock.active[rows[0]] else None

    def see(self):
        """What the player sees, zeros once it is gone."""
        if self.row is None:
            return np.zeros(self.view.width, np.float32)
        return self.view.look(np.array([self.row]))[0]

    def step(self, action):
        """Observation, reward, whether it is over, whether time is up."""
        flock = self.flock
        rows = flock.rows_of("robot")
        flock.steer("robot", wishes_of_actions(flock, rows, np.array([action]), 1.0))
        flock.run(1)
        is_over = self.row is None
        gained = getattr(self, self.reward)(is_over)
        return self.see(), gained, is_over, flock.tick >= self.ticks

    def evade(self, is_over):
        """1, or -10."""
        return -10.0 if is_over else 1.0

    def hunt(self, _is_over):
        """10 for each catch, -0.01."""
        catches = self.flock.catches
        mine = (catches.tick == self.flock.tick) & (catches.gate == self.player)
        return 10.0 * int(mine.sum()) - 0.01

    def align(self, _is_over):
        """The mean cosine with the others within reach."""
        flock, row = self.flock, self.row
        if row is None:
            return 0.0
        cosines = []
        for other in np.flatnonzero(flock.active):
            away = flock.position[other] - flock.position[row]
            size, images = np.array(flock.world.size), np.array(flock.world.images)
            away = np.where(images, away - size * np.round(away / size), away)
            if other != row and np.linalg.norm(away) <= self.view.reach:
                cosines.append(flock.heading[row] @ flock.heading[other])
        return float(np.mean(cosines)) if cosines else 0.0
