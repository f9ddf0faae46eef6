"""A flock as a `ParallelEnv` of PettingZoo: the agents of one kind are players, the others not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from gymnasium.spaces import Box
from pettingzoo import ParallelEnv

from agents.agent_view import AgentView, numbers_of_action, wishes_of_actions
from agents.flock import Flock
from agents.flock_world import LARGEST_DRAWN
from agents.option import whole_number
from agents.spec import Spec
from app.learning.reward import StepResult
from app.learning.rewards import rewards
from worlds.input_error import InputError, shorten, unknown

MOST_NEAREST = 64


class FlockEnv(ParallelEnv):
    """The agents of a steered kind are players; all others follow their rule.

    An action is a wish in the player's own frame, each number in [-1, 1]. Where the rule wishes a
    heading it is how far to turn to the left, and in space upwards, in half turns; where it wishes
    an acceleration or a velocity it is that over `scale`, ahead, to the left and up. The body keeps
    to its limits. An observation is that of `agents.agent_view.AgentView`. A player is done
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
        players = [one for one in spec.kinds if one.name == kind]
        if not players:
            raise unknown("kind", kind, [one.name for one in spec.kinds])
        if not players[0].steered:
            raise InputError(f"kind {kind} is not steered: make it with steered = true")
        self.kind = kind
        self.k = whole_number("k", k, 1, MOST_NEAREST)
        self.ticks = whole_number("ticks", ticks, 1)
        if not (isinstance(scale, int | float) and 0.0 < scale < np.inf):
            raise InputError(f"scale = {shorten(scale)} is not allowed: a number > 0 is needed")
        self.scale = float(scale)
        if isinstance(reward, str):
            if reward not in rewards():
                raise unknown("reward", reward, rewards())
            reward = rewards()[reward].compute
        self.reward = reward
        self.flock = Flock(spec if spec.seed is not None else spec.but(seed=1))
        self.rng = np.random.default_rng(self.flock.seed)
        self.view = AgentView(self.flock, self.k, players[0].agents)
        self.possible_agents = [f"{kind}_{n}" for n in range(players[0].agents)]
        self.agents: list[str] = []
        self._observation = Box(-1.0, 1.0, (self.view.width,), np.float32)
        self._action = Box(-1.0, 1.0, (numbers_of_action(self.flock),), np.float32)
        self.ids = self._player_ids()

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
        if seed is not None:
            self.rng = np.random.default_rng(seed)
        self.flock.restart(int(self.rng.integers(LARGEST_DRAWN)))
        self.ids = self._player_ids()
        self.agents = self.possible_agents[:]
        return self._observe(self.agents), {name: {} for name in self.agents}

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
        flock, names = self.flock, self.agents
        rows = flock.rows_of(self.kind)
        self._steer(rows, actions)
        flock.run(1)
        ids = np.array([self.ids[name] for name in names])
        now = self._rows(ids)
        is_over = now < 0
        result = StepResult(flock, ids, now, is_over)
        gained = np.asarray(self.reward(result), float)
        if gained.shape != (len(names),) or not np.isfinite(gained).all():
            raise InputError(
                f"the reward gave {shorten(gained)}: {len(names)} finite numbers are needed"
            )
        has_ended = flock.tick >= self.ticks
        seen = self._observe(names)
        self.agents = [
            name for name, over in zip(names, is_over, strict=True) if not over and not has_ended
        ]
        return (
            seen,
            dict(zip(names, gained.tolist(), strict=True)),
            dict(zip(names, is_over.tolist(), strict=True)),
            dict.fromkeys(names, has_ended),
            {name: {} for name in names},
        )

    def _player_ids(self) -> dict[str, int]:
        """The identities of the players, by name."""
        ids = np.sort(self.flock.ids[self.flock.rows_of(self.kind)]).tolist()
        return dict(zip(self.possible_agents, ids, strict=True))

    def _rows(self, ids: np.ndarray) -> np.ndarray:
        """The rows of identities (S,), -1 for those that are gone, were caught or have crashed."""
        flock = self.flock
        order = np.argsort(flock.ids)
        place = np.minimum(np.searchsorted(flock.ids, ids, sorter=order), len(order) - 1)
        rows = order[place]
        is_there = (flock.ids[rows] == ids) & flock.active[rows]
        return np.where(is_there, rows, -1)

    def _observe(self, names: list[str]) -> dict[str, np.ndarray]:
        """What players see; those that are gone see nothing: zeros."""
        rows = self._rows(np.array([self.ids[name] for name in names], int))
        seen = np.zeros((len(names), self.view.width), np.float32)
        here = rows >= 0
        seen[here] = self.view.look(rows[here])
        return dict(zip(names, seen, strict=True))

    def _steer(self, rows: np.ndarray, actions: Mapping[str, Any]) -> None:
        """Tell the agents of rows what their players' actions wish. Raises InputError."""
        flock = self.flock
        name_of = {identity: name for name, identity in self.ids.items()}
        numbers = self._action.shape[0]
        told = np.empty((len(rows), numbers))
        for at, row in enumerate(rows.tolist()):
            name = name_of[int(flock.ids[row])]
            if name not in actions:
                raise InputError(f"actions have none of {name}")
            try:
                action = np.asarray(actions[name], float).reshape(-1)
            except (TypeError, ValueError):
                action = np.empty(0)
            if len(action) != numbers or not np.isfinite(action).all():
                raise InputError(
                    f"action of {name} is {shorten(actions[name])}: {numbers} finite numbers in "
                    "[-1, 1] are needed"
                )
            told[at] = action
        flock.steer(self.kind, wishes_of_actions(flock, rows, told, self.scale))
