"""Child processes: the one way to start, ask, time out, cancel, end and restart them.

    child = ChildProcess(Adder)  # a class of a module, not of a script
    child.ask("add", 1, 2, timeout=10.0).result()  # Adder().add(1, 2), in a process of its own
    child.end()

The worker lives in the child and has its methods called, in order and one at a time. `ask` never
waits: it returns a future of `concurrent.futures`, which threads wait for with `result()` and event
loops with `asyncio.wrap_future`.

No pool of a library does this. These workers either have a state that belongs to one process, as
laboratories and prepared jobs, or read what strangers wrote, whose replies must not be unpickled.
`concurrent.futures` and loky have no limit for the time of one task, and give the whole pool up if
one process dies. pebble has such a limit, by the clock on the wall, but neither asks one process by
name, nor has replies in parts or limits of memory; and it runs a user's script again in each child.
"""

from __future__ import annotations

import heapq
import itertools
import math
import pickle
import signal
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Self

from app.process_worker import MessageKind, ProcessLimits, one_line, read_message, write_message
from app.running_process import GRACE, RunningProcess
from worlds.input_error import InputError
from worlds.number_text import signal_name


class ProcessLostError(Exception):
    """The child has ended before it has replied, or does not reply; one line says how."""


class ProcessTimeoutError(ProcessLostError):
    """The request has taken longer than it may."""


class ChildError(RuntimeError):
    """Something in the child raised; one line: the kind of the error and its text."""


@dataclass(order=True)
class Request:
    """A method that the worker is asked to call; the least rank is next, of one rank the oldest."""

    rank: float
    number: int
    content: bytes = field(compare=False)
    """Pickled: the method's name and its arguments."""
    timeout: float = field(compare=False)
    receive: Callable[[Any], None] | None = field(compare=False)
    asked: float = field(compare=False, default_factory=time.monotonic)
    future: Future[Any] = field(compare=False, default_factory=Future)

    def fail(self, error: BaseException) -> None:
        """Tell whoever waits, unless nobody does or the reply has come in this very moment."""
        with suppress(InvalidStateError):
            if not self.future.cancelled():
                self.future.set_exception(error)


class ChildProcess:
    """A worker in a process of its own, which starts with `start` or with the first request.

    `worker(*arguments)` is made there: a class of a module, and arguments that can be pickled.
    `restarts`: a request that takes too long has its process killed, and after every death the next
    request has a new process; requests that wait are not lost. Without it a late request fails and
    its process goes on, as it may hold what belongs to others, and the end of that is final.
    `is_trusted`: False for a child that reads what strangers wrote. Its methods return bytes, and
    none of its replies is unpickled: whoever takes it over could run code here by them.
    `ended` is called on a thread each time that a process is gone. `preload`: modules for a start
    by fork; without them the process has an `environment` and a `stderr`, as of subprocess.

    Two threads attend it: one sends and watches the time, the other takes replies. The process ends
    when its parent is gone, however that ended, as the system then closes the streams.
    """

    def __init__(
        self,
        worker: Callable[..., Any],
        *arguments: Any,
        limits: ProcessLimits | None = None,
        restarts: bool = False,
        is_trusted: bool = True,
        ended: Callable[[], None] | None = None,
        preload: Sequence[str] = (),
        environment: Mapping[str, str] | None = None,
        stderr: int | None = None,
    ) -> None:
        self.limits = limits or ProcessLimits()
        self.restarts, self.is_trusted, self.ended = restarts, is_trusted, ended
        self.worker = worker
        self.setup = pickle.dumps((worker, arguments), -1)
        self.first: tuple[Any, ...] = ()
        """What each new process does before its first request: a method's name and arguments. What
        it refuses is ignored, as the requests that need it are refused too."""
        self.begin = partial(RunningProcess, preload, environment or {}, stderr)
        self.exit_code: int | None = None
        """Of the process that ended last; negative: the signal that ended it."""
        self.reason = ""
        """Why that process could not begin, in one line."""
        self._changed = threading.Condition()
        """Guards what follows. No future is done and no callback called while it is held."""
        self._numbers = itertools.count()
        self._queue: list[Request] = []
        self._working: Request | None = None
        self._running: RunningProcess | None = None
        self._is_wanted = self._is_starting = self._is_closed = self._is_lost = False
        self._attendant: threading.Thread | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end(0.0)

    @property
    def is_gone(self) -> bool:
        """Whether no request is answered any more."""
        return self._is_closed or self._is_lost

    @property
    def pid(self) -> int | None:
        """The number of the process that runs now."""
        running = self._running
        return None if running is None else running.process.pid

    def start(self) -> Self:
        """Have the process started now; this does not wait for it."""
        with self._changed:
            self._is_wanted = True
            self._wake_attendant()
        return self

    def ask(
        self,
        name: str,
        *arguments: Any,
        timeout: float = math.inf,
        rank: float = 0.0,
        receive: Callable[[Any], None] | None = None,
    ) -> Future[Any]:
        """Have the worker's method called; the future of what it returns.

        `timeout`: seconds from when the child turns to this request: neither its own start nor what
        it does before is counted. `receive` is called, on a thread, with each value of a method
        that yields. The future raises what the method refuses (InputError), ChildError for other
        errors, and ProcessLostError. To cancel it takes the request back, unless the child is at
        it: that ends with its process only. Raises AttributeError at once for a method that the
        worker's class does not have.
        """
        if isinstance(self.worker, type):
            getattr(self.worker, name)
        content = pickle.dumps((name, arguments), -1)
        request = Request(rank, next(self._numbers), content, timeout, receive)
        with self._changed:
            if not self.is_gone:
                heapq.heappush(self._queue, request)
                self._wake_attendant()
                return request.future
        request.fail(self._lost_error())
        return request.future

    def kill(self) -> None:
        """End the process at once; with `restarts`, the next request has another."""
        with self._changed:
            if self._running is not None:
                self._running.process.kill()

    def end(self, within: float | None = GRACE) -> None:
        """End the process for good, and wait for that.

        `within`: seconds that it has for what it is at, while what waits is lost; None: it does all
        that it was asked for.
        """
        with self._changed:
            if within is None:
                self._changed.wait_for(lambda: self.is_gone or not (self._working or self._queue))
            self._is_closed = True
            waiting, self._queue = self._queue, []
            self._changed.notify_all()
        for request in waiting:
            request.fail(self._lost_error())
        with self._changed:
            if not self._changed.wait_for(self._has_ended, within):
                self.kill()
                self._changed.wait_for(self._has_ended)

    def _has_ended(self) -> bool:
        return self._running is None and not self._is_starting

    def _lost_error(self) -> ProcessLostError:
        """What to say of its end."""
        late = [getattr(signal, name, None) for name in ("SIGPROF", "SIGXCPU")]
        if self._is_closed:
            return ProcessLostError("the process was ended")
        if self.exit_code is not None and -self.exit_code in late:
            return ProcessTimeoutError("the process took more processor time than it may")
        if self.reason:
            return ProcessLostError(f"the process cannot begin: {self.reason}")
        return ProcessLostError(f"the process ended with {describe_exit(self.exit_code or 0)}")

    # The thread that sends and watches the time. While it writes it watches no time: a child reads
    # at once, as that is all that one of its threads does; one that is halted is for `kill`.

    def _wake_attendant(self) -> None:
        if self._attendant is None:  # none for who is never asked
            self._attendant = threading.Thread(target=self._attend, name="requests", daemon=True)
            self._attendant.start()
        self._changed.notify_all()

    def _attend(self) -> None:
        while True:
            request = None
            with self._changed:
                late = self._take_late()
                while not (late or self.is_gone or self._has_work()):
                    self._changed.wait(self._seconds_left())
                    late = self._take_late()
                closing, running = self.is_gone, self._running
                if not late and not closing:
                    if self._queue:
                        request = heapq.heappop(self._queue)
                        self._changed.notify_all()
                        if not request.future.set_running_or_notify_cancel():
                            continue  # it was taken back
                        self._working = request
                    self._is_starting = running is None
            for late_request, error in late:
                late_request.fail(error)
            if late:
                continue
            if running is None and not closing:
                running = self._start()
            with suppress(OSError, ValueError):  # it is gone, which the other thread notices
                if closing and running is not None:
                    write_message(running.requests, MessageKind.END)
                elif running is not None and request is not None:
                    write_message(running.requests, MessageKind.REQUEST, request.content)
            if closing:
                return

    def _has_work(self) -> bool:
        is_wanted = self._is_wanted and self._running is None
        return self._working is None and (bool(self._queue) or is_wanted)

    def _start(self) -> RunningProcess | None:
        """Start a process; None if that cannot be."""
        try:
            head = pickle.dumps((self.limits, self.is_trusted, self.setup, self.first), -1)
            running = self.begin()
        except Exception as error:
            self._lose(one_line(error))
            return None
        with self._changed:
            self._is_wanted = self._is_starting = False
            self._running = running
            if self._is_closed:
                self.kill()
        threading.Thread(target=self._listen, args=(running,), name="replies", daemon=True).start()
        with suppress(OSError, ValueError):
            write_message(running.requests, MessageKind.REQUEST, head)
        return running

    def _deadline(self, request: Request) -> float:
        """When a request is late, by the monotonic clock, s."""
        running = self._running
        if running is None:
            return math.inf
        if not running.is_ready:
            return running.turned + self.limits.start
        return max(running.turned, request.asked) + request.timeout

    def _timed(self) -> list[Request]:
        """The requests whose time runs. Where others are waited for without end, as their process
        is not killed, that of those who wait does too; else theirs begins with their turn."""
        waiting = [] if self.restarts else self._queue
        return [
            request
            for request in (self._working, *waiting)
            if request and not request.future.done()
        ]

    def _seconds_left(self) -> float | None:
        first = min(map(self._deadline, self._timed()), default=math.inf)
        # Threads wait for so many years at most.
        return None if first == math.inf else min(max(0.0, first - time.monotonic()), 1e6)

    def _take_late(self) -> list[tuple[Request, ProcessTimeoutError]]:
        """Take out the requests that are late; a process that is replaced is killed."""
        now = time.monotonic()
        late = [request for request in self._timed() if self._deadline(request) <= now]
        if not late:
            return []
        self._queue = [request for request in self._queue if request not in late]
        heapq.heapify(self._queue)
        if self.restarts:
            self.kill()
        if self._running is not None and not self._running.is_ready:
            message = f"the process has not begun within {self.limits.start:g} s"
            return [(request, ProcessTimeoutError(message)) for request in late]
        return [
            (request, ProcessTimeoutError(f"it took longer than {request.timeout:g} s"))
            for request in late
        ]

    # The thread that takes replies, and notices the end.

    def _listen(self, running: RunningProcess) -> None:
        try:
            while True:
                self._take(running, *read_message(running.replies, self.limits.memory))
        except (EOFError, OSError, ValueError, MemoryError):
            pass
        finally:
            code = running.wait()
            running.close()
            self._lose(running.reason, code)

    def _take(self, running: RunningProcess, kind: int, data: bytes) -> None:
        """Take a message of the child's."""
        if kind == MessageKind.FAULT and not running.is_ready:
            running.reason = data.decode(errors="replace")
            return
        with self._changed:
            working = self._working
            if kind != MessageKind.PART:
                running.turned, running.is_ready = time.monotonic(), True
                self._working = working if kind == MessageKind.READY else None
            self._changed.notify_all()
        if working is None or kind == MessageKind.READY:
            return
        value = self._content(kind, data)
        if kind == MessageKind.PART:
            if working.receive is not None:
                working.receive(value)
        elif isinstance(value, ChildError) or kind == MessageKind.REFUSAL:
            working.fail(value)
        else:
            with suppress(InvalidStateError):  # it was late
                working.future.set_result(value)

    def _content(self, kind: int, data: bytes) -> Any:
        """What a message holds: a value, or an error."""
        if kind == MessageKind.FAULT:
            return ChildError(data.decode(errors="replace"))
        if not self.is_trusted:
            return (
                InputError(data.decode(errors="replace")) if kind == MessageKind.REFUSAL else data
            )
        try:
            return pickle.loads(data)
        except Exception as error:
            return ChildError(f"its reply cannot be read: {one_line(error)}")

    def _lose(self, reason: str, code: int | None = None) -> None:
        """Note that the process is gone, or could not be started."""
        with self._changed:
            self.exit_code, self.reason = code, reason
            self._running, self._is_starting, self._is_wanted = None, False, False
            lost = [] if self._working is None else [self._working]
            self._working = None
            if not self.restarts:
                lost, self._queue, self._is_lost = [*lost, *self._queue], [], True
            self._changed.notify_all()
        for request in lost:
            request.fail(self._lost_error())
        if self.ended is not None:
            self.ended()


def describe_exit(code: int) -> str:
    """How a process ended, for people.

    >>> describe_exit(-9), describe_exit(-40), describe_exit(1)
    ('signal SIGKILL', 'signal 40', 'code 1')
    """
    return f"code {code}" if code >= 0 else f"signal {signal_name(-code)}"
