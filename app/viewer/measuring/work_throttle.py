"""Keeps costly work from starving the flock."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager


class WorkThrottle:
    """Lets work happen at most every `period` s and take at most `share` of all time.

    The first time does not count: it may have had to compile.

    >>> rate_limit = WorkThrottle(period=0.25, share=0.1)
    >>> rate_limit.spent(now=-9.0, seconds=3.0)
    >>> rate_limit.due(now=0.0)
    True
    >>> rate_limit.spent(now=0.0, seconds=0.05)  # took 50 ms: not again before 500 ms have passed
    >>> rate_limit.due(now=0.4)
    False
    """

    def __init__(self, period: float, share: float):
        self.period = period
        self.share = share
        self.next = 0.0
        self.counts = False

    def due(self, now: float) -> bool:
        """Whether the work may be done now."""
        return now >= self.next

    def spent(self, now: float, seconds: float) -> None:
        """Note that work begun at `now` took so long."""
        self.next = now + max(self.period, seconds / self.share if self.counts else 0.0)
        self.counts = True

    @contextmanager
    def measured(self) -> Iterator[None]:
        """Do the work and note what it took, even if it fails."""
        now = time.perf_counter()
        try:
            yield
        finally:
            self.spent(now, time.perf_counter() - now)

    def renew(self) -> None:
        """Let the work be done at once."""
        self.next = 0.0
