"""What a tracking source is: the contract for a new one."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Protocol

from app.live.control.pose import MocapFrame


class Source(Protocol):
    """Gives frames until it is told to stop; a value that a child process can be handed.

    It must survive pickling: keep what was asked for (a host, a path), and open it in `frames`.
    """

    @property
    def name(self) -> str:
        """Its kind, e.g. "optitrack"."""
        ...

    @property
    def longest_gap(self) -> float:
        """Seconds without a frame after which its connection is taken for lost, and opened again;
        infinite where frames may lie as far apart as they like, as in a recording, and for a
        source that has no such attribute."""
        ...

    def frames(self, stop: threading.Event) -> Iterator[MocapFrame]:
        """Connect, then return what gives the frames as they come.

        It runs in a child process and may block: while it connects for the timeout of the
        `Feed`, between frames for ever. `received` is read from `time.monotonic()` as soon as a
        frame is there, and numbers rise. It ends when `stop` is set or when there is no more.

        Raises InputError, OSError or RuntimeError with one line for whoever started it.
        """
        ...

    def describe(self) -> str:
        """What it is in a few words, e.g. "optitrack at 192.168.1.5 (y up, m)"."""
        ...
