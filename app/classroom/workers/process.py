"""A worker process from outside: begun, asked, and noticed when it ends."""

from __future__ import annotations

import asyncio
import itertools
import multiprocessing
import pickle
import socket
from collections.abc import Callable
from typing import Any

from app.classroom.workers import laboratory_worker
from app.classroom.workers.laboratory_worker import LENGTH, packed

TIMEOUT = 20.0
"""Seconds that a worker has for one request, from when it turns to it."""


class WorkerLostError(Exception):
    """The process has ended, or does not answer."""


def context() -> Any:
    """How processes are begun: where it is possible as copies of one that has imported all."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    chosen = multiprocessing.get_context("forkserver")
    chosen.set_forkserver_preload([laboratory_worker.__name__, f"{__package__}.measuring"])
    return chosen


class WorkerProcess:
    """One worker; `ended` is called on the loop when its process is gone."""

    def __init__(
        self,
        ended: Callable[[WorkerProcess], None],
        kind: Callable[..., Any] = laboratory_worker.Laboratories,
        *given: Any,
    ):
        self.ended = ended
        self.what = kind, *given
        """What does the work in it."""
        self.numbers = itertools.count()
        self.waiting: dict[int, asyncio.Future[Any]] = {}
        self.begun = asyncio.Event()
        self.closing = False
        self.is_gone = False
        self.held = 0
        """Laboratories that it has or is about to have."""
        self.answered = 0.0
        """When the last answer came, by the loop's clock: the worker then turned to the next."""

    async def begin(self) -> WorkerProcess:
        """Begin the process."""
        ours, theirs = socket.socketpair()
        self.process = context().Process(
            target=laboratory_worker.serve,
            args=(theirs, *self.what),
            name="laboratories",
            daemon=True,
        )
        await asyncio.to_thread(self.process.start)
        theirs.close()
        self.reader, self.writer = await asyncio.open_connection(sock=ours)
        self.hearing = asyncio.create_task(self.hear())
        self.begun.set()
        return self

    async def hear(self) -> None:
        """Take answers, until the process ends."""
        try:
            while True:
                size = LENGTH.unpack(await self.reader.readexactly(LENGTH.size))[0]
                number, fine, answer = pickle.loads(await self.reader.readexactly(size))
                self.answered = asyncio.get_running_loop().time()
                future = self.waiting.pop(number, None)
                if future is None or future.done():
                    continue
                if fine:
                    future.set_result(answer)
                else:
                    future.set_exception(answer)
        except (asyncio.IncompleteReadError, OSError):
            pass
        self.is_gone = True
        waiting, self.waiting = self.waiting, {}
        for future in waiting.values():
            if not future.done():
                future.set_exception(WorkerLostError())
        if not self.closing:
            self.ended(self)

    async def ask(self, name: str, *given: Any, timeout: float = TIMEOUT) -> Any:
        """What the worker answers, once it has begun. Raises Gone, and whatever it refuses.

        `timeout`: seconds that it may take, from when it turns to this request: it answers in
        order, so the time that others take before is not counted.
        """
        if self.is_gone:
            raise WorkerLostError
        number = next(self.numbers)
        future = self.waiting[number] = asyncio.get_running_loop().create_future()
        try:
            async with asyncio.timeout(timeout):
                await self.begun.wait()
            # Not drained: a worker that is busy with others reads nothing, which counts for nobody.
            self.writer.write(packed((number, name, given)))
            return await self.answer_of(future, timeout)
        except (OSError, TimeoutError):
            raise WorkerLostError from None
        finally:
            self.waiting.pop(number, None)

    async def answer_of(self, future: asyncio.Future[Any], timeout: float) -> Any:
        """What comes within so many seconds of the answer to the request before. Raises Gone."""
        clock = asyncio.get_running_loop().time
        asked = clock()
        while not future.done():
            left = max(asked, self.answered) + timeout - clock()
            if left <= 0.0:
                raise WorkerLostError
            await asyncio.wait({future}, timeout=left)
        return future.result()

    async def close(self) -> None:
        """End the process."""
        self.closing = True
        if not self.begun.is_set():
            return
        self.writer.close()
        await asyncio.to_thread(self.process.join, 2.0)
        if self.process.is_alive():
            self.process.kill()
        await self.hearing
