"""Lines on standard error about what browsers do: few, and never what they sent."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable

MOST = 10
"""Lines within `PERIOD`."""
PERIOD = 60.0
"""Seconds."""


def on_standard_error(line: str) -> None:
    """Print a line for whoever runs the laboratory."""
    print(f"flockscope: {line}", file=sys.stderr, flush=True)


class Log:
    """Prints at most `MOST` lines a minute and counts the others; any thread may use it."""

    def __init__(
        self,
        write: Callable[[str], None] = on_standard_error,
        clock: Callable[[], float] = time.monotonic,
    ):
        self.write = write
        self.clock = clock
        self.lock = threading.Lock()
        self.began = clock()
        self.printed = 0
        self.left_out = 0

    def line(self, words: str) -> None:
        """Print a line, or count it."""
        with self.lock:
            if self.clock() - self.began >= PERIOD:
                self.began, self.printed = self.clock(), 0
                self.tell_left_out()
            if self.printed < MOST:
                self.printed += 1
                self.write(words)
            else:
                self.left_out += 1

    def tell_left_out(self) -> None:
        """Say how many lines were not printed, if any."""
        if self.left_out:
            self.printed += 1
            self.write(f"{self.left_out} more lines about browsers were not printed")
            self.left_out = 0

    def close(self) -> None:
        """Say what is left to be said."""
        with self.lock:
            self.tell_left_out()
