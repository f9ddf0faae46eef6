"""Run the compiled ticks of a rule that is a sum over pairs."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from agents.engine.arrays import NEVER, Arrays, Context, WorldContext, index_type, no_heeds
from agents.engine.cells import Slots
from agents.engine.heeding import COLUMNS
from agents.engine.pairs import tick as pairs
from agents.engine.pairs.pair_workspace import PairWorkspace, empty_notes
from agents.engine.pairs.thread_barrier import BAD, STOP
from agents.engine.runner import UNTRACED, Called, SynchronousEngine, Team, at_once, refuse
from agents.engine.vector_lanes import WIDTH

SPLIT_FROM = 10_000
"""Agents below which one thread is faster than several, which meet within compiled code."""


def padded_slots(n: int, dim: int, speeds: bool, kinds: bool) -> Slots:
    """Empty arrays for a sorted copy of n agents that is read eight at a time."""
    padded = n + WIDTH
    x, y, z, ux, uy, uz = (np.zeros(padded if axis % 3 < dim else 0) for axis in range(6))
    index = index_type(n)
    cell, queue = np.zeros(n, index), np.zeros(n, index)
    speed = np.zeros(padded if speeds else 0)
    row, signal = np.zeros(padded, index)[:n], np.empty((0, n))
    kind = np.zeros(padded if kinds else 0)
    return Slots(cell, row, x, y, z, ux, uy, uz, speed, signal, queue, kind, no_heeds(False))


class PairEngine(SynchronousEngine):
    """Synchronous activation: all agents decide on the same state, eight at a time."""

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
        self.meeting = np.zeros(BAD + self.parts, np.int64)

    def empty_slots(self) -> Slots:
        """Room for a sorted copy of the agents that is read eight at a time."""
        n, dim = self.arrays.position.shape
        return padded_slots(n, dim, self.module.ASKS_SPEED, self.module.KINDS)

    def enlarge_workspaces(self, capacity: int) -> None:
        """Give each thread its notes, in which there is room for any number of agents."""
        self.capacity = capacity
        self.workspaces = [self.empty_notes() for _ in range(self.parts)]

    def empty_notes(self, nearest: int = 1, kinds: int = 0) -> PairWorkspace:
        """A thread's notes, for so many nearest agents and kinds."""
        loop, points = self.module, self.surroundings.most_points
        index = self.grid.start.dtype
        return empty_notes(loop.ALL_SUMS, loop.PRIVATE, points, index, nearest, kinds)

    def arguments(self, context, tick, ticks, work, until=NEVER, trace=UNTRACED) -> tuple:
        """What the compiled loop is called with."""
        part = work[1]
        notes, kinds = self.workspaces[part], len(context.relations)
        if context.nearest > len(notes.least) or len(notes.relations) != kinds * COLUMNS:
            self.workspaces[part] = self.empty_notes(max(1, context.nearest), kinds)
        *before, _, _ = super().arguments(context, tick, ticks, work)
        return *before, self.meeting, until, trace

    def whole_ticks(self) -> tuple[int, ...]:
        """What asks the compiled loop for all that belongs to a tick, of all agents."""
        return pairs.RUN, 0, 1, 0

    def call(self, context, tick, ticks, work, until=NEVER, trace=UNTRACED):
        """One call of the compiled loop."""
        done, last_off, bad_row = self.called(
            self.module.advance, *self.arguments(context, tick, ticks, work, until, trace)
        )
        if bad_row >= 0:
            refuse(self.arrays, bad_row, tick + done)
        return done, last_off

    def run_shared(self, context: Context, tick: int, ticks: int, trace) -> tuple[int, int]:
        """Run ticks on all threads, which meet within compiled code."""

        def share(part: int) -> None:
            try:
                work = pairs.RUN, part, self.parts, 0
                self.call(context, tick, ticks, work, NEVER, trace)
            except BaseException:
                self.meeting[STOP] = 1
                raise

        try:
            self.team.run_on_all(share)
        except BaseException:  # those that wait for one that will not come leave, nothing done
            self.meeting[STOP] = 1
            self.meeting = np.zeros_like(self.meeting)
            self.team = Team(self.parts)
            raise
        return ticks, -1

    def open(self, context: Context, tick: int) -> None:
        """Freeze the flock for agents that decide one by one."""
        self.call(context, tick, 1, (pairs.OPEN, 0, 1, 0))
        self.slot_of = np.argsort(self.slots.row)

    def one(self, context: Context, tick: int, row: int) -> None:
        """Let the agent of one row of an opened tick decide and move."""
        self.call(context, tick, 1, (pairs.ONE, 0, 1, int(self.slot_of[row])))
