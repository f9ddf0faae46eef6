"""A flock that runs in a thread of its own and never waits for whoever watches it."""

from __future__ import annotations

import math
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from agents.flock import Flock
from app.viewer.beside import Pair, companion
from app.viewer.commands import Commands, Models
from app.viewer.crowd import refuse_too_dense
from app.viewer.edits import freed
from app.viewer.frame import Frame
from app.viewer.pace import Pace
from app.viewer.picture import Wanted
from app.viewer.readings import Readings
from app.viewer.run import Run
from app.viewer.start import Start
from app.viewer.state import State
from app.viewer.words import Astray, in_words
from app.viewer.zones import stopped
from worlds.refusal import Refusal

FRAMES = 1 / 50
"""Shortest time between two frames, s."""
OBEDIENCE = 0.03
"""Longest time for commands before ticks are run again, s."""


class Simulation(Commands):
    """Runs a flock; `frame`, `state` and `readings` are always the latest."""

    def __init__(
        self,
        start: Start,
        speed: float = 15.0,
        running: bool = True,
        build: Callable[[Start], Flock] = Start.build,
        build_beside: Callable[[Start, Flock], Flock] = companion,
    ):
        super().__init__()
        self.frame: Frame | None = None
        self.readings: Readings | None = None
        self.readings_beside: Readings | None = None
        self.state = State(start, running=running, busy=True, speed=speed)
        self.ready = threading.Event()
        """Set when the first flock can be seen and, if it is to run, is compiled."""
        self.build = build
        self.build_beside = build_beside
        self.run: Run | None = None
        self.wanted = Wanted()
        self.watched: frozenset[str] = frozenset()
        self.pace = Pace(speed)
        self.next_start: Start | None = start
        self.stale = False
        """Whether the flock has changed since the last frame."""
        self.next_frame = 0.0
        self.closing = False
        self.thread = threading.Thread(target=self.live, name="simulation", daemon=True)
        self.thread.start()

    def close(self, wait: float = 2.0) -> None:
        """Stop for good."""
        self.closing = True
        self.commands.wake()
        self.thread.join(wait)

    # The simulation's own thread.

    def live(self) -> None:
        """Obey, run and leave frames, until closed."""
        while not self.closing:
            self.obey()
            try:
                if self.next_start is not None:
                    self.set_up()
                self.leave()
                if self.state.running:
                    self.run_due()
            except Exception as error:
                self.fail(error)

    def obey(self) -> None:
        """Carry out what was told; wait for it if there is nothing else to do.

        However much is told, the flock gets its turn.
        """
        waiting = self.commands.get(timeout=self.idle_time())
        end = time.perf_counter() + OBEDIENCE
        while waiting is not None:
            self.carry_out(waiting)
            over = self.closing or time.perf_counter() >= end
            waiting = None if over else self.commands.get(timeout=0.0)

    def idle_time(self) -> float | None:
        """How long to wait for commands, s; None for ever."""
        if self.next_start is not None or self.stale:
            return 0.0
        return self.pace.wait(time.perf_counter()) if self.state.running else None

    def run_due(self) -> None:
        """Run the ticks that are due."""
        run = self.sound_run()
        ticks = self.pace.ticks_due(time.perf_counter())
        if ticks == 0:
            return
        began = time.perf_counter()
        self.advance(run, ticks)
        now = time.perf_counter()
        self.pace.took(ticks, now - began)
        self.stale = now >= self.next_frame

    def advance(self, run: Run, ticks: int) -> None:
        """Run ticks; the first ones of a model may have to be compiled."""
        if run.is_compiled:
            run.advance(ticks)
            return
        self.state = replace(self.state, busy=True)
        run.advance(ticks)
        self.state = replace(self.state, busy=False)
        self.pace.restart()
        self.ready.set()

    def leave(self) -> None:
        """Leave a frame and readings for whoever watches, if there is anything new."""
        if not self.stale or self.run is None:
            return
        self.stale = False
        now = time.perf_counter()
        self.next_frame = now + FRAMES
        self.warn(self.run)
        known = len(self.run.troubles)
        self.frame = self.run.look(closely=not self.state.running)
        for trouble in self.run.troubles[known:]:
            if not isinstance(trouble, Refusal | Astray):
                traceback.print_exception(trouble)
            self.notices.put(in_words(trouble))
        self.readings = self.run.readings
        second = self.run.second
        self.readings_beside = None if second is None else second.readings
        self.state = replace(self.state, rate=self.pace.rate(now) if self.state.running else 0.0)
        if not self.state.running:
            self.ready.set()

    def set_up(self) -> None:
        """Build the flock of the next start."""
        start, self.next_start = self.next_start, None
        assert start is not None
        self.state = replace(self.state, busy=True)
        try:
            flock = self.build(start)
            refuse_too_dense(flock)
            self.run = self.new_run(start, flock)
        except Refusal as refusal:
            self.notices.put(str(refusal))
            self.state = replace(
                self.state, busy=False, running=self.state.running and self.run is not None
            )
            self.ready.set()
            return
        self.take_over(self.run, start)
        self.pace.restart()
        self.stale = True
        self.state = replace(
            self.state,
            start=start,
            run=self.run.number,
            busy=False,
            error="",
            agents=len(flock.ids),
            values=self.run.values,
            beside_values=self.run.beside_values,
        )

    def new_run(self, start: Start, flock: Flock) -> Run:
        """The run of a flock, and of the one beside it. Raises Refusal."""
        number = self.state.run + 1
        if start.beside is None:
            return Run(flock, number, self.wanted, self.watched)
        second = self.build_beside(start, flock)
        refuse_too_dense(second)
        return Pair(flock, second, number, self.wanted, self.watched)

    def fail(self, error: Exception) -> None:
        """A rule went wrong: stop the run, say why and live on."""
        if not isinstance(error, Refusal | ArithmeticError):
            traceback.print_exception(error)
        self.stale = False
        self.notices.put(in_words(error))
        self.state = replace(self.state, running=False, busy=False, rate=0.0, error=in_words(error))
        self.ready.set()

    def sound_run(self) -> Run:
        """The run. Raises Refusal if there is none, or it is broken."""
        if self.run is None or self.state.error:
            raise Refusal("there is no flock to run: press Setup")
        return self.run

    def warn(self, run: Run) -> None:
        """Tell of flocks whose agents go through what is solid, once for each setting."""
        for one in run.both:
            words = one.flock.warning
            if words and words != one.warned:
                self.notices.put(words)
            one.warned = words

    def schedule(self, start: Start) -> None:
        self.next_start = start

    def switch(self, on: bool) -> None:
        if on and self.next_start is None:
            self.sound_run()
        self.pace.restart()
        self.state = replace(self.state, running=on)
        self.stale = self.run is not None and not self.state.error

    def step_now(self, ticks: int) -> None:
        run = self.sound_run()
        self.state = replace(self.state, running=False)
        try:
            self.advance(run, ticks)
        except Exception as error:
            self.fail(error)
            return
        self.stale = True

    def change_pace(self, speed: float) -> None:
        if math.isnan(speed) or speed <= 0:
            raise Refusal(f"speed = {speed} ticks/s is not allowed: it must be above 0")
        self.pace = Pace(speed)
        self.state = replace(self.state, speed=speed)

    def set_now(self, name: str, value: Any, beside: bool, models: Models | None) -> Any:
        run, start = self.sound_run(), self.state.start
        if models not in (None, (start.model, start.beside)):
            return value
        taken = run.allowed(name, value, beside)
        run.set(name, taken, beside)
        if taken != value:
            flock = run.second.flock if beside and run.second is not None else run.flock
            self.notices.put(stopped(flock, name, taken))
        self.pace.doubt()
        self.state = replace(self.state, values=run.values, beside_values=run.beside_values)
        self.stale = True
        return taken

    def place_now(self, row: int, position: np.ndarray, heading: np.ndarray) -> None:
        run = self.sound_run()
        run.place(row, freed(run, position), heading)
        self.stale = True

    def look_again_now(self) -> None:
        self.stale = self.run is not None and not self.state.error

    def watch_now(self, names: frozenset[str]) -> None:
        self.watched = names
        if self.run is not None:
            self.run.watch(names)
            self.stale = not self.state.error

    def want_now(self, wanted: Wanted) -> None:
        self.wanted = wanted
        if self.run is not None and not self.state.error:
            self.run.want(wanted)
            self.stale = True
