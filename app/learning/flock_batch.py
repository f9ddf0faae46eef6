"""Many small flocks whose players are steered, run, rewarded and asked what they see together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from agents.engine.runner import refuse
from agents.engine.stored_call import FAILED, StoredTick, store_value
from agents.flock import Flock
from agents.flock_world import LARGEST_DRAWN
from agents.inspection import field_of_view
from agents.motion.agent_view import numbers_of_action, view_width
from agents.motion.flock_start import begin_in_place
from agents.option import whole_number
from agents.spec import LARGEST_SEED, Spec
from app.learning.batch_step import (
    BAD,
    BAD_ROW,
    CALLER,
    CATCHES,
    DONE,
    GAIN,
    LASTS,
    LOOK,
    LOST,
    NOW,
    REACH,
    STEER,
    SURROUNDINGS,
    TICK,
    TICK_AT,
    VIEW,
    WORDS,
    BatchTables,
    batch_step,
)
from app.learning.reward import StepResult
from app.learning.rewards import no_gain, rewards
from worlds.compilation import DISABLED
from worlds.input_error import InputError, shorten, unknown

MOST_NEAREST = 64
NO_ACTIONS = np.zeros((0, 0, 0))


class FlockBatch:
    """Flocks of one spec, each with the same number of players, and what a tick gives of them.

    The arrays of `tables` that a tick fills are this object's own: the next tick writes them anew.
    Raises InputError for what cannot be.
    """

    def __init__(
        self,
        spec: Spec,
        number: int,
        kind: str,
        k: int,
        ticks: int,
        reward: str | Callable[[StepResult], np.ndarray],
        scale: float,
    ) -> None:
        players = [one for one in spec.kinds if one.name == kind]
        if not players:
            raise unknown("kind", kind, [one.name for one in spec.kinds])
        if not players[0].steered:
            raise InputError(f"kind {kind} is not steered: make it with steered = true")
        if DISABLED:
            raise InputError("agents that learn need compiled code: unset NUMBA_DISABLE_JIT")
        self.kind = kind
        k = whole_number("k", k, 1, MOST_NEAREST)
        self.ticks = whole_number("ticks", ticks, 1)
        if not (isinstance(scale, int | float) and 0.0 < scale < np.inf):
            raise InputError(f"scale = {shorten(scale)} is not allowed: a number > 0 is needed")
        self.scale = float(scale)
        self.reward, gain = None, no_gain
        if not isinstance(reward, str):
            self.reward = reward
        elif reward not in rewards():
            raise unknown("reward", reward, rewards())
        else:
            gain = rewards()[reward].gain
        flock = Flock(spec)
        seeds = ((flock.seed + e) % LARGEST_SEED for e in range(1, number))
        self.flocks = [flock, *(Flock(spec.but(seed=seed)) for seed in seeds)]
        mission = flock.world.mission
        has_goal = mission is not None and mission.goal is not None
        if isinstance(reward, str) and rewards()[reward].needs_goal and not has_goal:
            raise InputError(
                f"reward {reward} needs a goal: the world {flock.world.name!r} has none"
            )
        self.is_shared = self.reward is not None
        """Whether anybody but the players asks for the flocks."""
        self._lost = np.zeros(number, bool)
        self.rng = [np.random.default_rng(flock.seed) for flock in self.flocks]
        self._run = batch_step(gain)
        self._stored: list[StoredTick | None] = [None] * number
        self._engines: list[Any] = [None] * number
        self._contexts: list[Any] = [None] * number
        self._arrays: list[Any] = [None] * number
        self._kept: list[Any] = [None] * number
        self._examples = flock.arrays, flock.engine.surroundings
        self._in_place = [False] * number
        """Which flocks can begin anew in the arrays that they have."""
        self._is_behind = np.zeros(number, bool)
        """Which flocks have begun anew in their arrays alone."""
        self.all = np.arange(number)
        self.width = view_width(k, flock.world.dim)
        self.action_size = numbers_of_action(flock)
        self.tables = self._make_tables(number, players[0].agents, k)
        ids = np.sort(flock.ids[flock.rows_of(kind)])
        self.tables.ids[:] = ids
        for e in range(number):
            self.register(e)

    def _make_tables(self, number: int, players: int, k: int) -> BatchTables:
        """The tables of so many flocks, as they stand."""
        flock = self.flocks[0]
        n, dim = flock.position.shape
        catchers = [
            (hunter, prey, one.catch, one.caught != "moved")
            for hunter, prey, one in flock.kinds.catchers
        ]
        numbers = np.zeros((number, 3))
        numbers[:, REACH] = [one.reach for one in self.flocks]
        numbers[:, LASTS] = flock.dt
        numbers[:, VIEW] = field_of_view(flock)
        size, images = np.zeros((number, 3)), np.zeros((number, 3), bool)
        size[:, :dim], images[:, :dim] = flock.world.size, flock.world.images
        return BatchTables(
            np.zeros((number, 6), np.int64),
            numbers,
            size,
            images,
            np.full(number, flock.model.rule.wish == "heading"),
            np.zeros((number, players), np.int64),
            np.ones((number, players), bool),
            np.full((number, players), -1),
            np.zeros((number, players), np.int64),
            np.zeros((number, n if catchers else 0, 3)),
            np.array(catchers, float).reshape(-1, 4),
            np.zeros((k, 2)),
            np.zeros((4, 3)),
            np.zeros((number, players, self.width), np.float32),
            np.zeros((number, players)),
            np.zeros((number, players), bool),
            np.zeros(number, np.int64),
        )

    def register(self, e: int) -> None:
        """Write down where the arrays of a flock are, and with what its loop is called."""
        flock = self.flocks[e]
        engine, stored = flock.engine, self._stored[e]
        is_same = stored is not None and engine is self._engines[e]
        is_same = is_same and flock.context is self._contexts[e] and not flock.options.is_windy
        is_same = is_same and not flock.has_events and not flock.is_flown
        if stored is None or not is_same or not stored.takes(flock.arrays, flock.seed):
            stored = self._stored[e] = flock.store_tick(max(1, self.ticks - flock.tick))
            place = engine.surroundings
            words = store_value(flock.arrays), store_value(place)
            if stored is not None:
                words = stored.words, stored.words[stored.surroundings_at :]
            codes = self.tables.codes[e]
            codes[CALLER] = 0 if stored is None else stored.caller.address
            codes[WORDS], codes[SURROUNDINGS] = (one.ctypes.data for one in words)
            codes[TICK_AT] = 0 if stored is None else words[0].ctypes.data + 8 * stored.tick_at
            self._engines[e], self._contexts[e] = engine, flock.context
            self._kept[e] = words, place
        self._arrays[e] = flock.arrays
        self._in_place[e] = stored is not None and flock.can_begin_in_place
        self.tables.codes[e, NOW] = flock.tick
        n, before = len(flock.ids), self.tables.before
        if len(self.tables.catchers) and n > before.shape[1]:  # somebody has made agents
            more = np.zeros((len(before), n - before.shape[1], 3))
            self.tables = self.tables._replace(before=np.concatenate([before, more], axis=1))

    def check_action(self, value: Any, title: str) -> np.ndarray:
        """The action (A,) of one player. Raises InputError."""
        try:
            action = np.asarray(value, float).reshape(-1)
        except (TypeError, ValueError):
            action = np.empty(0)
        if len(action) != self.action_size or not np.isfinite(action).all():
            given = shorten(value.tolist() if isinstance(value, np.ndarray) else value)
            raise InputError(
                f"{title} is {given}: {self.action_size} finite numbers in [-1, 1] are needed"
            )
        return action

    def restart(self, which: Sequence[int], seeds: Sequence[int | None]) -> None:
        """Begin some flocks anew: with a seed the run of that seed, else one that follows from the
        last."""
        begun: list[int] = []
        run_seeds: list[int] = []
        for e, seed in zip(which, seeds, strict=True):
            if seed is not None:
                self.rng[e] = np.random.default_rng(seed)
            run_seed = int(self.rng[e].integers(LARGEST_DRAWN))
            if self._in_place[e] and not self.is_shared:
                begun.append(e)
                run_seeds.append(run_seed)
            else:
                self._is_behind[e] = False
                self.flocks[e].restart(run_seed)
                self.register(e)
            self.tables.playing[e], self._lost[e] = True, False
        if begun:
            begin_in_place([self.flocks[e] for e in begun], run_seeds)
        for e, run_seed in zip(begun, run_seeds, strict=True):
            stored = self._stored[e]
            assert stored is not None
            stored.words[stored.seed_at] = run_seed
            self.tables.codes[e, NOW] = 0
            self._is_behind[e] = True

    def _catch_up(self, e: int) -> None:
        """Have a flock be what it is in its arrays."""
        flock = self.flocks[e]
        if self._is_behind[e]:
            arrays = flock.arrays
            flock.restart(flock.seed)
            for now, begun in zip(arrays, flock.arrays, strict=True):
                np.copyto(begun, now)
            self._is_behind[e] = False
            flock.tick = int(self.tables.codes[e, NOW])
            self.register(e)

    def _take_changes(self) -> None:
        """Go on from what somebody has made of the flocks since the last tick."""
        now = self.tables.codes[:, NOW].tolist()
        for e, flock in enumerate(self.flocks):
            is_same = flock.arrays is self._arrays[e] and flock.context is self._contexts[e]
            if not is_same or flock.tick != now[e] or flock.has_events or flock.is_flown:
                self.register(e)

    def _tell_ticks(self) -> None:
        """Have each flock know at which tick it is."""
        for flock, tick in zip(self.flocks, self.tables.codes[:, NOW].tolist(), strict=True):
            if flock.tick != tick:
                flock.tick = tick

    def look(self, which: np.ndarray) -> None:
        """Fill in what the players of some flocks see."""
        self._call(which, NO_ACTIONS, LOOK)

    def step(self, actions: np.ndarray, which: np.ndarray) -> None:
        """Run a tick of some flocks with the actions (E, M, A) of those who play."""
        tables = self.tables
        if self.is_shared:
            self._take_changes()
        self._call(which, actions, STEER | TICK | GAIN | LOOK)
        if tables.ending.any():
            self._lost |= tables.ending == LOST
            unfinished = np.flatnonzero((tables.ending != DONE) & (tables.ending != LOST))
            for e in unfinished.tolist():
                self._end_in_python(e)
            tables.ending[:] = DONE
            self._call(unfinished, actions, GAIN | LOOK)
        if self.reward is not None:
            for e in which.tolist():
                self._ask_reward(e)
        if self.is_shared:
            self._tell_ticks()
        tables.playing[tables.is_over] = False

    @property
    def has_ended(self) -> np.ndarray:
        """Whether each flock has run for as long as it may, bool (E,)."""
        return self.tables.codes[:, NOW] >= self.ticks

    def _call(self, which: np.ndarray, actions: np.ndarray, phases: int) -> None:
        """Go through phases of a tick with some flocks."""
        self._run(
            *self._examples, self.tables, which, actions, self.scale, phases, not self.is_shared
        )

    def share(self) -> None:
        """From now on have each flock be as it is, and take what somebody makes of it."""
        self.is_shared = True
        for e in np.flatnonzero(self._is_behind).tolist():
            self._catch_up(e)
        for e in np.flatnonzero(self._lost).tolist():
            self._catch(e, int(self.tables.codes[e, NOW]) - 1)
        self._lost[:] = False
        self._tell_ticks()

    def _catch(self, e: int, tick: int) -> None:
        """Let a flock, run from a tick to the next, find out who is caught."""
        flock = self.flocks[e]
        n, dim = flock.position.shape
        flock.tick = tick
        flock.end_tick(self.tables.before[e, :n, :dim].copy())
        self.register(e)

    def _end_in_python(self, e: int) -> None:
        """End a tick that compiled code could not end. Raises NotANumber, or what the loop does."""
        self._catch_up(e)
        flock, tables = self.flocks[e], self.tables
        flock.tick = int(tables.codes[e, NOW])
        bad_row = int(tables.codes[e, BAD_ROW])
        if tables.ending[e] == BAD and bad_row != FAILED:
            tables.ending[:] = DONE
            refuse(flock.arrays, bad_row, flock.tick)
        if tables.ending[e] == CATCHES:
            self._catch(e, flock.tick)
        else:
            flock.run(1)
            self.register(e)
        catchers = flock.catches.gate[flock.catches.tick == flock.tick]
        tables.caught[e] = (catchers[None] == tables.ids[e][:, None]).sum(axis=1)

    def _ask_reward(self, e: int) -> None:
        """Fill in what the players of a flock gain by a function of one's own. Or
        InputError."""
        flock, tables, reward = self.flocks[e], self.tables, self.reward
        assert reward is not None
        flock.tick = int(tables.codes[e, NOW])
        playing = tables.playing[e]
        result = StepResult(
            flock, tables.ids[e, playing], tables.rows[e, playing], tables.is_over[e, playing]
        )
        gained = np.asarray(reward(result), float)
        count = int(playing.sum())
        if gained.shape != (count,) or not np.isfinite(gained).all():
            raise InputError(
                f"the reward gave {shorten(gained)}: {count} finite numbers are needed"
            )
        tables.gained[e, playing] = gained
