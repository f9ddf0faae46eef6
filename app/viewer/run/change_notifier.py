"""That there is something new to draw, told to each of those who draw it."""

from __future__ import annotations

import threading


class ChangeNotifier(threading.Event):
    """An event that sets others too: each of those who wait clears its own.

    >>> news, other = ChangeNotifier(), threading.Event()
    >>> news.tell(other)
    >>> news.set()
    >>> other.is_set()
    True
    """

    def __init__(self) -> None:
        super().__init__()
        self.others: frozenset[threading.Event] = frozenset()

    def tell(self, other: threading.Event) -> None:
        """Set another event as well from now on."""
        self.others |= {other}

    def forget(self, other: threading.Event) -> None:
        """Do so no more."""
        self.others -= {other}

    def set(self) -> None:
        super().set()
        for one in self.others:
            one.set()
