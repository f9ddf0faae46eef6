"""So many at once, and so many a second."""

from __future__ import annotations

import time
from collections.abc import Callable


class RateLimit:
    """Lets `most` pass at once and `rate` a second from then on; used by one thread.

    >>> limit = RateLimit(rate=1.0, most=2.0, clock=lambda: 5.0)
    >>> [limit.take() for _ in range(3)]
    [True, True, False]
    """

    def __init__(self, rate: float, most: float, clock: Callable[[], float] = time.monotonic):
        self.rate = rate
        self.most = most
        self.clock = clock
        self.left = most
        self.known = clock()

    def fill(self) -> float:
        """How much is left now; below 0 is owed."""
        now = self.clock()
        self.left = min(self.most, self.left + (now - self.known) * self.rate)
        self.known = now
        return self.left

    def take(self, cost: float = 1.0) -> bool:
        """Take so much if it is there; whether it was."""
        if self.fill() < cost:
            return False
        self.left -= cost
        return True

    def turn(self, longest: float, cost: float = 1.0) -> float | None:
        """Seconds until so much will be there, which is taken now; None if longer than `longest`.

        >>> limit = RateLimit(rate=2.0, most=1.0, clock=lambda: 5.0)
        >>> [limit.turn(longest=0.6) for _ in range(3)]
        [0.0, 0.5, None]
        """
        wait = max(0.0, (cost - self.fill()) / self.rate)
        if wait > longest:
            return None
        self.left -= cost
        return wait

    def give_back(self, cost: float) -> None:
        """Have so much back that was taken."""
        self.left = min(self.most, self.fill() + cost)

    def owe(self, cost: float, deepest: float) -> None:
        """Take so much whether it is there or not, but never owe more than `deepest`."""
        self.left = max(self.fill() - cost, -deepest)
