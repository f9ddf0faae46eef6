"""Contestants take turns, so that a drift of the machine's speed reaches all of them."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from rich.console import Console
from rich.progress import track


@dataclass(frozen=True)
class Taken:
    """What a piece of work took, seconds."""

    cpu: float
    """Of all threads of its process."""
    wall: float


def clocked(work: Callable[[], object]) -> Taken:
    """What a piece of work takes."""
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return Taken(time.process_time() - cpu, time.perf_counter() - wall)


@dataclass
class Contestant:
    """Something that does the same amount of work in each round."""

    name: str
    steps: int
    """Agent-steps of a round."""
    turn: Callable[[], Taken]
    """A round of it."""
    taken: list[Taken] = field(default_factory=list)
    """Its rounds so far."""

    def per_step(self, clock: str) -> list[float]:
        """Seconds of an agent-step in each round, by the clock `cpu` or `wall`."""
        return [getattr(one, clock) / self.steps for one in self.taken]

    def least(self, clock: str) -> float:
        """The least of them."""
        return min(self.per_step(clock))

    def median(self, clock: str) -> float:
        """The median of them."""
        return statistics.median(self.per_step(clock))


def watched[Item](items: Sequence[Item], doing: str) -> Iterable[Item]:
    """The items, with a bar of progress and the time left where people watch."""
    console = Console(stderr=True)
    return track(items, doing, console=console, transient=True, disable=not console.is_terminal)


def take_turns(contestants: Sequence[Contestant], rounds: int, doing: str = "rounds") -> None:
    """Run so many rounds, in each of which every contestant has its turn.

    One more comes first and does not count: it compiles what is not compiled.
    """
    for contestant in watched([*contestants] * (rounds + 1), doing):
        contestant.taken.append(contestant.turn())
    for contestant in contestants:
        del contestant.taken[0]


def quartiles(values: Sequence[float]) -> tuple[float, float]:
    """The values that a quarter of all are below, and above."""
    if len(values) == 1:
        return values[0], values[0]
    low, _, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, high
