"""What happened in a laboratory: every event with its time, its words and its cause."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass

KEPT = 10_000
"""Events that are kept in memory; the recording has them all."""


@dataclass(frozen=True)
class Event:
    """Something that happened."""

    tick: int
    """Of the control loop."""
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
    """The latest events; one thread writes, any may read."""

    def __init__(self) -> None:
        self.count = 0
        self.kept: deque[Event] = deque(maxlen=KEPT)
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
