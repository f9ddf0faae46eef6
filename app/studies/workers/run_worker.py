"""A process that makes runs: what it is sent it runs, in order, and reports how each ended."""

from __future__ import annotations

import mmap
import os
import pickle
import queue
import signal
import sys
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.studies.runs.database import Outcome, failure

REPORTS = 0.05
"""Seconds for which what is done is held back, so that many short runs make one report."""
BEATS = 1.0
"""Seconds between two signs of life."""
PATIENT = 0
"""The code with which a process ends that is asked for nothing."""


@dataclass(frozen=True)
class WorkerSetup:
    """What a process is told first."""

    job: bytes
    """The pickled job."""
    nice: int
    files: tuple[str, ...]
    """Files of rules, which the process is to know too."""
    place: str = ""
    """The file in which it keeps how many runs it has begun, and its signs of life."""
    timeout: float | None = None
    """Seconds after which it ends if it is asked for nothing; None: never."""

    @classmethod
    def of(cls, job: Any, nice: int) -> WorkerSetup:
        """What all processes of a job are told."""
        from agents.catalogue import FILES

        return cls(pickle.dumps(job, -1), nice, tuple(map(str, FILES.values())))


def serve() -> None:
    """The process: read the job, then runs until there is nobody to send them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is meant for the one that began it
    reports = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever a rule or a measure prints is no report
    beginning: WorkerSetup = pickle.load(sys.stdin.buffer)
    asked: queue.SimpleQueue[list[tuple[Any, int]]] = queue.SimpleQueue()
    threading.Thread(target=listen, args=(asked,), daemon=True).start()
    if beginning.nice and hasattr(os, "nice"):
        os.nice(beginning.nice)
    with open(beginning.place, "r+b") as file:
        begun = mmap.mmap(file.fileno(), mmap.PAGESIZE)
    threading.Thread(target=show_life, args=(begun,), daemon=True).start()
    with suppress(OSError):  # where a file in use cannot be removed it stays, a page long
        Path(beginning.place).unlink()
    job = prepared(beginning)
    count = 0
    while True:
        done: list[Outcome] = []
        told = time.monotonic()
        for payload, seed in next_of(asked, beginning.timeout):
            count += 1
            begun[:8] = count.to_bytes(8, "little")
            done.append(made(job, payload, seed))
            if time.monotonic() - told >= REPORTS:
                report(reports, done)
                done, told = [], time.monotonic()
        if done:
            report(reports, done)


def show_life(place: mmap.mmap) -> None:
    """On a thread of its own: count in the second eight bytes while the process is not halted.

    However long a run takes: kernels and the interpreter let this thread have its turn.
    """
    beats = 0
    while True:
        beats += 1
        place[8:16] = beats.to_bytes(8, "little")
        time.sleep(BEATS)


def next_of(
    asked: queue.SimpleQueue[list[tuple[Any, int]]], timeout: float | None
) -> list[tuple[Any, int]]:
    """The runs that are asked for next; the process ends if there are none for too long."""
    try:
        return asked.get(timeout=timeout)
    except queue.Empty:
        os._exit(PATIENT)


def prepared(beginning: WorkerSetup) -> Any:
    """The job, ready to make runs; the process ends with a line if that cannot be."""
    try:
        from agents.catalogue import from_file

        for one in beginning.files:
            from_file(one)
        job = pickle.loads(beginning.job)
        job.prepare()
    except BaseException as error:
        words = " ".join(f"{type(error).__name__}: {error}".split())
        print(f"flockscope: a process cannot begin ({words})", file=sys.stderr, flush=True)
        os._exit(1)  # in the usual farewell the thread that listens would be in the way
    return job


def made(job: Any, payload: Any, seed: int) -> Outcome:
    """A run; one that raises has failed."""
    began = time.perf_counter()
    try:
        outcome: Outcome = job.run(payload, seed)
    except Exception as error:
        outcome = failure(error)
    return outcome._replace(seconds=time.perf_counter() - began)


def report(reports: Any, done: list[Outcome]) -> None:
    """Report how runs ended."""
    pickle.dump(done, reports, -1)
    reports.flush()


def listen(asked: queue.SimpleQueue[list[tuple[Any, int]]]) -> None:
    """On a thread of its own: take what is sent, and end the process when its parent is gone."""
    with suppress(EOFError, OSError, pickle.UnpicklingError):
        while True:
            asked.put(pickle.load(sys.stdin.buffer))
    os._exit(1)
