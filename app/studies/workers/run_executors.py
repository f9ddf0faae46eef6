"""What makes runs: threads or processes of this machine, or a cluster, all alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Protocol, Self

from app.studies.runs.database import Outcome

LOOK = 1.0
"""Seconds between two looks at the clock, beyond which the machine was asleep."""


@dataclass(frozen=True)
class Task:
    """A run to make."""

    cell: int
    seed: int
    payload: Any
    """What the job needs to know of it; it is pickled."""
    tries: int = 0
    """Processes that it has killed."""


type Keep = Callable[[Task, Outcome], None]
type Beat = Callable[[], bool]


class RunExecutor(Protocol):
    """A context manager that makes the runs of one job, wherever; leaving it ends what it began.

    The job has `prepare()`, and `run(payload, seed)` that returns an Outcome.
    """

    @property
    def workers(self) -> int:
        """How many runs it makes at a time."""

    def __enter__(self) -> Self:
        """Begin what makes runs."""

    def __exit__(self, *_: object) -> None:
        """End it at once."""

    def run(self, tasks: Iterable[Task], keep: Keep, beat: Beat) -> bool:
        """Make the runs, begun in their order; False if `beat` wanted them stopped.

        `keep` receives each in the calling thread, and so once. Raises InputError if none can be
        made.
        """


class AwakeClock:
    """A clock that stands still while nobody looks, as when the machine sleeps or is halted."""

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self.now = now
        self.last = now()
        self.seconds = 0.0

    def read(self) -> float:
        """Seconds since it was made in which it was looked at."""
        now = self.now()
        self.seconds += min(max(now - self.last, 0.0), LOOK)
        self.last = now
        return self.seconds
