"""A tracking source in a process of its own, read without ever waiting for it.

A thread takes what the child sends and keeps it; the control loop looks at what is kept. A source
that hangs, dies or falls silent therefore costs the loop nothing: its newest frame grows old, and
`trouble` says in one line what is known.
"""

from __future__ import annotations

import multiprocessing
import signal
import threading
import time
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from typing import Literal

from app.live.control.pose import MocapFrame, Pose
from app.live.sources.child import GRACE, Message, serve
from app.live.sources.source import Source
from worlds.refusal import Refusal

KEPT = 2048
"""Frames that are kept: 20 s at 100 Hz."""

State = Literal["connecting", "waiting", "streaming", "ended", "failed", "closed"]


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

    No method but `first` and `close` ever waits. `patience` is how many seconds the source has to
    connect, the start of the process included; one that hangs longer is ended.
    """

    def __init__(self, source: Source, patience: float = 10.0) -> None:
        if not 0.0 < patience <= 600.0:
            raise Refusal(f"patience = {patience:g} s is outside (0, 600]")
        self.source = source
        self.patience = patience
        self.trouble = ""
        """What went wrong, in one line; empty while all is well."""
        self._state: State = "connecting"
        self._frames: deque[MocapFrame] = deque(maxlen=KEPT)
        self._seen: dict[str, LastSeen] = {}
        self._arrived = threading.Event()
        self._closing = False
        self._ending = threading.Lock()  # only one thread at a time may wait for the process
        spawn = multiprocessing.get_context("spawn")
        self._line, theirs = spawn.Pipe(duplex=True)
        self._process = spawn.Process(
            target=serve,
            args=(source, theirs, patience),
            name=f"flockscope {source.name}",
            daemon=True,
        )
        self._deadline = time.monotonic() + patience
        self._process.start()
        theirs.close()
        self._reader = threading.Thread(target=self._read, name="feed", daemon=True)
        self._reader.start()

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
        """connecting, waiting (for the first frame), streaming, ended, failed or closed."""
        return self._state

    @property
    def alive(self) -> bool:
        """Whether frames can still come."""
        return self._state in ("connecting", "waiting", "streaming")

    @property
    def process_id(self) -> int:
        """Of the child."""
        assert self._process.pid is not None
        return self._process.pid

    def first(self, within: float) -> MocapFrame:
        """Wait for a frame, at most `within` seconds.

        Raises Refusal with the trouble, or if none came.
        """
        self._arrived.wait(within)
        frame = self.latest()
        if frame is None:
            silent = "it ended" if self._state == "ended" else f"{within:g} s passed"
            raise Refusal(self.trouble or f"{self.source.describe()}: {silent} without a frame")
        return frame

    def close(self) -> None:
        """End the child, which is killed if it does not end by itself."""
        self._closing = True
        with suppress(OSError):  # it is gone
            self._line.send(None)
        with self._ending:
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
        """Take what the child sends until it is gone."""
        while True:
            try:
                if not self._line.poll(self._left()):
                    self._give_up()
                    break
                self._take(self._line.recv())
            except (EOFError, OSError):
                self._lost()
                break
        self._line.close()
        self._arrived.set()

    def _left(self) -> float | None:
        """Seconds until the source is given up; None once it is connected."""
        if self._state != "connecting":
            return None
        return max(0.0, self._deadline - time.monotonic())

    def _take(self, message: Message) -> None:
        match message:
            case ("frame", MocapFrame() as frame):
                for sighting in frame.sightings:
                    if sighting.valid and sighting.pose is not None:
                        self._seen[sighting.name] = LastSeen(sighting.pose, frame.received)
                self._frames.append(frame)
                self._state = "streaming"
                self._arrived.set()
            case ("connected", _):
                self._state = "waiting"
            case ("ended", _):
                self._state = "ended"
            case ("trouble", str(text)):
                self._fail(text)

    def _fail(self, text: str) -> None:
        self.trouble = f"{self.source.describe()}: {text}"
        self._state = "failed"

    def _give_up(self) -> None:
        with self._ending:
            self._kill()
        self._fail(f"no connection within {self.patience:g} s, given up")

    def _lost(self) -> None:
        """The child is gone: by its own end, by ours, or by something that nobody asked for."""
        with self._ending:
            self._process.join(2.0 * GRACE)
            code = self._process.exitcode
        if not self.alive or self._closing:
            return
        if code is not None and code < 0:
            self._fail(f"its process was killed ({signal.Signals(-code).name})")
        else:
            self._fail(f"its process ended by itself (exit code {code})")

    def _kill(self) -> None:
        if self._process.is_alive():
            self._process.terminate()
            self._process.join(GRACE)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
