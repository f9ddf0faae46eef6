"""A flock as a `ParallelEnv` of PettingZoo: the agents of one kind are players, the others not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from gymnasium.spaces import Box
from pettingzoo import ParallelEnv

from agents.flock import Flock
from agents.spec import Spec
from app.learning.flock_batch import FlockBatch
from app.learning.reward import StepResult
from worlds.input_error import InputError


class FlockEnv(ParallelEnv):
    """The agents of a steered kind are players; all others follow their rule.

    An action is a wish in the player's own frame, each number in [-1, 1]. Where the rule wishes a
    heading it is how far to turn to the left, and in space upwards, in half turns; where it wishes
    an acceleration or a velocity it is that over `scale`, ahead, to the left and up. The body keeps
    to its limits. An observation is that of `agents.motion.agent_view.view_width`. A player is done
    (`terminated`) when it was caught or has crashed, and all are (`truncated`) after `ticks`.

    Raises InputError for what cannot be, also for an action that is no finite number.
    """

    metadata: ClassVar[dict[str, Any]] = {
        "name": "flock_v0",
        "render_modes": [],
        "is_parallelizable": True,
    }
    render_mode = None

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
        ids = self.batch.tables.ids[0].tolist()
        self.possible_agents = [f"{kind}_{n}" for n in range(len(ids))]
        self.ids = dict(zip(self.possible_agents, ids, strict=True))
        """The identities of the players, by name."""
        self.agents: list[str] = []
        self._places = {name: m for m, name in enumerate(self.possible_agents)}
        self._observation = Box(-1.0, 1.0, (self.batch.width,), np.float32)
        self._action = Box(-1.0, 1.0, (self.batch.action_size,), np.float32)
        self._actions = np.zeros((1, len(ids), self.batch.action_size))

    @property
    def flock(self) -> Flock:
        """The flock, as it is now; what is made of it counts from the next tick on."""
        if not self.batch.is_shared:
            self.batch.share()
        return self.batch.flocks[0]

    def observation_space(self, agent: str) -> Box:  # noqa: ARG002 - as in PettingZoo
        """The same of every player."""
        return self._observation

    def action_space(self, agent: str) -> Box:  # noqa: ARG002 - as in PettingZoo
        """The same of every player."""
        return self._action

    def reset(
        self,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002 - as in PettingZoo
    ) -> tuple[dict[str, np.ndarray], dict[str, dict[str, Any]]]:
        """Begin anew; with a seed, the run of that seed, else one that follows from the last."""
        self.batch.restart([0], [seed])
        self.batch.look(self.batch.all)
        self.agents = self.possible_agents[:]
        return self._seen(self.agents), {name: {} for name in self.agents}

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[
        dict[str, np.ndarray],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """Run a tick with the players' actions: observations, rewards, who is done, infos."""
        batch, names, tables = self.batch, self.agents, self.batch.tables
        for name in names:
            self._take_action(name, actions)
        batch.step(self._actions, batch.all)
        places = [self._places[name] for name in names]
        gained, is_over = tables.gained[0].tolist(), tables.is_over[0].tolist()
        has_ended = bool(batch.has_ended[0])
        seen = self._seen(names)
        self.agents = [
            name
            for name, place in zip(names, places, strict=True)
            if not is_over[place] and not has_ended
        ]
        return (
            seen,
            {name: gained[place] for name, place in zip(names, places, strict=True)},
            {name: is_over[place] for name, place in zip(names, places, strict=True)},
            dict.fromkeys(names, has_ended),
            {name: {} for name in names},
        )

    def _seen(self, names: list[str]) -> dict[str, np.ndarray]:
        """What players see."""
        seen = self.batch.tables.seen[0].copy()
        return {name: seen[self._places[name]] for name in names}

    def _take_action(self, name: str, actions: Mapping[str, Any]) -> None:
        """Keep a player's action. Raises InputError."""
        if name not in actions:
            raise InputError(f"actions have none of {name}")
        action = self.batch.check_action(actions[name], f"action of {name}")
        self._actions[0, self._places[name]] = action
