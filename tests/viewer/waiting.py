"""Waits for what other threads do, and time that only waiting moves."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

COMPILED = 180.0
"""Seconds that a model, or what draws it, may take to be compiled, on a busy machine."""


def until(condition: Callable[[], Any], seconds: float = 60.0, what: str = "") -> Any:
    """The condition's value as soon as it is true. Fails after some seconds."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if value := condition():
            return value
        time.sleep(0.005)
    raise AssertionError(f"not within {seconds} s: {what or condition}")


class HandTime:
    """A clock that stands but while somebody waits for an event of its own.

    What is to happen by itself at some time happens while the clock passes that time.
    """

    def __init__(self) -> None:
        self.now = 0.0
        self.ahead: list[tuple[float, float, Callable[[], None]]] = []

    def __call__(self) -> float:
        return self.now

    def event(self) -> threading.Event:
        """An event; to wait for it moves this clock."""
        return HandEvent(self)

    def at(self, moment: float, happens: Callable[[], None], every: float = 0.0) -> None:
        """Have something happen, and again `every` so many seconds."""
        self.ahead.append((moment, every, happens))

    def wait(self, event: threading.Event, seconds: float) -> bool:
        """Let so much time pass, or less if the event is set meanwhile; whether it is."""
        end = self.now + seconds
        while not event.is_set():
            moment, every, happens = min(
                self.ahead, key=lambda it: it[0], default=(end + 1, 0, int)
            )
            if moment > end:
                self.now = end
                return False
            self.now = max(self.now, moment)
            self.ahead.remove((moment, every, happens))
            if every:
                self.at(moment + every, happens, every)
            happens()
        return True


class HandEvent(threading.Event):
    """An event for which nobody waits in earnest."""

    def __init__(self, time: HandTime):
        super().__init__()
        self.time = time

    def wait(self, timeout: float | None = None) -> bool:
        """Move the clock."""
        assert timeout is not None, "nobody would wake it"
        return self.time.wait(self, timeout)
