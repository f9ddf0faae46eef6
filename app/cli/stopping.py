"""Ctrl-C and SIGTERM: ask a run to stop where it can, so that what it has done is kept."""

from __future__ import annotations

import os
import signal
import sys
import threading
from types import FrameType
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Stopping:
    """While entered, the first signal sets `asked`; a second one interrupts at once.

    With `at_once`, the first one interrupts too, SIGTERM like Ctrl-C.
    """

    def __init__(self, at_once: bool = False):
        self.asked = False
        self.at_once = at_once
        self.before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Stopping:
        try:
            self.before = {one: signal.signal(one, self.take) for one in SIGNALS}
        except ValueError:  # only the main thread receives signals
            self.before = {}
        return self

    def __exit__(self, *_: object) -> None:
        for one, handler in self.before.items():
            signal.signal(one, handler)

    def take(self, _number: int, _frame: FrameType | None) -> None:
        """Take a signal."""
        if self.asked or self.at_once:
            raise KeyboardInterrupt
        self.asked = True


def leave() -> None:
    """End the process, which is done, even while one of its threads compiles.

    In the usual farewell LLVM takes away what that thread stands on: it would crash, or hang.
    """
    if threading.active_count() > 1:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)
