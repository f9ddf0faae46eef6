"""One steered agent of a flock as an `Env` of Gymnasium."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from agents.flock import Flock
from agents.spec import Spec
from app.learning.flock_batch import FlockBatch
from app.learning.reward import StepResult
from worlds.input_error import InputError


class SingleAgentEnv(gymnasium.Env):
    """A flock of which one agent is steered, see `FlockEnv`. Raises InputError for several."""

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - as in Gymnasium

    def __init__(
        self,
        spec: Spec,
        kind: str,
        k: int = 6,
        ticks: int = 200,
        reward: str | Callable[[StepResult], np.ndarray] = "align",
        scale: float = 1.0,
    ) -> None:
        self.batch = FlockBatch(spec, 1, kind, k, ticks, reward, scale)
        players = self.batch.tables.ids.shape[1]
        if players != 1:
            raise InputError(f"kind {kind} has {players} agents: Gymnasium steers one")
        self.observation_space = Box(-1.0, 1.0, (self.batch.width,), np.float32)
        self.action_space = Box(-1.0, 1.0, (self.batch.action_size,), np.float32)
        self._has_ended = True

    @property
    def flock(self) -> Flock:
        """The flock, as it is now; what is made of it counts from the next tick on."""
        if not self.batch.is_shared:
            self.batch.share()
        return self.batch.flocks[0]

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002 - as in Gymnasium
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin anew; with a seed, the run of that seed, else one that follows from the last."""
        super().reset(seed=seed)
        self.batch.restart([0], [seed])
        self.batch.look(self.batch.all)
        self._has_ended = False
        return self.batch.tables.seen[0, 0].copy(), {}

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Run a tick with an action."""
        if self._has_ended:
            raise InputError("the run has ended, or not begun: reset() begins anew")
        batch, tables = self.batch, self.batch.tables
        actions = batch.check_action(action, "action")[None, None]
        batch.step(actions, batch.all)
        is_over = bool(tables.is_over[0, 0])
        is_late = bool(batch.has_ended[0])
        self._has_ended = is_over or is_late
        return tables.seen[0, 0].copy(), float(tables.gained[0, 0]), is_over, is_late, {}
