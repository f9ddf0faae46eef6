"""What goes wrong in viser's thread, in one line each: no traceback, and nothing that was sent."""

from __future__ import annotations

import asyncio
import logging
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

# Lines on standard error about what browsers do: few, and never what they sent.

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


HANDSHAKE = "opening handshake failed"
"""What websockets says of a connection that speaks no HTTP, or goes: nobody has to know."""


def describe_error(error: BaseException | None) -> str:
    """What an error is and where it came from, without its words: they may be a browser's.

    >>> describe_error(KeyError("secret"))
    'KeyError'
    """
    if error is None:
        return "no error is known"
    frames = traceback.extract_tb(error.__traceback__)
    where = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}{where}"


def log_failures(loop: asyncio.AbstractEventLoop, log: Log) -> None:
    """Have a loop's failed tasks in the log."""

    def failed(_loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        error = context.get("exception")
        if not isinstance(error, ConnectionError):
            why = context["message"] if error is None else describe_error(error)
            log.line(f"what a browser asked for failed: {why}")

    loop.set_exception_handler(failed)


class Lines(logging.Handler):
    """Has what websockets complains of in the log."""

    def __init__(self, log: Log):
        super().__init__(logging.ERROR)
        self.log = log

    def emit(self, record: logging.LogRecord) -> None:
        words = record.getMessage()
        if words != HANDSHAKE:
            error = record.exc_info[1] if record.exc_info else None
            self.log.line(f"{words}: {describe_error(error)}")


def make_logger(log: Log) -> logging.Logger:
    """A logger for websockets that prints no traceback."""
    made = logging.Logger("flockscope.browsers", logging.ERROR)
    made.addHandler(Lines(log))
    return made
