"""Runs on a cluster: chunks of them in small windows, taken and released as they come back.

A worker of Dask that is lost loses nothing: its chunks are made by others. A chunk of which two
workers have died is halved, and its halves are made alone, so that no other's death is laid to it:
at last the run that kills workers stands by itself, and is `killed`.
"""

from __future__ import annotations

import asyncio
import pickle
import queue
import time
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import wait
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from agents.spec import versions
from app.studies.cluster.cluster_connection import ClusterConnection, log_folder, open_cluster
from app.studies.cluster.cluster_options import Cluster
from app.studies.runs.database import Outcome
from app.studies.workers.process_executor import BEAT, FIRST_GUESS
from app.studies.workers.run_executors import Beat, Keep, Task
from app.studies.workers.run_worker import WorkerSetup
from worlds.input_error import InputError
from worlds.number_text import counted

if TYPE_CHECKING:
    from distributed import Future

WINDOW = 4
"""Chunks that wait at each worker, the one that it is at among them."""
CHUNK = 0.25
"""Seconds of work of a chunk, at least,"""
CHUNKS = 50.0
"""and so many that all workers together end not more chunks in a second."""
LARGEST = 1000
"""Runs of a chunk, at most."""
AGAIN = 30.0
"""Seconds between two looks whether jobs that have ended are to be replaced."""
ALONE = 60.0
"""Seconds without any worker after which it is said."""


@dataclass(frozen=True)
class Chunk:
    """Runs that are sent together."""

    tasks: tuple[Task, ...]
    suspect: bool = False
    """Whether workers have died of it, or of what it was part of."""

    @property
    def halves(self) -> list[Chunk]:
        """It in two parts; itself if it is one run."""
        middle = (len(self.tasks) + 1) // 2
        parts = self.tasks[:middle], self.tasks[middle:]
        return [Chunk(part, suspect=True) for part in parts if part]


class ClusterExecutor:
    """A context manager: a cluster that makes the runs of one job."""

    def __init__(
        self,
        job: Any,
        cluster: Cluster,
        workers: int,
        nice: int = 0,
        limit: float | None = None,
        tell: Callable[[str], Any] | None = None,
    ):
        self.beginning = pickle.dumps(WorkerSetup.of(job, nice), -1)
        self.cluster = cluster
        self.limit = limit
        self.tell = tell
        self.alone_since: float | None = time.monotonic()
        """Since when there has been no worker; None once that was told, too."""
        self.opening: AbstractContextManager[ClusterConnection] = open_cluster(cluster, workers)
        self.versions = versions()
        self.seconds = FIRST_GUESS
        """What a run takes, lately."""
        self.chunks: dict[Future, Chunk] = {}
        """What is sent and not yet back."""
        self.late: list[Future] = []
        """Chunks that were over, and whose results were lost with their workers."""
        self.suspects: deque[Chunk] = deque()
        self.events: queue.SimpleQueue[Future] = queue.SimpleQueue()
        self.slots = 0
        """Runs that the workers make at a time, as last seen."""

    def __enter__(self) -> ClusterExecutor:
        self.opened = self.opening.__enter__()
        self.client = self.opened.client
        return self

    def __exit__(self, *raised: Any) -> None:
        with suppress(Exception):
            self.client.cancel(list(self.chunks), force=True)
        self.chunks.clear()
        self.opening.__exit__(*(raised or (None, None, None)))

    @property
    def workers(self) -> int:
        """How many runs it makes at a time."""
        return self.slots

    def run(self, tasks: Iterable[Task], keep: Keep, beat: Beat = lambda: False) -> bool:
        """Make the runs, begun in their order; False if `beat` wanted them stopped.

        Raises InputError if the scheduler is gone, or a worker cannot make runs.
        """
        ahead = deque(tasks)
        beaten = looked = renewed = 0.0
        while ahead or self.chunks or self.suspects:
            now = time.monotonic()
            if now - looked >= 1.0:
                looked = now
                self.slots = self.count_slots()
                self.warn_without_workers(now)
            if now - renewed >= AGAIN:
                renewed = now
                self.opened.renew()
            self.submit_chunks(ahead)
            self.take_results(self.wait_for_chunks(), keep)
            if time.monotonic() - beaten >= BEAT:
                beaten = time.monotonic()
                if beat():
                    return False
        return True

    def count_slots(self) -> int:
        """How many runs the workers make at a time now. Raises InputError without a scheduler."""
        if self.client.status != "running":
            raise self.scheduler_lost_error()
        try:
            return sum(self.client.nthreads().values())
        except (OSError, TimeoutError):
            raise self.scheduler_lost_error() from None

    def warn_without_workers(self, now: float) -> None:
        """Say once that no worker comes, and what that may come from."""
        if self.slots or self.tell is None:
            self.alone_since = now
        elif self.alone_since is not None and now - self.alone_since >= ALONE:
            self.alone_since = None
            logs = (
                f"; logs of jobs are in {log_folder(self.cluster)}" if self.cluster.queued else ""
            )
            self.tell(
                "flockscope: no worker has come yet: jobs wait in the queue, or cannot reach this "
                f"machine{logs}"
            )

    def scheduler_lost_error(self) -> InputError:
        """What to say when there is no scheduler."""
        return InputError(
            f"the scheduler of Dask for --cluster {self.cluster.kind} is gone: finished runs are "
            "kept, and the same call goes on"
        )

    def submit_chunks(self, ahead: deque[Task]) -> None:
        """Keep a few chunks waiting at each worker, the order kept; suspects go alone."""
        if self.suspects:
            if not self.chunks:
                self.send(self.suspects.popleft())
            return
        slots = max(1, self.slots)
        target = max(CHUNK, slots / CHUNKS)
        while ahead and len(self.chunks) < WINDOW * slots:
            share = -(-len(ahead) // (2 * slots))
            some = max(1, min(int(target / self.seconds), share, LARGEST))
            self.send(Chunk(tuple(ahead.popleft() for _ in range(min(some, len(ahead))))))

    def send(self, chunk: Chunk) -> None:
        """Send a chunk to whichever worker is free."""
        from app.studies.cluster.cluster_connection import make

        payload = pickle.dumps([(task.payload, task.seed) for task in chunk.tasks], -1)
        more = self.beginning, payload, self.limit, self.versions
        future = self.client.submit(make, *more, pure=False, retries=0)
        self.chunks[future] = chunk
        future.add_done_callback(self.events.put)

    def wait_for_chunks(self) -> list[Future]:
        """The chunks that are over, waited for a moment."""
        futures: list[Future] = []
        with suppress(queue.Empty):
            futures.append(self.events.get(timeout=BEAT))
            while True:
                futures.append(self.events.get_nowait())
        return futures

    def take_results(self, futures: list[Future], keep: Keep) -> None:
        """Keep the runs of chunks that are over, release what Dask has of them; halve what killed.

        Raises InputError if a worker cannot make runs, or the scheduler is gone.
        """
        over = [future for future in (*self.late, *futures) if future in self.chunks]
        if any(future.status == "cancelled" for future in over):
            raise self.scheduler_lost_error()
        done = [future for future in over if future.status == "finished"]
        for future, result in self.fetch(done):
            chunk = self.chunks.pop(future)
            future.release()
            for task, outcome in zip(chunk.tasks, pickle.loads(result), strict=True):
                self.seconds += 0.1 * (max(outcome.seconds, 1e-5) - self.seconds)
                keep(task, outcome)
        for future in over:
            if future.status == "error":
                chunk = self.chunks.pop(future)
                self.handle_failure(chunk, future.exception(), keep)
                future.release()
        self.late = [future for future in over if future in self.chunks]

    def fetch(self, done: list[Future]) -> list[tuple[Future, bytes]]:
        """Chunks with their results; of none if one of these is there no more.

        One that was lost with its workers is made again, which is not waited for: that may need a
        job that is yet to be asked for. Raises InputError if the scheduler is gone.
        """
        if not done:
            return []
        loop: Any = self.client.loop
        gathering = asyncio.run_coroutine_threadsafe(
            self.client.gather(done, errors="skip", asynchronous=True), loop.asyncio_loop
        )
        while not wait([gathering], BEAT).done:
            if any(future.status != "finished" for future in done):
                gathering.cancel()
                return []
        try:
            results = gathering.result()
        except (OSError, TimeoutError):
            raise self.scheduler_lost_error() from None
        return list(zip(done, results, strict=True)) if len(results) == len(done) else []

    def handle_failure(self, chunk: Chunk, error: BaseException | None, keep: Keep) -> None:
        """Take a chunk that could not be made. Raises InputError unless workers died of it."""
        from distributed.scheduler import KilledWorker

        if not isinstance(error, KilledWorker):
            words = " ".join(f"{type(error).__name__}: {error}".split())
            raise (
                error
                if isinstance(error, InputError)
                else InputError(f"no run can be made: {words}")
            )
        if chunk.suspect and len(chunk.tasks) == 1:
            died = counted(error.allowed_failures + 1, "worker")
            keep(chunk.tasks[0], Outcome("killed", reason=f"{died} ended while it was made, alone"))
            return
        self.suspects.extendleft(reversed(chunk.halves))
