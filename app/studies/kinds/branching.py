"""Which way through the algorithm agents take: the thesis, figures 3.5 and 4.5."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from agents.inspection import obstacle_push
from app.studies.kinds.kind_settings import PERCENT, Measure, Number, Settings
from app.studies.kinds.zoning import BRANCHES, around_of, branch_of
from worlds.obstacles import Box

if TYPE_CHECKING:
    from agents import Flock
    from agents.snapshot import FlockState

MARGIN = 1.0
"""Around a block, in which nobody starts, length."""


class BranchingSettings(Settings):
    """How long a flock is followed, and how often it is looked at."""

    kind: ClassVar[str] = "branching"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("obstacle", "obstacle", "Of all: an obstacle ahead pushes", "%", bounds=PERCENT),
        Measure("nobody", "nobody", "Of all: nobody is noticed", "%", bounds=PERCENT),
        Measure("repelled", "(3.9)", "Of all: repelled", "%", bounds=PERCENT),
        Measure("aligned", "(3.10)", "Of all: align only", "%", bounds=PERCENT),
        Measure("attracted", "(3.11)", "Of all: attracted only", "%", bounds=PERCENT),
        Measure("both", "(3.12)", "Of all: align and are attracted", "%", bounds=PERCENT),
    )

    limit: int = Field(ge=1)
    """Ticks that a flock is followed."""
    every: int = Field(ge=1)
    """Ticks from one look to the next; the first is before the first tick."""
    block: float | None = Field(None, gt=0.0)
    """Side of a square block in the middle of the box, in the plane; None: the world as it is."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Count which way agents that fly take; of agents times looks."""
        flock = self.prepared(flock)
        counts, pushed, all_of_them = np.zeros(len(BRANCHES)), 0, 0
        for tick in range(0, self.limit + 1, self.every):
            between()
            flock.run(tick - flock.tick)
            for row in np.flatnonzero(flock.active):
                counts[branch_of(around_of(flock, int(row)).zone)] += 1
                pushed += bool(push_on(flock, int(row)).any())
                all_of_them += 1
        shares = 100.0 * counts / max(1, all_of_them)
        found: dict[str, Number | None] = dict(zip(BRANCHES, shares.tolist(), strict=True))
        return found | {"obstacle": 100.0 * pushed / max(1, all_of_them)}

    def prepared(self, flock: Flock) -> Flock:
        """The flock as it is followed: with the block, where there is to be one."""
        return flock if self.block is None else with_block(flock, self.block)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All; a look costs as much as many."""
        return self.limit * (1.0 + 20.0 / self.every)


def with_block(flock: Flock, side: float) -> Flock:
    """The same flock at its start with a square block in the middle of its box.

    Agents that would stand in it, or at it, stand beside it.
    """
    world = flock.world
    middle = np.array(world.low) + 0.5 * np.array(world.size)
    low, high = middle - 0.5 * side, middle + 0.5 * side
    block = Box(shape="box", low=tuple(low.tolist()), high=tuple(high.tolist()))
    position = flock.position.copy()
    near = (np.abs(position - middle) < 0.5 * side + MARGIN).all(axis=1)
    position[near, 0] += side + 2.0 * MARGIN
    start = {"position": position, "heading": flock.heading.copy(), "speed": flock.speed.copy()}
    spec = flock.options.but(world=replace(world, obstacles=(block,)), size=None)
    return type(flock)(spec, start=start)


def block_of(flock: FlockState):
    """The block as a polygon of shapely."""
    return flock.world.obstacles[0].footprint()


def push_on(flock: Flock, row: int) -> np.ndarray:
    """The force (4.1) of the obstacles on an agent, as its rule has it, (dim,)."""
    surroundings, context = flock.engine.surroundings, flock.context
    return obstacle_push(flock, surroundings, context, row, flock.interpret)
