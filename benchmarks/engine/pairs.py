"""What a pair of neighbours costs where all agents are in one cell, and in many cells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from sweeps import HOMES
from turns import Contestant, Flight, Taken, take_turns, time_work

from agents import Flock

MODELS = ("vem", "couzin", "hwvem", "reynolds")
"""Those of `HOMES` whose agents have no body and so may be that close."""
WIDTH = 0.5
"""Side of the square or cube that they are in, in ranges of the rule: all see each other."""
CELLS = 40.5
"""Side of the box around it, in ranges; it has 40 cells."""
TICKS = 2


@dataclass(frozen=True)
class Pairs:
    """The costs of a model, nanoseconds of CPU time."""

    name: str
    pairs: int
    """Of neighbours, each seen from both."""
    agents: tuple[int, int]
    """In one cell, in many."""
    one: float
    many: float


def heap(model: str, agents: int) -> Flock:
    """Agents in the middle of a cell of a box that is else empty."""
    home = HOMES[model]
    few = home.flock(model, 2)
    reach = float(getattr(few.parameters, few.model.rule.reach))
    cell = CELLS / int(CELLS)
    middle = reach * cell * (int(CELLS) // 2 + 0.5)
    rng = np.random.default_rng(1)
    position = middle + reach * WIDTH * rng.uniform(-0.5, 0.5, (agents, home.dim))
    heading = rng.normal(size=position.shape)
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    start = {"position": position, "heading": heading}
    return home.boxed(model, reach * CELLS, start=start)


def from_the_start(make: Callable[[], Flock]) -> Flight:
    """A flock made anew for each turn, so that it stays as it begins."""

    def fly(ticks: int) -> Taken:
        flock = make()
        flock.run(1)
        return time_work(lambda: flock.run(ticks))

    return fly


def neighbours(flock: Flock) -> float:
    """Of all agents together."""
    return len(flock.ids) * float(flock.observe("mean-neighbours"))


def pairs(model: str, agents: int, rounds: int) -> Pairs:
    """The cost of a pair among so many agents in one cell, and of as many pairs at its density."""
    home = HOMES[model]
    count = neighbours(heap(model, agents))
    some = home.flock(model, 10 * agents)
    spread = round(count / neighbours(some) * len(some.ids))
    both = [
        Contestant("one", agents, TICKS, from_the_start(lambda: heap(model, agents))),
        Contestant("many", spread, TICKS, from_the_start(lambda: home.flock(model, spread))),
    ]
    take_turns(both, rounds)
    times, many = (contestant.least() * contestant.agents / count for contestant in both)
    return Pairs(model, round(count), (agents, spread), times, many)
