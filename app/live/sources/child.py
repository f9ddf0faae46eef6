"""The child process of a feed: runs a source, and leaves when it is told to or its parent is gone.

What a source's library does in C cannot be interrupted from Python: it may block for ever, and even
hold the interpreter. The way out is therefore always to end the process.
"""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Literal

from app.live.control.pose import MocapFrame
from app.live.sources.pose_source import Source

GRACE = 0.5
"""Seconds that a source has to end by itself once it is told to."""

BEAT = 1.0
"""Seconds between two signs of life, where the library leaves the interpreter free meanwhile."""

type Message = (
    tuple[Literal["connected", "ended", "alive"], None]
    | tuple[Literal["trouble"], str]
    | tuple[Literal["frame"], MocapFrame]
)


def serve(source: Source, line: Connection, timeout: float) -> None:
    """Send through `line` that the source is connected, its frames, its trouble and its end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends us
    silence()
    stop = threading.Event()
    threading.Thread(target=_heed, args=(line, stop), daemon=True).start()
    to_parent = _ToParent(line)
    threading.Thread(target=_beat, args=(to_parent,), daemon=True).start()
    outcome = _outcome(source, stop, to_parent, timeout)
    with suppress(OSError):  # the parent is gone
        to_parent.send(outcome)


class _ToParent:
    """The way to the parent, for several threads."""

    def __init__(self, line: Connection) -> None:
        self.line = line
        self.lock = threading.Lock()

    def send(self, message: Message) -> None:
        """Send a message whole. Raises OSError if the parent is gone."""
        with self.lock:
            self.line.send(message)


def _beat(line: _ToParent) -> None:
    """Give signs of life. A library that hangs while it holds the interpreter stops them."""
    with suppress(OSError):
        while True:
            time.sleep(BEAT)
            line.send(("alive", None))


def silence() -> None:
    """Let libraries print nowhere: they would print to the terminal that the laboratory uses.

    The errors too: one prints each name that a stream tells, which anybody in its network can send.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    os.close(nowhere)


def _outcome(source: Source, stop: threading.Event, line: _ToParent, timeout: float) -> Message:
    """Pass on the frames until there are no more; how that came about."""
    try:
        frames = _connected(source, stop, timeout)
        line.send(("connected", None))
        for frame in frames:
            line.send(("frame", frame))
            if stop.is_set():
                break
    except Exception as trouble:
        return ("trouble", _one_line(trouble))
    return ("ended", None)


def _connected(source: Source, stop: threading.Event, timeout: float) -> Iterator[MocapFrame]:
    """Its frames, once it is connected.

    Should it hang while it holds the interpreter, and the parent be gone, then nothing but a clock
    that is none of Python's can end this process.
    """
    with open(os.devnull, "w") as nowhere:
        faulthandler.dump_traceback_later(timeout + 2.0, exit=True, file=nowhere)
        try:
            return source.frames(stop)
        finally:
            faulthandler.cancel_dump_traceback_later()


def _heed(line: Connection, stop: threading.Event) -> None:
    """Wait for the parent to say stop, or to be gone; then leave, whatever the source does."""
    with suppress(EOFError, OSError):
        line.recv()
    stop.set()
    time.sleep(GRACE)
    os._exit(0)


def _one_line(trouble: Exception) -> str:
    """What went wrong; errors that only a mistake in a source can raise are named by their kind."""
    text = " ".join(str(trouble).split()) or type(trouble).__name__
    expected = isinstance(trouble, (ValueError, OSError, RuntimeError))
    return text if expected else f"{type(trouble).__name__}: {text}"
