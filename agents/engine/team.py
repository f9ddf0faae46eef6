"""A few threads that share one job, with as little overhead as Python allows."""

from __future__ import annotations

import threading
from collections.abc import Callable
from queue import SimpleQueue
from weakref import finalize


class Team:
    """`size` threads, the caller among them, for jobs that free the GIL.

    The helpers end when the team is no longer referred to.
    """

    def __init__(self, size: int):
        self.size = size
        self.inboxes: list[SimpleQueue] = [SimpleQueue() for _ in range(size - 1)]
        self.outbox: SimpleQueue = SimpleQueue()
        for inbox in self.inboxes:
            threading.Thread(target=run_helper, args=(inbox, self.outbox), daemon=True).start()
        finalize(self, dismiss, self.inboxes)

    def run_on_all(self, job: Callable[[int], None]) -> None:
        """Call job(0), ..., job(size - 1), one on each thread; raise what any of them raises."""
        for k, inbox in enumerate(self.inboxes, start=1):
            inbox.put((job, k))
        failures = [attempt(job, 0)] + [self.outbox.get() for _ in self.inboxes]
        for failure in failures:
            if failure is not None:
                raise failure


def attempt(job: Callable[[int], None], k: int) -> BaseException | None:
    """Do share k of a job; what it raised, if anything."""
    try:
        job(k)
    except BaseException as failure:
        return failure
    return None


def run_helper(inbox: SimpleQueue, outbox: SimpleQueue) -> None:
    """The loop of a helper thread: shares of jobs until None comes."""
    while (task := inbox.get()) is not None:
        outbox.put(attempt(*task))
        task = None


def dismiss(inboxes: list[SimpleQueue]) -> None:
    """End the helper threads."""
    for inbox in inboxes:
        inbox.put(None)
