"""The processes of a class from outside, for its event loop."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from app.classroom.workers import laboratory_worker
from app.process_worker import ProcessLimits
from app.processes import ChildProcess

PRELOAD = (
    laboratory_worker.__name__,
    f"{__package__}.measuring",
    f"{__package__}.page_worker",
    "matplotlib.backends.backend_svg",  # draws the equations of a model's guide
)
"""What all of them import, once for all where the system can fork."""
TIMEOUT = 20.0
"""Seconds that a laboratory may take for one request."""
TASK = 180.0
"""Seconds that a task may take: the first run of a model is compiled, on a busy machine."""


class WorkerProcess(ChildProcess):
    """A process of a class. `ended` is called with it, on the event loop that it is made on.

    With `restarts` it does tasks, whose end costs nobody but the task that it was at; without, it
    holds laboratories, and one that is late is left to those who look into the others.
    """

    def __init__(
        self,
        worker: Callable[..., Any],
        *arguments: Any,
        niceness: int = 0,
        restarts: bool = False,
        ended: Callable[[WorkerProcess], None] | None = None,
    ):
        super().__init__(
            worker,
            *arguments,
            limits=ProcessLimits(niceness=niceness),
            restarts=restarts,
            ended=None if ended is None else self.tell_loop(ended),
            preload=PRELOAD,
        )
        self.timeout = TASK if restarts else TIMEOUT
        self.held = 0
        """Laboratories that it has or is about to have."""

    def tell_loop(self, ended: Callable[[WorkerProcess], None]) -> Callable[[], None]:
        """Has the event loop call `ended`, unless the process was closed."""
        loop = asyncio.get_running_loop()

        def tell() -> None:
            if not self._is_closed:
                with suppress(RuntimeError):  # the loop is closed
                    loop.call_soon_threadsafe(ended, self)

        return tell

    async def do(
        self, name: str, *arguments: Any, timeout: float | None = None, rank: float = 0.0
    ) -> Any:
        """What the worker's method returns, as by `ask`, and raises.

        Whoever waits no more leaves it to its end: the process may be at it.
        """
        timeout = self.timeout if timeout is None else timeout
        reply = asyncio.wrap_future(self.ask(name, *arguments, timeout=timeout, rank=rank))
        # Else asyncio complains of an error where nobody waits any more.
        reply.add_done_callback(lambda done: done.cancelled() or done.exception())
        return await asyncio.shield(reply)

    async def close(self) -> None:
        """End it for good."""
        await asyncio.to_thread(self.end)
