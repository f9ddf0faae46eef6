"""A flock that runs in a thread of its own and never waits for whoever watches it."""

from __future__ import annotations

import math
import queue
import tempfile
import threading
import time
import traceback
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from agents.flock import Flock
from app.viewer.frame import Frame
from app.viewer.pace import Pace
from app.viewer.picture import Camera, Wanted
from app.viewer.readings import Readings
from app.viewer.start import Start
from worlds.refusal import Refusal

FRAMES = 1 / 50
"""Shortest time between two frames, s."""


@dataclass(frozen=True)
class State:
    """How the simulation stands; replaced as a whole, never changed."""

    start: Start
    """What the flock was set up from."""
    run: int = 0
    """Counts the set-ups."""
    running: bool = False
    busy: bool = False
    """Whether a flock is being set up or compiled."""
    error: str = ""
    """What stopped the run; Setup or Reset mends it."""
    speed: float = 15.0
    """Wanted ticks per second; infinity for as fast as it goes."""
    rate: float = 0.0
    """Ticks per second as they happen."""
    agents: int = 0
    """Rows of the flock, information agents among them."""
    values: dict[str, Any] = field(default_factory=dict)
    """The flock's parameters, name -> value."""


class Simulation:
    """Runs a flock; `frame`, `state` and `readings` are always the latest.

    Commands may come from any thread and return at once; they are carried out in order, between
    two ticks. What a user must be told is left in `notices`.
    """

    def __init__(
        self,
        start: Start,
        speed: float = 15.0,
        running: bool = True,
        build: Callable[[Start], Flock] = Start.build,
    ):
        self.frame: Frame | None = None
        self.readings: Readings | None = None
        self.state = State(start, speed=speed, busy=True)
        self.notices: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.build = build
        self.flock: Flock | None = None
        self.compiled = False
        """Whether the flock has run, so that its next tick need not be compiled."""
        self.camera: Camera | None = None
        self.wanted = Wanted()
        self.pace = Pace(speed)
        self.next_start: Start | None = start
        self.begin_running = running
        self.stale = False
        self.next_frame = 0.0
        self.ready = threading.Event()
        """Set when the first flock is there and compiled, or has failed."""
        self.closing = False
        self.commands: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self.thread = threading.Thread(target=self.live, name="simulation", daemon=True)
        self.thread.start()

    # Commands.

    def tell(self, command: Callable[[], Any]) -> Future:
        """Carry out a command between two ticks; what it refuses becomes a notice."""
        answer: Future = Future()

        def carry_out() -> None:
            try:
                answer.set_result(command())
            except Exception as error:
                self.notices.put(in_words(error))
                answer.set_exception(error)

        self.commands.put(carry_out)
        return answer

    def setup(self, start: Start) -> Future:
        """Build a new flock; of several set-ups at once only the last is built."""
        return self.tell(lambda: self.schedule(start))

    def reset(self) -> Future:
        """The same flock again: same seed, same start, the parameters as they are now."""
        return self.tell(
            lambda: self.schedule(self.state.start.but(parameters=dict(self.state.values)))
        )

    def go(self) -> Future:
        """Run."""
        return self.tell(lambda: self.switch(True))

    def pause(self) -> Future:
        """Stop running, until told to go."""
        return self.tell(lambda: self.switch(False))

    def toggle(self) -> Future:
        """Pause if running, go if not."""
        return self.tell(lambda: self.switch(not self.state.running))

    def step(self, ticks: int = 1) -> Future:
        """Pause and run a few ticks."""
        return self.tell(lambda: self.step_now(ticks))

    def run_at(self, speed: float) -> Future:
        """Run at so many ticks per second; infinity for as fast as it goes."""
        return self.tell(lambda: self.change_pace(speed))

    def set(self, name: str, value: Any) -> Future:
        """Give the running flock's parameter a new value."""
        return self.tell(lambda: self.set_now(name, value))

    def place(self, row: int, position: np.ndarray, heading: np.ndarray) -> Future:
        """Put an agent somewhere and turn it."""
        return self.tell(lambda: self.place_now(row, position, heading))

    def want(self, wanted: Wanted) -> Future:
        """Say what frames should hold beside positions and headings."""
        return self.tell(lambda: self.want_now(wanted))

    def spec(self) -> Future:
        """The run as TOML text."""
        return self.tell(lambda: self.there().spec.to_toml())

    def saved(self) -> Future:
        """The flock's saved state, bytes."""
        return self.tell(self.save_now)

    def close(self, wait: float = 2.0) -> None:
        """Stop for good."""
        self.closing = True
        self.commands.put(lambda: None)
        self.thread.join(wait)

    # The simulation's own thread.

    def live(self) -> None:
        """Obey, run and leave frames, until closed."""
        while not self.closing:
            self.obey()
            try:
                if self.next_start is not None:
                    self.set_up()
                if self.state.running:
                    self.run()
                self.leave()
            except Exception as error:
                self.fail(error)
                self.ready.set()

    def obey(self) -> None:
        """Carry out what was told; wait for it if there is nothing else to do."""
        try:
            self.commands.get(timeout=self.idle_time())()
            while not self.closing:
                self.commands.get_nowait()()
        except queue.Empty:
            pass

    def idle_time(self) -> float | None:
        """How long to wait for commands, s; None for ever."""
        if self.next_start is not None or self.stale:
            return 0.0
        return self.pace.wait(time.perf_counter()) if self.state.running else None

    def run(self) -> None:
        """Run the ticks that are due."""
        flock = self.there()
        ticks = self.pace.ticks_due(time.perf_counter())
        if ticks == 0:
            return
        if not self.compiled:
            self.leave()
        began = time.perf_counter()
        self.advance(flock, ticks)
        self.pace.took(ticks, time.perf_counter() - began)
        if time.perf_counter() >= self.next_frame:
            self.stale = True

    def advance(self, flock: Flock, ticks: int) -> None:
        """Run ticks; the first ones of a model may have to be compiled."""
        if self.compiled:
            flock.advance(ticks)
            return
        self.state = replace(self.state, busy=True)
        flock.advance(ticks)
        self.state = replace(self.state, busy=False)
        self.compiled = True
        self.pace.restart()
        self.ready.set()

    def leave(self) -> None:
        """Leave a frame and readings for whoever watches, if there is anything new."""
        if not self.stale or self.camera is None or self.readings is None:
            return
        self.stale = False
        now = time.perf_counter()
        self.next_frame = now + FRAMES
        self.readings.read(at_once=not self.state.running)
        self.frame = self.camera.take()
        self.state = replace(self.state, rate=self.pace.rate(now) if self.state.running else 0.0)

    def set_up(self) -> None:
        """Build the flock of the next start."""
        start, self.next_start = self.next_start, None
        assert start is not None
        self.state = replace(self.state, busy=True)
        try:
            flock = self.build(start)
        except Refusal as refusal:
            self.notices.put(str(refusal))
            self.state = replace(self.state, busy=False)
            return
        self.flock = flock
        self.compiled = False
        self.readings = Readings(flock)
        run = self.state.run + 1
        self.camera = Camera(flock, run, self.wanted)
        self.pace.restart()
        self.state = replace(
            self.state,
            start=start,
            run=run,
            busy=False,
            error="",
            agents=len(flock.ids),
            values=flock.parameters.model_dump(),
        )
        self.stale = True
        if self.begin_running:
            self.begin_running = False
            self.switch(True)
        else:
            self.ready.set()

    def fail(self, error: Exception) -> None:
        """A rule went wrong: stop the run, say why and live on."""
        if not isinstance(error, Refusal | ArithmeticError):
            traceback.print_exception(error)
        self.stale = False
        self.notices.put(in_words(error))
        self.state = replace(self.state, running=False, busy=False, rate=0.0, error=in_words(error))

    def there(self) -> Flock:
        """The flock. Raises Refusal if there is none, or it is broken."""
        if self.flock is None or self.state.error:
            raise Refusal("there is no flock to run: press Setup")
        return self.flock

    def schedule(self, start: Start) -> None:
        self.next_start = start

    def switch(self, on: bool) -> None:
        if on and self.next_start is None:
            self.there()
        self.pace.restart()
        self.state = replace(self.state, running=on)
        self.stale = True

    def step_now(self, ticks: int) -> None:
        flock = self.there()
        self.state = replace(self.state, running=False)
        try:
            self.advance(flock, ticks)
        except Exception as error:
            self.fail(error)
            return
        self.stale = True

    def change_pace(self, speed: float) -> None:
        if math.isnan(speed) or speed <= 0:
            raise Refusal(f"speed = {speed} ticks/s is not allowed: it must be above 0")
        self.pace = Pace(speed)
        self.state = replace(self.state, speed=speed)

    def set_now(self, name: str, value: Any) -> None:
        flock = self.there()
        flock.set(**{name: value})
        self.state = replace(self.state, values=flock.parameters.model_dump())
        self.stale = True

    def place_now(self, row: int, position: np.ndarray, heading: np.ndarray) -> None:
        flock = self.there()
        flock.position[row] = position
        flock.heading[row] = heading
        self.stale = True

    def want_now(self, wanted: Wanted) -> None:
        self.wanted = wanted
        if self.camera is not None:
            self.camera.want(wanted)
            self.stale = True

    def save_now(self) -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "flock.parquet"
            self.there().save(path)
            return path.read_bytes()


def in_words(error: BaseException) -> str:
    """An error as one line for the user."""
    if isinstance(error, Refusal | ArithmeticError):
        return str(error)
    return f"{type(error).__name__}: {error}"
