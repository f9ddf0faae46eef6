"""Run the compiled loop over a flock's arrays: on some threads, whole or agent by agent."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from itertools import pairwise
from queue import SimpleQueue
from types import ModuleType
from typing import Any
from weakref import finalize

import numpy as np

from agents.engine.arrays import (
    ALL_PHASES,
    BEFORE_SWEEP,
    COUNT,
    FILL,
    NEVER,
    PLACE,
    PLAN,
    PREPARE,
    SHARE,
    SWEEP,
    Arrays,
    Context,
    EngineStopCondition,
    WorldContext,
    empty_grid,
    empty_slots,
    empty_workspace,
)
from agents.engine.cells import Slots
from agents.engine.message_past import MessageDelays
from agents.engine.noise import ORDERS, uniform_numbers
from agents.engine.stored_call import StoredTick
from worlds.queries.surroundings import Surroundings

# The threads that share a tick, with as little overhead as Python allows.


class Team:
    """`size` threads, the caller among them, for jobs that free the GIL.

    The helpers end when the team is no longer referred to.
    """

    def __init__(self, size: int):
        self.size = size
        self.inboxes: list[SimpleQueue] = [SimpleQueue() for _ in range(size - 1)]
        self.outbox: SimpleQueue = SimpleQueue()
        for inbox in self.inboxes:
            threading.Thread(target=run_helper, args=(inbox, self.outbox), daemon=True).start()
        finalize(self, dismiss, self.inboxes)

    def run_on_all(self, job: Callable[[int], None]) -> None:
        """Call job(0), ..., job(size - 1), one on each thread; raise what any of them raises."""
        for k, inbox in enumerate(self.inboxes, start=1):
            inbox.put((job, k))
        # Every reply is taken out before anything is raised: one left behind would be taken for
        # that of the next job.
        failures = [attempt(job, 0)] + [self.outbox.get() for _ in self.inboxes]
        for failure in failures:
            if failure is not None:
                raise failure


def attempt(job: Callable[[int], None], k: int) -> BaseException | None:
    """Do share k of a job; what it raised, if anything."""
    try:
        job(k)
    except BaseException as failure:
        return failure
    return None


def run_helper(inbox: SimpleQueue, outbox: SimpleQueue) -> None:
    """The loop of a helper thread: shares of jobs until None comes."""
    while (task := inbox.get()) is not None:
        outbox.put(attempt(*task))
        task = None  # while this thread waits, the job would keep the flock and its arrays alive


def dismiss(inboxes: list[SimpleQueue]) -> None:
    """End the helper threads."""
    for inbox in inboxes:
        inbox.put(None)


UNTRACED = np.empty((0, 0, 0))
"""In place of a trace: positions are not kept."""
SPLIT_FROM = 20_000
"""Agents from which several threads are faster than one on a busy machine too: two take some 0.2 to
0.5 ms more of a tick, whose phases are calls of Python (`benchmarks/engine/scaling.py`)."""
SEED_AT = 7
"""Which argument of a loop the seed is; the tick is the next one."""
CHUNKS = 4
"""Shares of a sweep per thread: whoever is done early takes one of another thread's."""


class NotANumber(ArithmeticError):
    """A rule gave an agent a position that is not a finite number."""


Called = Callable[..., Any]
"""How compiled functions are called: Called(function, *arguments)."""


def at_once(function: Callable, *arguments: Any) -> Any:
    """Call a compiled function as it is."""
    return function(*arguments)


def refuse(arrays: Arrays, row: int, tick: int) -> None:
    """Raise NotANumber, naming the agent whose position is not finite and the tick."""
    raise NotANumber(
        f"agent {arrays.ids[row]} has position {arrays.position[row].tolist()} at tick {tick}: "
        "every position must be a finite number"
    )


class Engine:
    """What runs ticks over a flock's arrays."""

    module: ModuleType
    """The compiled loop, or that of the flock's own model."""
    arrays: Arrays
    surroundings: Surroundings
    """What stands around, as agents of that model notice it."""
    most_together = 1
    """Ticks that `run_ticks` is asked for at once, where nobody looks at the flock between them."""

    def run(
        self,
        context: Context,
        tick: int,
        ticks: int,
        until: EngineStopCondition = NEVER,
        trace=UNTRACED,
    ) -> tuple[int, int]:
        """Run ticks; returns (ticks done, last tick at which `until` did not hold or -1).

        `trace` (ticks, N, dim), if given, receives the positions after each tick.
        """
        last_off, is_watched = until.last_off, len(until.numbers) > 0
        done = 0
        while done < ticks:
            if is_watched:
                if not self.module.holds(self.arrays, until.numbers):
                    last_off = tick + done
                elif tick + done - last_off >= until.hold:
                    break
            together = 1 if is_watched or len(trace) else min(ticks - done, self.most_together)
            self.run_ticks(context, tick + done, together)
            if len(trace):
                trace[done] = self.arrays.position
            done += together
        return done, last_off

    def run_ticks(self, context: Context, tick: int, ticks: int) -> None:
        """Run ticks without looking at the flock between them."""
        raise NotImplementedError

    def open(self, context: Context, tick: int) -> None:
        """Begin a tick in which agents decide and move one by one."""
        raise NotImplementedError

    def one(self, context: Context, tick: int, row: int) -> None:
        """Let the agent of one row of an opened tick decide and move."""
        raise NotImplementedError


class LoopEngine(Engine):
    """One compiled loop over a flock's arrays."""

    def __init__(
        self,
        module: ModuleType,
        arrays: Arrays,
        place: WorldContext,
        seed: int,
        threads: int = 1,
        called: Called = at_once,
    ):
        self.module = module
        self.called = called
        self.arrays = arrays
        self.space, self.surroundings = place
        self.seed = seed
        self.parts = max(1, threads)
        self.slots = self.empty_slots()
        self.grid = empty_grid(len(arrays.position), self.parts)
        self.workspaces: list[Any] = []
        self.enlarge_workspaces(256)

    def empty_slots(self) -> Slots:
        """Room for a sorted copy of the agents."""
        loop, (n, dim) = self.module, self.arrays.position.shape
        return empty_slots(n, dim, loop.SIGNALS, loop.ASKS_SPEED, loop.KINDS)

    def enlarge_workspaces(self, capacity: int) -> None:
        """Give each thread a workspace with room for `capacity` agents in a block."""
        loop = self.module
        workspace_shape = (
            capacity,
            loop.SIGNALS,
            loop.PRIVATE,
            loop.MEASURES,
            self.surroundings.most_points,
        )
        self.capacity = capacity
        self.workspaces = [empty_workspace(*workspace_shape) for _ in range(self.parts)]


class SynchronousEngine(LoopEngine):
    """Synchronous activation: all agents decide on the same state, then all move (two phases)."""

    def __init__(
        self,
        module: ModuleType,
        arrays: Arrays,
        place: WorldContext,
        seed: int,
        threads: int = 1,
        called: Called = at_once,
    ):
        super().__init__(module, arrays, place, seed, threads, called)
        self.team = Team(self.parts)
        self.slot_of = np.empty(0, np.int64)

    def arguments(self, context, tick, ticks, work, until=NEVER, trace=UNTRACED) -> tuple:
        """What the compiled loop is called with."""
        return (
            self.arrays,
            self.space,
            self.surroundings,
            self.grid,
            self.slots,
            self.workspaces[work[1]],
            context,
            self.seed,
            tick,
            ticks,
            work,
            until,
            trace,
        )

    def whole_ticks(self) -> tuple[int, ...]:
        """What asks the compiled loop for all that belongs to a tick, of all agents."""
        return ALL_PHASES, 0, 1, 0, len(self.arrays.position)

    def store_tick(self, context: Context, tick: int) -> StoredTick:
        """The call of one tick, with a workspace in which there is room for all."""
        n = len(self.arrays.position)
        if self.capacity < n:
            self.enlarge_workspaces(n)
        arguments = self.arguments(context, tick, 1, self.whole_ticks())
        return StoredTick(self.module.advance, arguments, SEED_AT)

    def call(self, context, tick, ticks, work, until=NEVER, trace=UNTRACED):
        """One call of the compiled loop, with a larger workspace if it asks for one."""
        done = 0
        while True:
            more, last_off, bad_row, need = self.called(
                self.module.advance,
                *self.arguments(context, tick + done, ticks - done, work, until, trace[done:]),
            )
            done += more
            until = until._replace(last_off=last_off)
            if bad_row >= 0:
                refuse(self.arrays, bad_row, tick + done)
            if need:
                self.enlarge_workspaces(2 * need)
            if not need or not work[0] & COUNT:  # the sort goes on from where it is
                return done, last_off

    def run(
        self,
        context: Context,
        tick: int,
        ticks: int,
        until: EngineStopCondition = NEVER,
        trace=UNTRACED,
    ) -> tuple[int, int]:
        """As `Engine.run`, in one call of the loop where one thread runs it."""
        if self.parts == 1 or len(until.numbers):
            return self.call(context, tick, ticks, self.whole_ticks(), until, trace)
        return self.run_shared(context, tick, ticks, trace)

    def run_shared(self, context: Context, tick: int, ticks: int, trace) -> tuple[int, int]:
        """The same, on all threads."""
        return super().run(context, tick, ticks, trace=trace)

    def open(self, context: Context, tick: int) -> None:
        """Freeze the flock for agents that decide one by one."""
        n = len(self.arrays.position)
        self.call(context, tick, 1, (BEFORE_SWEEP, 0, 1, 0, n))
        self.slot_of = np.argsort(self.slots.row)

    def one(self, context: Context, tick: int, row: int) -> None:
        """Let the agent of one row of an opened tick decide and move."""
        slot = int(self.slot_of[row])
        self.call(context, tick, 1, (SWEEP, 0, 1, slot, slot + 1))

    def run_ticks(self, context: Context, tick: int, ticks: int) -> None:  # noqa: ARG002 - one
        """One tick, each phase of it on all threads."""
        n = len(self.arrays.position)
        edges = [n * k // self.parts for k in range(self.parts + 1)]
        chunks = [n * k // (CHUNKS * self.parts) for k in range(CHUNKS * self.parts + 1)]
        spans = list(pairwise(chunks))
        own = [deque(spans[k * CHUNKS : (k + 1) * CHUNKS]) for k in range(self.parts)]

        def run_alone(phase: int) -> None:
            self.call(context, tick, 1, (phase, 0, self.parts, 0, n))

        def run_together(phase: int) -> None:
            self.team.run_on_all(
                lambda k: self.call(
                    context, tick, 1, (phase, k, self.parts, edges[k], edges[k + 1])
                )
            )

        def sweep(k: int) -> None:
            for owner in range(k, k + self.parts):
                own_cells = own[owner % self.parts]
                # A deque's `pop` and `popleft` are atomic: threads need no lock to share it.
                with suppress(IndexError):
                    while True:
                        span = own_cells.popleft() if owner == k else own_cells.pop()
                        self.call(context, tick, 1, (SWEEP, k, self.parts, *span))

        run_alone(PLAN)
        run_together(COUNT)
        run_alone(SHARE)
        run_together(PLACE)
        run_together(FILL)
        if self.module.SIGNALS:
            run_alone(PREPARE)
        self.team.run_on_all(sweep)


class SequentialEngine(LoopEngine):
    """Sequential or random activation: agents act one by one, each on what the others left."""

    knowledge: tuple[Any, ...] = ()
    """What else the compiled loop is given."""

    def __init__(
        self,
        module,
        arrays: Arrays,
        place: WorldContext,
        seed: int,
        shuffled: bool,
        called: Called = at_once,
    ):
        super().__init__(module, arrays, place, seed, called=called)
        self.shuffled = shuffled
        if module.CRASHES:
            self.enlarge_workspaces(max(256, len(arrays.ids)))

    def call(self, context, tick, order: np.ndarray, opens: bool) -> None:
        """Let the rows of `order` act, after opening the tick if `opens`."""
        first = 0
        while True:
            first, bad_row = self.called(
                self.module.advance,
                self.arrays,
                self.space,
                self.surroundings,
                self.grid,
                self.slots,
                self.workspaces[0],
                context,
                *self.knowledge,
                self.seed,
                tick,
                order,
                first,
                opens,
            )
            if bad_row >= 0:
                refuse(self.arrays, bad_row, tick)
            if first == len(order):
                return
            opens = False
            self.enlarge_workspaces(2 * self.capacity)

    def run_ticks(self, context: Context, tick: int, ticks: int) -> None:  # noqa: ARG002 - one
        """One tick, in which all act in turn."""
        self.call(context, tick, self.order(tick), True)

    def order(self, tick: int) -> np.ndarray:
        """The rows in the order in which they act: by identity, or shuffled by seed and tick."""
        keys = self.arrays.ids
        if self.shuffled:
            keys = uniform_numbers(self.seed, ORDERS + tick, keys, 1)[:, 0]
        return np.argsort(keys, kind="stable")

    def open(self, context: Context, tick: int) -> None:
        """Begin a tick in which agents are called one by one."""
        self.call(context, tick, np.empty(0, np.int64), True)

    def one(self, context: Context, tick: int, row: int) -> None:
        """Let the agent of one row act."""
        self.call(context, tick, np.array([row]), False)


class DelayedEngine(SequentialEngine):
    """Agents know of each other what messages have brought; none sees what others do in a tick."""

    def __init__(
        self,
        module,
        arrays: Arrays,
        place: WorldContext,
        seed: int,
        messages: MessageDelays,
        called: Called = at_once,
    ):
        super().__init__(module, arrays, place, seed, False, called)
        self.knowledge = messages, np.zeros(arrays.position.shape)
