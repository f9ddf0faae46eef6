"""So much from each browser and no more, lest one that never stops keeps the others from being
heard."""

from __future__ import annotations

import time
from collections.abc import Callable

MOST = 300
"""Changes of values a second; a person who drags a slider makes 60."""


class Allowance:
    """Counts what each browser sends; used by one thread.

    >>> allowance = Allowance(most=2, clock=lambda: 5.0)
    >>> [allowance.has(browser) for browser in (1, 1, 1, 2)]
    [True, True, False, True]
    """

    def __init__(self, most: int = MOST, clock: Callable[[], float] = time.monotonic):
        self.most = most
        self.clock = clock
        self.second = 0
        self.sent: dict[int, int] = {}
        """By browser, in this second."""

    def has(self, browser: int) -> bool:
        """Whether a browser has some left for this second, of which one is taken."""
        second = int(self.clock())
        if second != self.second:
            self.second, self.sent = second, {}
        self.sent[browser] = self.sent.get(browser, 0) + 1
        return self.sent[browser] <= self.most
