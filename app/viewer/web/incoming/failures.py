"""What goes wrong in viser's thread, in one line each: no traceback, and nothing that was sent."""

from __future__ import annotations

import asyncio
import logging
import traceback
from pathlib import Path
from typing import Any

from app.viewer.web.incoming.log import Log

HANDSHAKE = "opening handshake failed"
"""What websockets says of a connection that speaks no HTTP, or goes: nobody has to know."""


def in_a_line(error: BaseException | None) -> str:
    """What an error is and where it came from, without its words: they may be a browser's.

    >>> in_a_line(KeyError("secret"))
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
            log.line(f"what a browser asked for failed: {in_a_line(error)}")

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
            self.log.line(f"{words}: {in_a_line(error)}")


def logger(log: Log) -> logging.Logger:
    """A logger for websockets that prints no traceback."""
    made = logging.Logger("flockscope.browsers", logging.ERROR)
    made.addHandler(Lines(log))
    return made
