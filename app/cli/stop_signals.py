"""Ctrl-C and SIGTERM: ask a run to stop where it can, so that what it has done is kept."""

from __future__ import annotations

import os
import signal
import sys
import threading
from types import FrameType
from typing import Any

from app.cli.error_messages import INTERRUPTED

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """While entered, the first signal sets `asked`; a second one interrupts at once.

    With `at_once`, the first one interrupts too, SIGTERM like Ctrl-C, and a second one ends the
    process with this line: what an interrupt breaks off while it is being closed cannot be closed
    any more, and would say so in a traceback. Processes of ours end with the one that began them.
    """

    def __init__(self, at_once: str = ""):
        self.asked = False
        self.at_once = at_once
        self.before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> StopSignals:
        try:
            self.before = {one: signal.signal(one, self.take) for one in SIGNALS}
        except ValueError:  # only the main thread receives signals
            self.before = {}
        return self

    def __exit__(self, *_: object) -> None:
        interrupted = bool(self.asked and self.at_once)
        for one, handler in self.before.items():
            # Another one while the interpreter ends is to end it, without a traceback.
            signal.signal(one, signal.SIG_DFL if interrupted else handler)

    def take(self, _number: int, _frame: FrameType | None) -> None:
        """Take a signal."""
        if self.asked and self.at_once:
            shown = "\n\x1b[?25h" if os.isatty(2) else ""  # below a bar, which hides the cursor
            os.write(2, f"{shown}{self.at_once}\n".encode())  # `print` may be interrupted in itself
            os._exit(INTERRUPTED)
        interrupts = self.asked or self.at_once
        self.asked = True
        if interrupts:
            raise KeyboardInterrupt


def leave() -> None:
    """End the process, which is done, even while one of its threads compiles.

    In the usual farewell LLVM takes away what that thread stands on: it would crash, or hang.
    """
    if threading.active_count() > 1:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)
