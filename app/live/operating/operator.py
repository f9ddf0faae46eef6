"""The operator's end of a control loop, which runs in a process of its own.

Whatever happens to the operator's process, be it busy, stopped or killed, the loop is not held up:
it notices that the operator is gone, stops the cars and ends. The operator never waits for it.
"""

from __future__ import annotations

import atexit
import itertools
import math
import multiprocessing
import threading
import time
from contextlib import suppress
from pathlib import Path

from app.live.control.arm import UNDOING, OperatorRequest
from app.live.control.loop_status import Events, Status
from app.live.laboratory.lab_file import Lab
from app.live.operating.loop_process import LoopReply, NumberedRequest, Opener, serve
from app.live.operating.recorder import RecordRequest
from worlds.input_error import InputError

TIMEOUT = 180.0
"""Seconds that the process may take to begin: the first time a rule is compiled."""
GRACE = 30.0
"""Seconds that it has to finish its recording, once the cars are stopped, before it is ended."""
AGAIN = 1.0
"""Seconds in which an emergency stop is not sent again, if nobody has asked to undo it."""


class Operator:
    """Starts the control loop of a laboratory and sends it requests; any thread may use it.

    `opener` opens source, link and driver in the new process: a function of a module, which can be
    pickled. With `recording`, a folder, all is recorded there. Raises InputError if the loop cannot
    begin.
    """

    def __init__(self, lab: Lab, opener: Opener, recording: Path | None = None):
        spawn = multiprocessing.get_context("spawn")
        self.recording = recording
        self.line, child_end = spawn.Pipe(duplex=True)
        stops, self.stops = spawn.Pipe(duplex=False)
        """The emergency stop's own way, on which nothing else ever waits."""
        # A pipe mixes what two threads write at once, and the page and the terminal both ask. Who
        # needs both locks takes `lock` first: `close` alone does.
        self.lock = threading.Lock()
        self.stopping = threading.Lock()
        """Of the emergency stop's way alone: a stop never waits for a status or a request."""
        self.stopped: float | None = None
        """When the stop was sent that nobody has asked to undo, s."""
        self.numbers = itertools.count(1)
        self.events = Events()
        self.known = 0
        self.trouble = ""
        """Why the loop ended, if it did by itself."""
        self.newest: Status | None = None
        self.hand: tuple[float, float] | None = None
        self.closed = False
        self.waits = False
        """Whether the status was asked for and has not come."""
        # not a daemon: the loop has a child of its own, its tracking
        self.process = spawn.Process(
            target=serve,
            args=(lab.to_toml(), opener, recording, child_end, stops),
            name="flockscope control loop",
        )
        self.process.start()
        child_end.close()
        stops.close()
        atexit.register(self.close)
        self.begin()

    def begin(self) -> None:
        """Wait until the loop runs. Raises InputError with what it says if it cannot."""
        try:
            if self.line.poll(TIMEOUT):
                answer: LoopReply = self.line.recv()
                self.trouble = answer.trouble
            else:
                self.trouble = f"the control loop did not begin within {TIMEOUT:g} s"
        except (EOFError, OSError):
            self.trouble = "the control loop ended before it began"
        if self.trouble:
            self.close()
            raise InputError(self.trouble)

    @property
    def alive(self) -> bool:
        """Whether the loop runs."""
        return self.process.is_alive()

    def ask(self, request: OperatorRequest) -> None:
        """Ask for something, which is done at the loop's next tick; events say what came of it.

        An emergency stop waits for nothing that was asked before, and of many only one is sent.
        """
        if request.action == "emergency":
            self.stop(request)
            return
        if request.action in UNDOING:
            self.stopped = None  # before its number is taken: a stop from now on is a new one
        numbered = NumberedRequest(next(self.numbers), request)
        with self.lock, suppress(OSError):
            self.line.send(numbered)

    def stop(self, request: OperatorRequest) -> None:
        """Send an emergency stop, unless one has just been sent that nobody has asked to undo."""
        with self.stopping, suppress(OSError):
            now = time.monotonic()
            if self.stopped is None or now - self.stopped >= AGAIN:
                self.stopped = now
                self.stops.send(NumberedRequest(next(self.numbers), request))

    def record(self, folder: Path | None, cause: str) -> None:
        """Record in a new folder from now on, or with None no more; events say what came of it."""
        with self.lock, suppress(OSError):
            self.line.send(RecordRequest(folder, cause))

    def place(self, x: float, y: float) -> None:
        """Move the injected car of the hand, m, with the next call of `status`. Raises
        InputError."""
        if not (math.isfinite(x) and math.isfinite(y)):
            raise InputError(f"the injected car cannot be at ({x}, {y})")
        self.hand = (x, y)

    def status(self) -> Status | None:
        """The newest status of the loop, which the last call has asked for; None before the first.

        It is asked for one at a time, so that a slow operator never has many that wait.
        """
        with self.lock:
            try:
                while self.line.poll():
                    answer: LoopReply = self.line.recv()
                    self.waits = False
                    self.newest = answer.status or self.newest
                    self.events.add(*answer.events)
                    self.known = answer.known
                if not self.waits:
                    hand, self.hand = self.hand, None
                    self.line.send((self.known, hand))
                    self.waits = True
            except (EOFError, OSError):
                if not self.closed:
                    self.trouble = "the control loop is gone: the cars stop themselves"
                    if self.recording is not None:
                        self.trouble += f"; flockscope live recover {self.recording}"
            return self.newest

    def close(self) -> None:
        """Stop the cars and end the loop; it is killed if it does not end by itself."""
        atexit.unregister(self.close)
        with self.lock, suppress(OSError):
            self.closed = True
            self.line.send(None)
        for end in (lambda: None, self.process.terminate, self.process.kill):
            if self.process.is_alive():
                end()
                self.process.join(GRACE)
        with self.lock, self.stopping:
            self.line.close()
            self.stops.close()
