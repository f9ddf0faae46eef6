"""One steered agent of a flock as an `Env` of Gymnasium."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from agents.spec import Spec
from app.learning.flock_env import FlockEnv
from worlds.input_error import InputError


class SingleAgentEnv(gymnasium.Env):
    """A flock of which one agent is steered, see `FlockEnv`. Raises InputError for several."""

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - as in Gymnasium

    def __init__(self, spec: Spec, kind: str, **options: Any) -> None:
        self.flock_env = FlockEnv(spec, kind, **options)
        names = self.flock_env.possible_agents
        if len(names) != 1:
            raise InputError(f"kind {kind} has {len(names)} agents: Gymnasium steers one")
        self.name = names[0]
        self.observation_space = self.flock_env.observation_space(self.name)
        self.action_space = self.flock_env.action_space(self.name)

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002 - as in Gymnasium
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin anew."""
        super().reset(seed=seed)
        seen, told = self.flock_env.reset(seed)
        return seen[self.name], told[self.name]

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Run a tick with an action."""
        seen, gained, over, ended, told = self.flock_env.step({self.name: action})
        name = self.name
        return seen[name], gained[name], over[name], ended[name], told[name]
