"""On a worker of Dask: the runs of a chunk are made in a process that stays beside the worker.

So a run that kills its process does no harm to the worker, and one that holds the interpreter does
not keep the worker from telling that it lives.
"""

from __future__ import annotations

import hashlib
import pickle
import platform
import threading
from collections.abc import Mapping
from typing import Any

from distributed import Reschedule, Scheduler, Worker, get_worker
from distributed.core import Status

from agents.spec import versions
from app.studies.runs.run_outcome import Outcome
from app.studies.workers.processes import Processes
from app.studies.workers.run_executors import Task
from worlds.input_error import InputError

TIMEOUT = 30.0
"""Seconds after which a process that is asked for nothing ends."""
IDLE: dict[str, list[Processes]] = {}
"""Processes that wait for the next chunk, by the job that they are for."""
LOCK = threading.Lock()


class SweepScheduler(Scheduler):
    """A scheduler that listens by TLS only.

    Dask's own also serves pages and numbers by plain HTTP to whoever asks, dashboard or not.
    """

    def start_http_server(self, *_: Any, **__: Any) -> None:
        """Open no server."""


class SweepWorker(Worker):
    """A worker that listens by TLS only, as its scheduler does."""

    def start_http_server(self, *_: Any, **__: Any) -> None:
        """Open no server."""


def make(beginning: bytes, chunk: bytes, limit: float | None, like: dict[str, str]) -> bytes:
    """Make the runs of a chunk: payloads and seeds in, how each ended out, all pickled.

    Raises InputError where no run can be made, or versions are not `like` those of the parent.
    """
    demand_like(like)
    worker = get_worker()
    asked = worker.get_current_task()
    job = hashlib.sha256(beginning).hexdigest()
    tasks = [Task(place, seed, one) for place, (one, seed) in enumerate(pickle.loads(chunk))]
    found: dict[int, Outcome] = {}

    def keep(task: Task, outcome: Outcome) -> None:
        found[task.cell] = outcome

    processes = taken(job, beginning, limit)
    whole = False
    try:
        whole = processes.run(tasks, keep, lambda: is_unwanted(worker, asked))
    except InputError as refusal:
        raise InputError(f"{refusal} (a worker on {platform.node()})") from None
    finally:
        if not whole:
            processes.__exit__()
    if not whole:
        raise Reschedule  # whoever still waits for it has it made elsewhere
    with LOCK:
        IDLE.setdefault(job, []).append(processes)
    return pickle.dumps([found[place] for place in sorted(found)], -1)


def demand_like(like: Mapping[str, str]) -> None:
    """Refuse to make runs that might give other numbers. Raises InputError."""
    own = versions()
    unlike = [f"{name} {own.get(name)}, not {one}" for name, one in like.items()
              if own.get(name) != one]  # fmt: skip
    if unlike:
        raise InputError(
            f"a worker on {platform.node()} has {', '.join(unlike)} as here: its runs might differ"
        )


def is_unwanted(worker: Worker, chunk: Any) -> bool:
    """Whether nobody waits for a chunk any more, or the worker is about to end."""
    task = worker.state.tasks.get(chunk)
    ending = worker.status not in (Status.running, Status.paused)
    return ending or task is None or task.state == "cancelled"


def taken(job: str, beginning: bytes, limit: float | None) -> Processes:
    """A process that waits for work of this job, or a new one; those of other jobs are let go."""
    with LOCK:
        for other in IDLE.keys() - {job}:
            for processes in IDLE.pop(other):
                processes.__exit__()
        if IDLE.get(job):
            return IDLE[job].pop()
    return Processes(pickle.loads(beginning), 1, limit=limit, timeout=TIMEOUT)
