"""Run flocks of several models: in each tick a pass of each model, in which its own agents act.

All passes of a tick begin from the same state, so their order is of no account. In a pass all
agents are met, and all act, by whatever numbers; of those alone who go by its model what came of it
is kept. So each moves to the bit as in a flock of its model. A pass that lets others stand costs as
much, unless few act: most of it is the sort, and who has no relation meets nobody.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from agents.engine.arrays import Arrays, Context
from agents.engine.runner import Engine, LoopEngine

MOVING = ("position", "heading", "speed", "leg")
"""The arrays that a pass changes."""


class ModelPass(NamedTuple):
    """The pass of a kind that has a model of its own."""

    number: int
    """Of the kind."""
    engine: LoopEngine
    """It works on a copy of what moves."""
    context: Context


def copy_moving(arrays: Arrays) -> Arrays:
    """The same arrays, with copies of those that a pass changes."""
    return arrays._replace(**{name: getattr(arrays, name).copy() for name in MOVING})


class PassEngine(Engine):
    """Synchronous activation of a flock of several models: a pass of the flock's, and of each."""

    def __init__(
        self,
        first: LoopEngine,
        arrays: Arrays,
        passes: Sequence[ModelPass],
    ):
        self.first, self.arrays, self.passes = first, arrays, tuple(passes)
        self.module, self.surroundings = first.module, first.surroundings

    def pass_of(self, kind: float) -> ModelPass | None:
        """The pass in which agents of a kind act; None for that of the flock's own model."""
        return next((one for one in self.passes if one.number == kind), None)

    def begin_pass(self, one: ModelPass) -> None:
        """Let a pass begin from the flock as it is."""
        for name in MOVING:
            np.copyto(getattr(one.engine.arrays, name), getattr(self.arrays, name))

    def take_moves(self, one: ModelPass, rows: np.ndarray) -> None:
        """Keep what a pass has made of the agents of some rows."""
        for name in MOVING:
            getattr(self.arrays, name)[rows] = getattr(one.engine.arrays, name)[rows]

    def run_ticks(self, context: Context, tick: int, ticks: int) -> None:  # noqa: ARG002 - one
        """One tick, a pass of each model."""
        for one in self.passes:
            self.begin_pass(one)
            one.engine.run(with_wind_of(context, one.context), tick, 1)
        # The last on the flock's own arrays: a fault in one before has changed nothing.
        self.first.run(context, tick, 1)
        for one in self.passes:
            self.take_moves(one, np.flatnonzero(self.arrays.kind == one.number))

    def open(self, context: Context, tick: int) -> None:
        """Freeze the flock for agents that decide one by one."""
        for one in self.passes:
            self.begin_pass(one)
            one.engine.open(with_wind_of(context, one.context), tick)
        self.first.open(context, tick)

    def one(self, context: Context, tick: int, row: int) -> None:
        """Let the agent of one row of an opened tick decide and move."""
        mine = self.pass_of(self.arrays.kind[row])
        if mine is None:
            self.first.one(context, tick, row)
            return
        mine.engine.one(with_wind_of(context, mine.context), tick, row)
        self.take_moves(mine, np.array([row]))


def with_wind_of(context: Context, other: Context) -> Context:
    """Another context with the wind of a context."""
    return other._replace(wind=context.wind, since=context.since)
