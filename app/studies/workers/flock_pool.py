"""Flocks that are begun again with other seeds: a cell's runs need one only."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from agents.flock import Flock
from app.studies.workers.run_worker import stop_if_unwanted
from worlds.input_error import InputError

MOST_FLOCKS = 64
MOST_AGENTS = 100_000
"""Of all flocks that a thread keeps."""
AT_ONCE = 10_000_000
"""Agent-steps between two looks at whether a run is still wanted: a second or so."""


class FlockPool(threading.local):
    """The flocks that a thread has begun lately, by what they are begun from."""

    def __init__(self) -> None:
        self.flocks: OrderedDict[int, tuple[Any, Flock]] = OrderedDict()

    def __reduce__(self) -> tuple[Any, ...]:
        return FlockPool, ()  # another process begins its own

    @contextmanager
    def begin(self, key: Any, seed: int, make: Callable[[], Flock]) -> Iterator[Flock]:
        """A flock at tick 0 with a seed; whoever has the same `key` may have it later.

        `make` makes one. `key` is an object, and not what equals it: a `Spec`, say.
        """
        # A flock whose run has raised is in no state that anybody knows: it is not put back.
        _, flock = self.flocks.pop(id(key), (key, None))
        if flock is None:
            self.make_room()
            flock = make()
        else:
            flock.restart(seed)
        yield flock
        if flock.options.start == "random":
            self.flocks[id(key)] = key, flock  # with the key alive nothing else has its id

    def make_room(self) -> None:
        """Forget the flocks that were not used for longest, until there is room for another."""
        agents = sum(len(flock.ids) for _, flock in self.flocks.values())
        while self.flocks and (len(self.flocks) >= MOST_FLOCKS or agents >= MOST_AGENTS):
            _, (_, flock) = self.flocks.popitem(last=False)
            agents -= len(flock.ids)


def run_ticks(flock: Flock, ticks: int) -> None:
    """Run ticks as `flock.run` does, for as long as somebody waits for the run.

    Raises InputError where a policy gives up: what is measured of the rest would be of another run.
    """
    at_once = max(1, AT_ONCE // max(1, len(flock.ids)))
    while ticks > 0:
        flock.run(min(ticks, at_once))
        ticks -= at_once
        if flock.faults:
            raise InputError(flock.faults[0])
        stop_if_unwanted()
