"""What a process that makes runs does: it makes them in order, and reports how each ended."""

from __future__ import annotations

import mmap
import pickle
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.studies.runs.database import Outcome, failure

REPORTS = 0.05
"""Seconds for which what is done is held back, so that many short runs make one report."""
BEATS = 1.0
"""Seconds between two signs of life."""


STOPPED = threading.local()
"""`event` of a thread that makes runs beside others of this process: set once they are not wanted
any more."""


class RunStoppedError(BaseException):
    """A run on a thread is not wanted any more."""


def stop_if_unwanted() -> None:
    """Called now and then within a run: raises RunStoppedError where nobody waits for it."""
    event = getattr(STOPPED, "event", None)
    if event is not None and event.is_set():
        raise RunStoppedError


@dataclass(frozen=True)
class WorkerSetup:
    """What a process is told first."""

    job: bytes
    """The pickled job."""
    nice: int
    files: tuple[str, ...]
    """Files of rules, which the process is to know before it unpickles the job."""

    @classmethod
    def of(cls, job: Any, nice: int) -> WorkerSetup:
        """What all processes of a job are told."""
        from agents.catalogue import FILES

        return cls(pickle.dumps(job, -1), nice, tuple(map(str, FILES.values())))


class RunWorker:
    """Makes the runs of a job.

    `place`: the file, a page long, in which it keeps how many runs it has begun and its signs of
    life. The parent reads them in memory, even those of a process that was killed in between; a
    message for each run would cost more than a short run does.
    """

    def __init__(self, setup: WorkerSetup, place: str):
        with open(place, "r+b") as file:
            self.progress = mmap.mmap(file.fileno(), mmap.PAGESIZE)
        threading.Thread(target=self.count_beats, daemon=True).start()
        with suppress(OSError):  # where a file in use cannot be removed it stays
            Path(place).unlink()
        from agents.catalogue import from_file

        for path in setup.files:
            from_file(path)
        self.job = pickle.loads(setup.job)
        self.job.prepare()
        self.count = 0

    def make(self, runs: Sequence[tuple[Any, int]]) -> Iterator[list[Outcome]]:
        """Make runs, each a payload and a seed; how they ended, some at a time."""
        done: list[Outcome] = []
        reported = time.monotonic()
        for payload, seed in runs:
            self.count += 1
            self.progress[:8] = self.count.to_bytes(8, "little")
            done.append(make_run(self.job, payload, seed))
            if time.monotonic() - reported >= REPORTS:
                yield done
                done, reported = [], time.monotonic()
        if done:
            yield done

    def count_beats(self) -> None:
        """On a thread of its own: count in the second eight bytes while the process is not halted.

        However long a run takes: kernels and the interpreter let this thread have its turn.
        """
        beats = 0
        while True:
            beats += 1
            self.progress[8:16] = beats.to_bytes(8, "little")
            time.sleep(BEATS)


def make_run(job: Any, payload: Any, seed: int) -> Outcome:
    """A run; one that raises has failed."""
    began = time.perf_counter()
    try:
        outcome: Outcome = job.run(payload, seed)
    except Exception as error:
        outcome = failure(error)
    return outcome._replace(seconds=time.perf_counter() - began)
