"""Run the compiled ticks of a rule that is a sum over pairs."""

from __future__ import annotations

import numpy as np

from agents.engine.arrays import (
    NEVER,
    Arrays,
    Context,
    EngineStopCondition,
    WorldContext,
    empty_grid,
    index_type,
    no_heeds,
)
from agents.engine.cells import Slots
from agents.engine.heeding import COLUMNS
from agents.engine.pairs import tick as pairs
from agents.engine.pairs.pair_workspace import PairWorkspace, empty_notes
from agents.engine.pairs.thread_barrier import BAD, STOP
from agents.engine.runner import SEED_AT, UNTRACED, Called, Team, at_once, refuse
from agents.engine.stored_call import StoredTick
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


class PairEngine:
    """Synchronous activation: all agents decide on the same state, eight at a time."""

    def __init__(
        self,
        module,
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
        n, dim = arrays.position.shape
        self.parts = max(1, threads)
        self.slots = padded_slots(n, dim, module.ASKS_SPEED, module.KINDS)
        self.grid = empty_grid(n, self.parts)
        self.index = self.grid.start.dtype
        self.notes = [self.empty_notes() for _ in range(self.parts)]
        self.meeting = np.zeros(BAD + self.parts, np.int64)
        self.team = Team(self.parts)
        self.slot_of = np.empty(0, np.int64)

    def empty_notes(self, nearest: int = 1, kinds: int = 0) -> PairWorkspace:
        """A thread's notes, for so many nearest agents and kinds."""
        loop, points = self.module, self.surroundings.most_points
        return empty_notes(loop.ALL_SUMS, loop.PRIVATE, points, self.index, nearest, kinds)

    def arguments(self, context, tick, ticks, work, until=NEVER, trace=UNTRACED) -> tuple:
        """What the compiled loop is called with."""
        part = work[1]
        notes, kinds = self.notes[part], len(context.relations)
        if context.nearest > len(notes.least) or len(notes.relations) != kinds * COLUMNS:
            self.notes[part] = self.empty_notes(max(1, context.nearest), kinds)
        return (
            self.arrays,
            self.space,
            self.surroundings,
            self.grid,
            self.slots,
            self.notes[part],
            context,
            self.seed,
            tick,
            ticks,
            work,
            self.meeting,
            until,
            trace,
        )

    def store_tick(self, context: Context, tick: int) -> StoredTick:
        """The call of one tick."""
        arguments = self.arguments(context, tick, 1, (pairs.RUN, 0, 1, 0))
        return StoredTick(self.module.advance, arguments, SEED_AT)

    def call(self, context, tick, ticks, work, until=NEVER, trace=UNTRACED):
        """One call of the compiled loop."""
        done, last_off, bad_row = self.called(
            self.module.advance, *self.arguments(context, tick, ticks, work, until, trace)
        )
        if bad_row >= 0:
            refuse(self.arrays, bad_row, tick + done)
        return done, last_off

    def run(
        self,
        context: Context,
        tick: int,
        ticks: int,
        until: EngineStopCondition = NEVER,
        trace=UNTRACED,
    ):
        """Run ticks; returns (ticks done, last tick at which `until` did not hold or -1).

        `trace` (ticks, N, dim), if given, receives the positions after each tick.
        """
        if self.parts == 1 or len(until.numbers):
            return self.call(context, tick, ticks, (pairs.RUN, 0, 1, 0), until, trace)

        def share(part: int) -> None:
            try:
                work = pairs.RUN, part, self.parts, 0
                self.call(context, tick, ticks, work, until, trace)
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
