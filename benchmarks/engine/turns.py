"""Contestants take turns, so that a drift of the machine's speed reaches all of them."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from rich.console import Console
from rich.progress import Progress


@dataclass(frozen=True)
class Taken:
    """What a piece of work took, seconds."""

    cpu: float
    """Of all threads of its process."""
    wall: float


type Flight = Callable[[int], Taken]
"""Runs so many ticks of a flock and says what they took."""


def time_work(work: Callable[[], object]) -> Taken:
    """What a piece of work takes."""
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return Taken(time.process_time() - cpu, time.perf_counter() - wall)


def flight_of(flock: Any) -> Flight:
    """A flock that flies on in every turn."""

    def fly(ticks: int) -> Taken:
        return time_work(lambda: flock.run(ticks))

    return fly


@dataclass
class Contestant:
    """A flock of so many agents that runs the same number of ticks in each round."""

    name: str
    agents: int
    ticks: int
    flight: Flight
    taken: list[Taken] = field(default_factory=list)
    """Its rounds so far."""

    def per_step(self, clock: str = "cpu") -> list[float]:
        """Nanoseconds of an agent-step in each round, by the clock `cpu` or `wall`."""
        return [
            1e9 * getattr(seconds, clock) / (self.agents * self.ticks) for seconds in self.taken
        ]

    def least(self, clock: str = "cpu") -> float:
        """The least of them."""
        return min(self.per_step(clock))

    def median(self, clock: str = "cpu") -> float:
        """The median of them."""
        return statistics.median(self.per_step(clock))


def with_progress[Item](
    items: Sequence[Item], doing: str, weight: Callable[[Item], float] = lambda _: 1.0
) -> Iterator[Item]:
    """The items, with a bar and the time left where people watch; `weight` is each one's share."""
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(doing, total=sum(weight(item) for item in items))
        for item in items:
            yield item
            bar.advance(task, weight(item))


def take_turns(contestants: Sequence[Contestant], rounds: int, doing: str = "") -> None:
    """Run so many rounds, in each of which every contestant has its turn; a bar if it has a name.

    One more comes first and does not count: it compiles what is not compiled.
    """
    turns = [*contestants] * (rounds + 1)
    for contestant in with_progress(turns, doing) if doing else turns:
        contestant.taken.append(contestant.flight(contestant.ticks))
    for contestant in contestants:
        del contestant.taken[0]


def quartiles(values: Sequence[float]) -> tuple[float, float]:
    """The values that a quarter of all are below, and above."""
    if len(values) == 1:
        return values[0], values[0]
    low, _, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, high
