"""A tracking source in a process of its own, read without ever waiting for it.

A thread takes what the child sends and keeps it; the control loop looks at what is kept. A source
that hangs, dies or falls silent therefore costs the loop nothing: its newest frame grows old, and
`trouble` says in one line what is known. One that dies is opened again, ever more rarely while it
goes on dying: a stranger's datagram may end a library, but not the tracking.
"""

from __future__ import annotations

import faulthandler
import math
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from typing import Literal

from app.live.control.pose import MocapFrame, Pose
from app.live.sources.pose_source import Source
from app.process_worker import ProcessLimits
from worlds.input_error import InputError
from worlds.number_text import signal_name

# The child process of a feed: runs a source, and leaves when it is told to or its parent is gone.
#
# What a source's library does in C cannot be interrupted from Python: it may block for ever, and
# even hold the interpreter. The way out is therefore always to end the process.

GRACE = 0.5
"""Seconds that a source has to end by itself once it is told to."""

BEAT = 1.0
"""Seconds between two signs of life, where the library leaves the interpreter free meanwhile."""

type Message = (
    tuple[Literal["begun", "connected", "ended", "alive"], None]
    | tuple[Literal["trouble"], str]
    | tuple[Literal["frame"], MocapFrame]
)


MEMORY = 4 * 2**30
"""Bytes that a source gets: a forged count in one datagram makes a library ask for as much as it
says, and the machine that drives the cars would stall."""


def serve(source: Source, line: Connection, timeout: float) -> None:
    """Send through `line` that the source is asked and connected, its frames, trouble and end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends us
    silence_output()
    ProcessLimits(memory=MEMORY).apply()
    stop = threading.Event()
    threading.Thread(target=_heed, args=(line, stop), daemon=True).start()
    to_parent = _ToParent(line)
    threading.Thread(target=_send_signs_of_life, args=(to_parent,), daemon=True).start()
    outcome = _outcome(source, stop, to_parent, timeout)
    with suppress(OSError):  # the parent is gone
        to_parent.send(outcome)


class _ToParent:
    """The way to the parent, for several threads."""

    def __init__(self, line: Connection) -> None:
        self.line = line
        self.lock = threading.Lock()

    def send(self, message: Message) -> None:
        """Send a message whole. Raises OSError if the parent is gone."""
        with self.lock:
            self.line.send(message)


def _send_signs_of_life(line: _ToParent) -> None:
    """Give signs of life. A library that hangs while it holds the interpreter stops them."""
    with suppress(OSError):
        while True:
            time.sleep(BEAT)
            line.send(("alive", None))


def silence_output() -> None:
    """Let libraries print nowhere: they would print to the terminal that the laboratory uses.

    The errors too: one prints each name that a stream tells, which anybody in its network can send.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    os.close(nowhere)


def _outcome(source: Source, stop: threading.Event, line: _ToParent, timeout: float) -> Message:
    """Pass on the frames until there are no more; how that came about."""
    try:
        line.send(("begun", None))
        frames = _connected(source, stop, timeout)
        line.send(("connected", None))
        for frame in frames:
            line.send(("frame", frame))
            if stop.is_set():
                break
    except Exception as trouble:
        return ("trouble", _one_line(trouble))
    return ("ended", None)


def _connected(source: Source, stop: threading.Event, timeout: float) -> Iterator[MocapFrame]:
    """Its frames, once it is connected.

    Should it hang while it holds the interpreter, and the parent be gone, then nothing but a clock
    that is none of Python's can end this process.
    """
    with open(os.devnull, "w") as nowhere:
        faulthandler.dump_traceback_later(timeout + 2.0, exit=True, file=nowhere)
        try:
            return source.frames(stop)
        finally:
            faulthandler.cancel_dump_traceback_later()


def _heed(line: Connection, stop: threading.Event) -> None:
    """Wait for the parent to say stop, or to be gone; then leave, whatever the source does."""
    with suppress(EOFError, OSError):
        line.recv()
    stop.set()
    time.sleep(GRACE)
    os._exit(0)


def _one_line(trouble: Exception) -> str:
    """What went wrong; errors that only a mistake in a source can raise are named by their kind."""
    if isinstance(trouble, MemoryError):
        return f"it asked for more memory than it gets ({MEMORY / 2**30:g} GiB)"
    text = " ".join(str(trouble).split()) or type(trouble).__name__
    expected = isinstance(trouble, (ValueError, OSError, RuntimeError))
    return text if expected else f"{type(trouble).__name__}: {text}"


KEPT = 2048
"""Frames that are kept: 20 s at 100 Hz."""

PAUSE, LONGEST_PAUSE = 1.0, 30.0
"""Seconds before a source is opened again: at first, and at most, doubled each time between."""
BEGINNING = 60.0
"""Seconds that a process has to begin: on a busy machine it takes some."""
SILENT = 10.0
"""Seconds without frame or sign of life after which a child is ended: its library hangs and holds
the interpreter, as some do on a forged count."""
STEADY = 10.0
"""Seconds of frames after which the pauses begin again with the shortest."""

State = Literal["connecting", "waiting", "streaming", "pausing", "ended", "failed", "closed"]


@dataclass(frozen=True, slots=True)
class LastSeen:
    """Where and when a body was last tracked."""

    pose: Pose
    received: float
    """`time.monotonic()` in seconds of that frame."""

    def age(self, now: float) -> float:
        """Seconds from then until `now`, a reading of `time.monotonic()`."""
        return now - self.received


class Feed:
    """The frames of a source, from a child process that starts at once.

    No method but `first` and `close` ever waits. `timeout` is how many seconds the source has to
    connect, from when its process has begun; one that hangs longer is ended.

    A source that was connected, or whose process was killed, is opened again after a pause if it
    fails: the numbers of its frames go on, and `trouble` stays until its next frame. One that fails
    as it connects for the first time was asked for wrongly, and fails for good.
    """

    def __init__(self, source: Source, timeout: float = 10.0) -> None:
        if not 0.0 < timeout <= 600.0:
            raise InputError(f"timeout = {timeout:g} s is outside (0, 600]")
        self.source = source
        self.timeout = timeout
        self.trouble = ""
        """What went wrong, in one line; empty while all is well."""
        self._state: State = "connecting"
        self._frames: deque[MocapFrame] = deque(maxlen=KEPT)
        self._seen: dict[str, LastSeen] = {}
        self._arrived = threading.Event()
        self._closing = threading.Event()
        self._ending = threading.Lock()  # only one thread at a time may wait for the process
        self._first_number = 0
        """What is added to the numbers of this child's frames, so that they always rise."""
        self._began: float | None = None
        """When this child brought its first frame, s."""
        self._newest = 0.0
        """When this child brought its last frame, or else was connected, s."""
        self._pause = PAUSE
        self._open()
        self._reader = threading.Thread(target=self._read, name="feed", daemon=True)
        self._reader.start()

    def _open(self) -> None:
        """Start a child that opens the source. Raises OSError if no process can be started."""
        spawn = multiprocessing.get_context("spawn")
        deadline = time.monotonic() + BEGINNING
        line, child_end = spawn.Pipe(duplex=True)
        with child_end:
            process = spawn.Process(
                target=serve,
                args=(self.source, child_end, self.timeout),
                name=f"flockscope {self.source.name}",
                daemon=True,
            )
            try:
                process.start()
            except OSError:
                line.close()
                raise
        self._line, self._process, self._deadline = line, process, deadline
        self._has_begun, self._began = False, None
        self._state = "connecting"

    def latest(self) -> MocapFrame | None:
        """The newest frame; None before the first."""
        try:
            return self._frames[-1]
        except IndexError:
            return None

    def since(self, number: int) -> list[MocapFrame]:
        """The frames after frame `number`, oldest first; of older ones than `KEPT`, none."""
        newer = []
        for frame in reversed(tuple(self._frames)):
            if frame.number <= number:
                break
            newer.append(frame)
        return newer[::-1]

    def last_seen(self) -> dict[str, LastSeen]:
        """Where and when each body was last tracked, by name."""
        return dict(self._seen)

    @property
    def state(self) -> State:
        """connecting, waiting (for the first frame), streaming, pausing (before it is opened
        again), ended, failed or closed."""
        return self._state

    @property
    def alive(self) -> bool:
        """Whether frames can still come."""
        return self._lives or self._state == "pausing"

    @property
    def process_id(self) -> int | None:
        """Of the child; None before it has begun."""
        return self._process.pid

    def first(self, within: float) -> MocapFrame:
        """Wait for a frame, at most `within` seconds.

        Raises InputError with the trouble, or if none came.
        """
        self._arrived.wait(within)
        frame = self.latest()
        if frame is None:
            silent = "it ended" if self._state == "ended" else f"{within:g} s passed"
            raise InputError(self.trouble or f"{self.source.describe()}: {silent} without a frame")
        return frame

    def close(self) -> None:
        """End the child, which is killed if it does not end by itself."""
        self._closing.set()
        with self._ending:
            with suppress(OSError):  # it is gone
                self._line.send(None)
            self._process.join(2.0 * GRACE)
            self._kill()
        self._reader.join()
        if self._state != "failed":
            self._state = "closed"

    def __enter__(self) -> Feed:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _read(self) -> None:
        """Take what the child sends until it is gone, and that of the next, until one is not."""
        is_open = True
        while is_open:
            self._take_all()
            self._line.close()
            is_open = self._open_again()
        self._arrived.set()

    def _open_again(self) -> bool:
        """Open the source again after a pause; False if it is not to be opened any more."""
        while self._state == "pausing" and not self._closing.wait(self._pause):
            self._pause = min(2.0 * self._pause, LONGEST_PAUSE)
            with self._ending:  # whoever closes sees either no child or one that is whole
                if self._closing.is_set():
                    break
                try:
                    self._open()
                    return True
                except OSError as error:  # of memory, processes or files there may be more later
                    why = error.strerror or error
                    self._fail(f"no process can be started: {why}", crashed=True)
        return False

    def _take_all(self) -> None:
        """Take what the child sends until it is gone."""
        while True:
            try:
                if not self._line.poll(self._seconds_left()):
                    self._give_up()
                    return
                self._take(self._line.recv())
                if not self._lives:
                    self._lost()
                    return
            except (EOFError, OSError):
                self._lost()
                return

    @property
    def _lives(self) -> bool:
        """Whether this child has not come to its end yet."""
        return self._state in ("connecting", "waiting", "streaming")

    def _seconds_left(self) -> float:
        """Seconds until the child is given up: to begin, to connect, to its next sign of life."""
        if self._state != "connecting":
            return SILENT
        return max(0.0, self._deadline - time.monotonic())

    def _take(self, message: Message) -> None:
        match message:
            case ("frame", MocapFrame() as frame):
                if self._began is None:
                    self._begin(frame)
                frame = replace(frame, number=frame.number + self._first_number)
                for sighting in frame.sightings:
                    if sighting.valid and sighting.pose is not None:
                        self._seen[sighting.name] = LastSeen(sighting.pose, frame.received)
                self._frames.append(frame)
                self._newest = time.monotonic()
                self._state = "streaming"
                self._arrived.set()
            case ("alive", _):
                if self._lives and self._state != "connecting":
                    self._demand_frames()
            case ("begun", _):
                self._has_begun, self._deadline = True, time.monotonic() + self.timeout
            case ("connected", _):
                self._newest = time.monotonic()
                self._state = "waiting"
            case ("ended", _):
                self._state = "ended"
            case ("trouble", str(text)):
                self._fail(text)

    def _begin(self, frame: MocapFrame) -> None:
        """The first frame of a child: all is well from now on."""
        last = self.latest()
        self._first_number = 0 if last is None else last.number + 1 - frame.number
        self._began = time.monotonic()
        self.trouble = ""

    def _demand_frames(self) -> None:
        """Have the source opened again if its frames have stopped for too long."""
        longest = getattr(self.source, "longest_gap", math.inf)  # older plug-ins have none
        if time.monotonic() - self._newest > longest:
            self._pause = PAUSE  # the wait for frames is pause enough
            self._fail(f"no frame for {longest:g} s")

    def _fail(self, text: str, crashed: bool = False) -> None:
        """Note what went wrong; whether it is opened again depends on how far it had come."""
        if self._began is not None and time.monotonic() - self._began > STEADY:
            self._pause = PAUSE
        again = crashed or self._state != "connecting" or self.latest() is not None
        then = f"; it is opened again in {self._pause:g} s" if again else ""
        self.trouble = f"{self.source.describe()}: {text}{then}"
        self._state = "pausing" if again else "failed"

    def _give_up(self) -> None:
        with self._ending:
            self._kill()
        if not self._has_begun:
            self._fail(f"its process has not begun within {BEGINNING:g} s", crashed=True)
        elif self._state == "connecting":
            self._fail(f"no connection within {self.timeout:g} s, given up")
        else:
            self._fail(f"no frame and no sign of life for {SILENT:g} s, ended")

    def _lost(self) -> None:
        """The child is gone: by its own end, by ours, or by something that nobody asked for."""
        with self._ending:
            self._process.join(2.0 * GRACE)
            self._kill()
            code = self._process.exitcode
        if not self._lives or self._closing.is_set():
            return
        if code is not None and code < 0:
            self._fail(f"its process was killed ({signal_name(-code)})", crashed=True)
        else:
            self._fail(f"its process ended by itself (exit code {code})")

    def _kill(self) -> None:
        if self._process.is_alive():
            self._process.terminate()
            self._process.join(GRACE)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
