"""Work aside: one thing at a time, in a thread of its own, while the flock goes on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from typing import Any


class BackgroundWorker:
    """Does one piece of work at a time.

    >>> aside = BackgroundWorker()
    >>> aside.begin(lambda: 6 * 7)
    >>> while (done := aside.finished()) is None:
    ...     pass
    >>> done.result(), aside.idle
    (42, True)
    """

    def __init__(self) -> None:
        self.work: Future | None = None

    @property
    def idle(self) -> bool:
        """Whether there is nothing under way, or done and not yet fetched."""
        return self.work is None

    def begin(self, work: Callable[[], Any]) -> None:
        """Begin a piece of work; whatever was under way is forgotten."""
        future: Future = Future()
        self.work = future

        def run() -> None:
            try:
                future.set_result(work())
            except Exception as error:
                future.set_exception(error)

        threading.Thread(target=run, name="aside", daemon=True).start()

    def finished(self) -> Future | None:
        """The work that is done, once; None if there is none."""
        done = self.work
        if done is None or not done.done():
            return None
        self.work = None
        return done

    def forget(self) -> None:
        """Take no interest in what is under way."""
        self.work = None


# Keeps costly work from starving the flock.


class WorkThrottle:
    """Lets work happen at most every `period` s and take at most `share` of all time.

    The first time does not count: it may have had to compile.

    >>> rate_limit = WorkThrottle(period=0.25, share=0.1)
    >>> rate_limit.note_duration(now=-9.0, seconds=3.0)
    >>> rate_limit.is_due(now=0.0)
    True
    >>> rate_limit.note_duration(now=0.0, seconds=0.05)  # 50 ms: not again within 500 ms
    >>> rate_limit.is_due(now=0.4)
    False
    """

    def __init__(self, period: float, share: float):
        self.period = period
        self.share = share
        self.next = 0.0
        self.counts = False

    def is_due(self, now: float) -> bool:
        """Whether the work may be done now."""
        return now >= self.next

    def note_duration(self, now: float, seconds: float) -> None:
        """Note that work begun at `now` took so long."""
        self.next = now + max(self.period, seconds / self.share if self.counts else 0.0)
        self.counts = True

    @contextmanager
    def measure_duration(self) -> Iterator[None]:
        """Do the work and note what it took, even if it fails."""
        now = time.perf_counter()
        try:
            yield
        finally:
            self.note_duration(now, time.perf_counter() - now)

    def renew(self) -> None:
        """Let the work be done at once."""
        self.next = 0.0
