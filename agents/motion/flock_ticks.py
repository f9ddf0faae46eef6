"""The ticks of a flock: many at once, until something holds, or agent by agent."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from agents.engine.arrays import NEVER, Arrays, EngineStopCondition
from agents.engine.runner import UNTRACED, SynchronousEngine
from agents.engine.stored_call import StoredTick
from agents.motion.flock_loop import FlockLoop
from agents.observables.consistency import DESIRED, HOLD, stop_when_consistent
from agents.snapshot import Snapshot
from worlds.compilation import DISABLED
from worlds.input_error import InputError
from worlds.world import World

if TYPE_CHECKING:
    pass

STRETCH = 100_000
"""Ticks for which the wind is known in advance."""
CHUNK = 500
"""Ticks of a long run between two looks at the world outside."""


class FlockTicks(FlockLoop):
    """A flock that runs ticks, and is frozen between them."""

    def return_to(self, past: Snapshot) -> None:
        """Be as a snapshot of this run was, and go on from there as it did, to the bit."""
        self._acted.clear()
        self.world, self.parameters = past.world, past.parameters
        self.individuals = dict(past.individuals)
        self.kinds, self.catches = past.kinds, past.catches
        self.tick, self.next_id = past.tick, past.next_id
        self.entries, self.exits = past.entries, past.exits
        self._set_arrays(Arrays._make(map(np.array, past.arrays)))
        self._match_members()

    def links(self) -> np.ndarray:
        """Pairs of rows (i < j) within reach of each other, int (M, 2)."""
        return self.snapshot(copy=False).links()

    def group_labels(self) -> np.ndarray:
        """The connected group within `together` of each agent, int (N,), 0 the largest."""
        return self.snapshot(copy=False).group_labels()

    def layers(self) -> np.ndarray:
        """Hops from an information agent plus 1, as the flock stands; N + 1 unknown; int (N,)."""
        return self.snapshot(copy=False).layers()

    def change_world(self, world: World) -> None:
        """Put the running flock among other obstacles, edges or another mission.

        Raises InputError if the world has other dimensions; nothing then changes. Agents stay where
        they are: see `worlds.queries.surface` for those that an obstacle has come upon.
        """
        if world.dim != self.world.dim:
            raise InputError(f"a {self.world.dim}-D flock cannot go on in a {world.dim}-D world")
        self._demand_gates(world)
        self._end_tick()
        self.world = world
        self._engine = None
        self.context = self._make_context()

    def advance(self, ticks: int, until_ended: bool = False) -> None:
        """Run ticks without collecting anything; frees the GIL while it runs.

        `until_ended`: stop at the tick at which the flock has become empty for good.
        """
        if ticks > 0 and self._acted:
            remaining_rows = [
                row for row in np.argsort(self.ids).tolist() if row not in self._acted
            ]
            for row in remaining_rows:
                self.step_member(row)
            ticks -= 1
        while ticks > 0:
            ticks_to_run = self._ticks_together(min(ticks, STRETCH))
            if len(self.ids):
                self._run(ticks_to_run)
            self._count_ticks(ticks_to_run)
            ticks -= ticks_to_run
            if until_ended and self.world.has_gates and self.has_ended:
                return

    def _ticks_together(self, ticks: int) -> int:
        """How many of so many ticks, one at least, run before an event, or somebody may come or
        go."""
        is_single = bool(self.kinds.catchers) or self.is_flown
        ticks = self._ticks_to_event(1 if is_single else ticks)
        return self._ticks_to_gates(ticks) if self.world.has_gates else ticks

    def _ticks_to_gates(self, ticks: int) -> int:
        """How many of so many ticks, one at least, run before somebody may come or go."""
        return ticks

    @property
    def is_flown(self) -> bool:
        """Whether somebody is asked, tick by tick, what steered agents wish."""
        return False

    def _ask_pilots(self) -> None:
        """Ask who flies agents what these wish in the coming tick."""

    def _catch(self) -> None:
        """Let those who chase catch who is near enough."""

    def _pass_gates(self) -> None:
        """Let agents come and go at the end of a tick."""

    def _demand_gates(self, world: World) -> None:
        """Raise InputError for gates that agents of this flock cannot pass."""

    def _ticks_to_event(self, ticks: int) -> int:
        """How many of so many ticks, one at least, can run before something else has its turn."""
        return ticks

    def _fire_due(self) -> None:
        """Let what is due at this tick have its turn."""

    @property
    def has_events(self) -> bool:
        """Whether something else may have its turn between ticks."""
        return False

    def _match_members(self) -> None:
        """Let what stands for single agents follow the rows, whose identities may have changed."""

    def _count_ticks(self, ticks: int) -> None:
        """Count ticks that were run, and let what is due have its turn."""
        self.tick += ticks
        if self.kinds.catchers:
            self._catch()
        if self.world.has_gates:
            self._pass_gates()
        self._fire_due()

    def _run(self, ticks: int, until: EngineStopCondition = NEVER, trace: np.ndarray = UNTRACED):
        """Run the compiled loop from this tick on; what its `run` answers."""
        if self.is_flown:
            self._ask_pilots()
        if self.kinds.catchers:
            self._came_from = self.ids.copy(), self.position.copy()
        return self.engine.run(self._context_with_wind(ticks), self.tick, ticks, until, trace)

    def store_tick(self, ticks: int) -> StoredTick | None:
        """One tick's call of the loop, for compiled code that calls it for up to so many ticks.

        None where Python has a part in a tick: where agents act in turn or know of each other by
        messages, come and go, are flown, go by several models, share a tick among threads or ranks,
        or run as plain Python. Good as long as the engine and the context are those of now. Who
        catches whom, events and the count of ticks are left to the caller.
        """
        engine = self.engine
        is_plain = self.interpret or DISABLED
        comes_between = self.world.has_gates or self.has_events or self.is_flown
        if not isinstance(engine, SynchronousEngine) or engine.parts > 1:
            return None
        if is_plain or comes_between:
            return None
        return engine.store_tick(self._context_with_wind(ticks), self.tick)

    def trace(self, ticks: int) -> np.ndarray:
        """Run ticks (>= 0); the positions after each of them, (ticks, N, dim)."""
        self._end_tick()
        self._demand_no_gates()
        positions = np.empty((ticks, *self.position.shape))
        done = 0
        while done < ticks:
            ticks_to_run = self._ticks_together(ticks - done)
            self._demand_as_many(positions.shape[1])
            self._run(ticks_to_run, trace=positions[done : done + ticks_to_run])
            self._count_ticks(ticks_to_run)
            done += ticks_to_run
        return positions

    def _demand_no_gates(self) -> None:
        """Raise InputError where agents come and go."""
        if self.world.has_gates:
            raise InputError(
                f"agents come and go in {self.world.name}: a run that traces positions, or waits "
                "for something to hold, needs the same agents throughout"
            )

    def _demand_as_many(self, n: int) -> None:
        """Raise InputError where an event has changed the number of agents of such a run."""
        if len(self.ids) != n:
            raise InputError(
                f"an event at tick {self.tick} left {len(self.ids)} agents of {n}: a run that "
                "traces positions, or waits for consistency, needs the same agents throughout"
            )

    def run_until_consistent(
        self,
        limit: int,
        desired: float = DESIRED,
        hold: int = HOLD,
        between: Callable[[], None] = lambda: None,
    ) -> int | None:
        """k_con of Liu et al. 2021 (27): ticks until Deg_con >= `desired`, held for `hold` ticks.

        None if it has not come after `limit` ticks. Runs compiled, some hundred ticks at a time;
        `between` is called between them and may end the run by raising.
        """
        self._end_tick()
        until = stop_when_consistent(len(self.ids), self.reference, desired, hold)
        return self.run_until_held(until, limit, between)

    def run_until_held(
        self, until: EngineStopCondition, limit: int, between: Callable[[], None] = lambda: None
    ) -> int | None:
        """Run until something has held; the tick from which it does, None if not by `limit`.

        The rest as `run_until_consistent`.
        """
        self._end_tick()
        self._demand_no_gates()
        until, n = until._replace(last_off=self.tick - 1), len(self.ids)
        while self.tick < limit:
            between()
            ticks = self._ticks_together(min(CHUNK, limit - self.tick))
            self._demand_as_many(n)
            done, last_off = self._run(ticks, until)
            self._count_ticks(done)
            if done < ticks:
                return last_off + 1
            until = until._replace(last_off=last_off)
        return None

    def step_member(self, row: int) -> None:
        """Let one agent decide and move, as `Member.step` does.

        Synchronous: it decides on the flock as it stood when the first agent of the tick stepped,
        whatever has moved since. The tick ends when every agent has stepped, or when one steps for
        a second time: those that have not stepped then stay where they are.
        """
        if row in self._acted:
            self._end_tick()
        if not self._acted:
            if self.is_flown:
                self._ask_pilots()
            self.engine.open(self.context, self.tick)
        self.engine.one(self._context_with_wind(1), self.tick, row)
        self._acted.add(row)
        if len(self._acted) == len(self.ids):
            self._end_tick()

    def _end_tick(self) -> None:
        """End a tick in which agents have stepped one by one, if there is one."""
        if self._acted:
            self._acted.clear()
            self._count_ticks(1)

    def signal(self, name: str) -> np.ndarray:
        """One row of `signals` by name, a copy (N,); a layer of N + 1 is unknown. Or InputError."""
        return self.snapshot(copy=False, signals=name in self.model.signals).signal(name)
