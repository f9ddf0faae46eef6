"""A process that does one task at a time, whose end costs nobody but the task that it was at."""

from __future__ import annotations

import asyncio
import heapq
import itertools
import signal
from collections.abc import Callable, Coroutine
from typing import Any

from app.classroom.workers.process import WorkerLostError, WorkerProcess

TASK = 180.0
"""Seconds that a task may take by the clock, from its start: the first run of a model is compiled,
on a busy machine."""


class TimeUp(WorkerLostError):
    """The process was ended because its task took too long."""


class TaskProcess:
    """Begun when there is a task, and again after it has ended; for one event loop.

    Tasks wait here and not in the process: so the time of each is counted from its own start, and
    one that is ended takes no other with it.
    """

    def __init__(self, kind: Callable[..., Any], *given: Any):
        self.what = kind, *given
        self.first: tuple[Any, ...] = ()
        """What every new process does before its first task: name and arguments."""
        self.worker: WorkerProcess | None = None
        self.numbers = itertools.count()
        self.waiting: list[tuple[float, int, asyncio.Future[None]]] = []
        self.busy = False
        self.tasks: set[asyncio.Task[Any]] = set()

    async def do(self, name: str, *given: Any, timeout: float = TASK, rank: float = 0.0) -> Any:
        """What the process answers. Raises Gone if it ended, TimeUp if because of this task's time,
        and whatever it refuses.

        Of those who wait the least `rank` is next, and of one rank who came first. Whoever waits no
        more leaves the task to its end: the process is at it.
        """
        return await finish(self.tasks, self.in_turn(name, given, timeout, rank))

    async def in_turn(self, name: str, given: tuple[Any, ...], timeout: float, rank: float) -> Any:
        """Wait for the process, and have it do a task."""
        if self.busy:
            turn = asyncio.get_running_loop().create_future()
            heapq.heappush(self.waiting, (rank, next(self.numbers), turn))
            await turn
        self.busy = True
        try:
            worker = await self.ready()
            return await worker.ask(name, *given, timeout=timeout)
        except WorkerLostError:
            if await self.end():
                raise TimeUp from None
            raise
        finally:
            self.pass_turn()

    def pass_turn(self) -> None:
        """Let the next of those who wait have the process, if anybody waits."""
        while self.waiting:
            turn = heapq.heappop(self.waiting)[2]
            if not turn.done():  # as whoever is cancelled while all is closed
                turn.set_result(None)
                return
        self.busy = False

    async def ready(self) -> WorkerProcess:
        """The process, begun if need be. Raises Gone, and what its first task refuses."""
        if self.worker is None or self.worker.is_gone:
            self.worker = await WorkerProcess(lambda _: None, *self.what).begin()
            if self.first:
                await self.worker.ask(*self.first, timeout=TASK)
        return self.worker

    async def end(self) -> bool:
        """End the process, whatever it is at; whether its time was up, by the clock or its own."""
        worker, self.worker = self.worker, None
        if worker is None:
            return False
        if not worker.is_gone:
            worker.closing = True
            worker.process.kill()
            return True
        await asyncio.to_thread(worker.process.join, 2.0)
        return worker.process.exitcode == -getattr(signal, "SIGPROF", 0)

    async def close(self) -> None:
        """End it for good."""
        for task in self.tasks:
            task.cancel()
        worker, self.worker = self.worker, None
        if worker is not None:
            await worker.close()


async def finish[T](tasks: set[asyncio.Task[T]], work: Coroutine[Any, Any, T]) -> T:
    """What some work gives, which goes on to its end among `tasks` even if nobody waits for it."""
    task = asyncio.get_running_loop().create_task(work)
    tasks.add(task)

    def forget(done: asyncio.Task[T]) -> None:
        tasks.discard(done)
        if not done.cancelled():
            done.exception()  # else asyncio complains of it where nobody waits

    task.add_done_callback(forget)
    return await asyncio.shield(task)
