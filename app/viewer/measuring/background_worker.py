"""Work aside: one thing at a time, in a thread of its own, while the flock goes on."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any


class BackgroundWorker:
    """Does one piece of work at a time.

    >>> aside = BackgroundWorker()
    >>> aside.begin(lambda: 6 * 7)
    >>> while (done := aside.finished()) is None:
    ...     pass
    >>> done.result(), aside.idle
    (42, True)
    """

    def __init__(self) -> None:
        self.work: Future | None = None

    @property
    def idle(self) -> bool:
        """Whether there is nothing under way, or done and not yet fetched."""
        return self.work is None

    def begin(self, work: Callable[[], Any]) -> None:
        """Begin a piece of work; whatever was under way is forgotten."""
        future: Future = Future()
        self.work = future

        def run() -> None:
            try:
                future.set_result(work())
            except Exception as error:
                future.set_exception(error)

        threading.Thread(target=run, name="aside", daemon=True).start()

    def finished(self) -> Future | None:
        """The work that is done, once; None if there is none."""
        done = self.work
        if done is None or not done.done():
            return None
        self.work = None
        return done

    def forget(self) -> None:
        """Take no interest in what is under way."""
        self.work = None
