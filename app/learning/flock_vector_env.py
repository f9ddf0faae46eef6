"""Many small flocks as a `VectorEnv` of Gymnasium, all of them in one compiled call a tick."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from agents.flock import Flock
from agents.option import whole_number
from agents.spec import LARGEST_SEED, Spec
from app.learning.flock_batch import FlockBatch
from app.learning.reward import StepResult
from worlds.input_error import InputError, shorten, unknown

MOST_FLOCKS = 65_536
NOBODY = np.empty(0, int)


class FlockVectorEnv(VectorEnv):
    """`number` flocks of one spec that differ in their seeds: each is a sub-environment.

    Where a flock has one player, observations, actions and rewards are those of `SingleAgentEnv`,
    to the bit. Where it has M, they are a team: observations are (M, width) and actions (M, A), the
    reward is the sum of what all gain, and it is terminated when nobody plays any more; `infos` has
    what each player gained and for whom it is over, `gained` and `is_over` (number, M).

    `autoreset`: when a flock that has ended begins anew, as Gymnasium's `AutoresetMode` has it.
    Raises InputError.
    """

    def __init__(
        self,
        spec: Spec,
        number: int,
        kind: str,
        k: int = 6,
        ticks: int = 200,
        reward: str | Callable[[StepResult], np.ndarray] = "align",
        scale: float = 1.0,
        autoreset: str | AutoresetMode = AutoresetMode.NEXT_STEP,
    ) -> None:
        self.num_envs = whole_number("number", number, 1, MOST_FLOCKS)
        modes = [mode.value for mode in AutoresetMode]
        if not isinstance(autoreset, AutoresetMode) and autoreset not in modes:
            raise unknown("autoreset", str(autoreset), modes)
        self.autoreset_mode = AutoresetMode(autoreset)
        self.metadata = {"render_modes": [], "autoreset_mode": self.autoreset_mode}
        self.batch = FlockBatch(spec, self.num_envs, kind, k, ticks, reward, scale)
        players = self.batch.tables.ids.shape[1]
        self.is_team = players > 1
        of_team = (players,) if self.is_team else ()
        self.single_observation_space = Box(-1.0, 1.0, (*of_team, self.batch.width), np.float32)
        self.single_action_space = Box(-1.0, 1.0, (*of_team, self.batch.action_size), np.float32)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._have_ended = np.ones(self.num_envs, bool)
        self._was_reset = False

    @property
    def flocks(self) -> tuple[Flock, ...]:
        """The flocks as they are now; what is made of them counts from the next tick on.

        Once they were asked for, each step looks at each of them, which takes a little longer, and
        each is begun anew by itself, which takes several times as long.
        """
        self.batch.share()
        return tuple(self.batch.flocks)

    def reset(
        self,
        *,
        seed: Any = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin all flocks anew, or those of `options["reset_mask"]`, bool (number,).

        `seed`: of the first flock, the next ones have the next; or a list, one for each flock; None
        goes on from the last. Raises InputError.
        """
        seeds = self._seeds_of(seed)
        super().reset(seed=seeds[0])
        mask = np.ones(self.num_envs, bool)
        if options is not None and "reset_mask" in options:
            mask = np.asarray(options["reset_mask"])
            if mask.shape != (self.num_envs,) or mask.dtype != bool or not mask.any():
                raise InputError(
                    f"reset_mask = {shorten(options['reset_mask'])} is not allowed: "
                    f"{self.num_envs} truth values, one of them true, are needed"
                )
            if not self._was_reset and not mask.all():
                raise InputError("the first reset begins all flocks: reset_mask leaves out some")
        self._restart(np.flatnonzero(mask), seeds)
        self._was_reset = True
        return self._seen(), {}

    def step(
        self, actions: Any
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Run a tick of all flocks, or begin those anew that ended with the last one."""
        batch, mode = self.batch, self.autoreset_mode
        if not self._was_reset:
            raise InputError("no flock has begun: reset() comes before the first step()")
        values = self._check_actions(actions)
        ended = np.flatnonzero(self._have_ended) if self._have_ended.any() else NOBODY
        if len(ended) and mode is AutoresetMode.DISABLED:
            raise InputError(
                f"flock {ended[0]} has ended: begin it anew by reset(options={{'reset_mask': ...}})"
            )
        which = np.flatnonzero(~self._have_ended) if len(ended) else batch.all
        batch.step(values, which)
        gained, over = batch.tables.gained.copy(), batch.tables.is_over.copy()
        terminated = ~batch.tables.playing.any(axis=1)
        truncated = batch.has_ended
        if len(ended):
            for flags in (gained, over, terminated, truncated):
                flags[ended] = 0
        self._have_ended = terminated | truncated
        infos = {"gained": gained, "is_over": over} if self.is_team else {}
        self._restart(ended, None)
        if mode is AutoresetMode.SAME_STEP and self._have_ended.any():
            done = np.flatnonzero(self._have_ended)
            seen = self._seen()
            for e in done.tolist():
                final = {"final_obs": seen[e], "final_info": {}}
                infos = self._add_info(infos, final, e)
            self._restart(done, None)
        return self._seen(), gained.sum(axis=1), terminated, truncated, infos

    def _check_actions(self, actions: Any) -> np.ndarray:
        """The actions (E, M, A) of all players. Raises InputError."""
        try:
            values = np.asarray(actions, float)
        except (TypeError, ValueError):
            values = np.empty(0)
        shape = self.action_space.shape
        if values.shape != shape:
            raise InputError(
                f"actions have the shape {values.shape}: numbers of the shape {shape} are needed"
            )
        if not np.isfinite(values).all():
            at = np.argwhere(~np.isfinite(values))[0]
            raise InputError(
                f"actions of flock {at[0]} are {shorten(values[at[0]].tolist())}: finite numbers "
                "in [-1, 1] are needed"
            )
        return values.reshape(*self.batch.tables.ids.shape, -1)

    def _restart(self, which: np.ndarray, seeds: list[int | None] | None) -> None:
        """Begin some flocks anew, and look around in them."""
        if not len(which):
            return
        flocks = which.tolist()
        self.batch.restart(flocks, [None if seeds is None else seeds[e] for e in flocks])
        self.batch.look(which)
        self._have_ended[which] = False

    def _seen(self) -> np.ndarray:
        """What all players see, a copy."""
        seen: np.ndarray = self.batch.tables.seen
        return seen.copy() if self.is_team else seen[:, 0].copy()

    def _seeds_of(self, seed: Any) -> list[int | None]:
        """The seed of each flock. Raises InputError."""
        if seed is None:
            return [None] * self.num_envs
        if not isinstance(seed, list | tuple | np.ndarray):
            first = whole_number("seed", seed, 0, LARGEST_SEED - self.num_envs)
            return [first + e for e in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise InputError(f"{len(seed)} seeds are not allowed: {self.num_envs} are needed")
        return [
            None if one is None else whole_number(f"seed of flock {e}", one, 0, LARGEST_SEED)
            for e, one in enumerate(seed)
        ]
