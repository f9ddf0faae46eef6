"""Events of a laboratory, each with its time, its words and its cause."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import overload

KEPT = 10_000
"""Events that are kept in memory; the recording has them all."""


@dataclass(frozen=True)
class Event:
    """Something that happened."""

    tick: int
    """Tick of the control loop."""
    time: float
    """`time.monotonic()` of the machine that runs the loop, s."""
    kind: str
    """Of which kind: a request (`arm`, `emergency`, ...), a reason to stop, or `run`, `stop`."""
    words: str
    """The event in words."""
    car: str = ""
    """The car that it is about; empty: all."""
    cause: str = ""
    """Who or what caused it, where that is not the loop itself."""
    asked: str = ""
    """The request that it answers; with `cause` and `note` all that a replay needs."""
    note: str = ""
    """What the request said."""


class Events:
    """All events, of which the newest are kept; one thread writes, any may read.

    It is read as a list is, and counts from the first event that there ever was: those that are no
    longer kept are left out of a slice, and change the place of no other.

    >>> log = Events(kept=2)
    >>> for tick, kind in enumerate(("arm", "run", "stop")):
    ...     log.add(Event(tick, 0.01 * tick, kind, kind))
    >>> len(log), [event.kind for event in log[0:]], [event.kind for event in log[2:]]
    (3, ['run', 'stop'], ['stop'])
    """

    def __init__(self, kept: int = KEPT) -> None:
        self.count = 0
        self.kept: deque[Event] = deque(maxlen=kept)
        self.lock = threading.Lock()

    def add(self, *events: Event) -> None:
        """Write events down."""
        with self.lock:
            self.kept.extend(events)
            self.count += len(events)

    def since(self, count: int) -> tuple[int, list[Event]]:
        """How many there are, and those after the first `count` as far as they are kept.

        >>> log = Events()
        >>> log.add(Event(0, 0.0, "run", "runs"), Event(1, 0.01, "stop", "stops"))
        >>> [event.kind for event in log.since(1)[1]]
        ['stop']
        """
        with self.lock:
            new = min(self.count - count, len(self.kept))
            return self.count, list(self.kept)[len(self.kept) - new :] if new > 0 else []

    @property
    def dropped(self) -> int:
        """How many are no longer kept."""
        with self.lock:
            return self.count - len(self.kept)

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[Event]:
        return iter(self[:])

    @overload
    def __getitem__(self, which: int, /) -> Event: ...
    @overload
    def __getitem__(self, which: slice, /) -> list[Event]: ...
    def __getitem__(self, which: int | slice, /) -> Event | list[Event]:
        with self.lock:
            gone = self.count - len(self.kept)
            if isinstance(which, int):
                place = range(self.count)[which] - gone
                if place < 0:
                    raise IndexError(f"event {which} is no longer kept")
                return self.kept[place]
            places = range(self.count)[which]
            return [self.kept[place - gone] for place in places if place >= gone]
