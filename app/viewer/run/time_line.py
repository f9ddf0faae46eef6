"""The time line of a run: a recording is sought in, a live run is looked back at and gone on from.

Looking back puts the flock itself where it was, so that everything can be seen of it; what it was
before is kept until one goes back to now, or on from there.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from agents.snapshot import Snapshot
from agents.spec import CompleteSpec
from app.viewer.editing.editor import Editor
from app.viewer.measuring.background_worker import WorkThrottle
from app.viewer.run.edits import Edits
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.paired_run import PairedRun
from app.viewer.run.playback import Playback
from app.viewer.run.simulation_state import SimulationState, TimeLineState
from app.viewer.run.stored_flock import InitialState
from worlds.input_error import InputError

# What is kept of a live run, so that one can look back and go on from there.

MEMORY = 64 * 2**20
"""Bytes that are kept."""
MOST = 2000
"""Moments that are kept."""


@dataclass(frozen=True)
class RunCheckpoint:
    """A run at a tick: all that it takes to go on from there to the bit."""

    snapshots: tuple[Snapshot, ...]
    """Of its flock, and of the one beside it."""
    least: tuple[tuple[float, float], ...]
    """How close agents of each had come to each other and to what is solid."""
    owed: float
    """Part of a tick by which the second flock was behind."""
    spec: CompleteSpec
    """What it was set up as, with the world as it was then."""
    editor: Editor | None
    """That world with its history."""

    @property
    def tick(self) -> int:
        """Ticks done by the first flock."""
        return self.snapshots[0].tick

    @property
    def size(self) -> int:
        """Bytes."""
        return sum(array.nbytes for snapshot in self.snapshots for array in snapshot.arrays)


@dataclass
class CheckpointHistory:
    """Moments of one run, ticks rising: the first, and the denser the closer to the last.

    >>> CheckpointHistory().last_before(5) is None
    True
    """

    memory: int = MEMORY
    moments: list[RunCheckpoint] = field(default_factory=list)
    size: int = 0
    """Bytes of all."""

    def note(self, moment: RunCheckpoint) -> None:
        """Keep a moment, instead of one that is not before it; forget what there is no room for."""
        self.cut(moment.tick - 1)
        self.moments.append(moment)
        self.size += moment.size
        while len(self.moments) > 2 and (self.size > self.memory or len(self.moments) > MOST):
            self.drop(self.least_needed())

    def least_needed(self) -> int:
        """Which moment, not the first and not the last, leaves the smallest gap for its age."""
        ticks = np.array([moment.tick for moment in self.moments], float)
        gap = ticks[2:] - ticks[:-2]
        return 1 + int(np.argmin(gap / (ticks[-1] - ticks[1:-1])))

    def drop(self, place: int) -> None:
        """Forget a moment."""
        self.size -= self.moments.pop(place).size

    def cut(self, tick: int) -> None:
        """Forget what was after a tick."""
        while self.moments and self.moments[-1].tick > tick:
            self.drop(-1)

    def forget(self) -> None:
        """Forget everything."""
        self.moments, self.size = [], 0

    def last_before(self, tick: int) -> RunCheckpoint | None:
        """The last moment that is not after a tick, else the first."""
        earlier = [moment for moment in self.moments if moment.tick <= tick]
        return earlier[-1] if earlier else next(iter(self.moments), None)


SETTLED = 0.25
"""Time after the last move along the line after which everything is measured, s."""
OFTEN, SHARE = 0.1, 0.01
"""Shortest time between two moments that are kept, s, and the share of all time that it takes."""


class TimeLineHost(Protocol):
    """What a time line needs of the simulation whose it is."""

    run: FlockRun | None
    state: SimulationState
    stale: bool
    edits: Edits

    def tell(
        self, command: Callable[[], Any], key: str = "", runs: bool | None = None
    ) -> Future: ...

    def renumber(self, run: FlockRun) -> None: ...
    def require_run(self) -> FlockRun: ...

    def begin(self, stored: InitialState) -> None: ...


class TimeLine:
    """Moves a simulation along its time; commands return at once, as the simulation's own do."""

    def __init__(self, host: TimeLineHost) -> None:
        self.host = host
        self.history = CheckpointHistory()
        self.present: RunCheckpoint | None = None
        """The run as it was before one looked back; None: nobody does."""
        self.rate_limit = WorkThrottle(OFTEN, SHARE)
        self.moved: float | None = None
        """When it was last moved along the line, until all has been measured, s."""
        self.sought = 0, 0
        """The tick that was asked for last, and that which was shown for it."""

    # Commands.

    def seek(self, tick: int) -> Future:
        """Show a tick, or the last one before it that is known; a live run pauses."""
        return self.host.tell(lambda: self.seek_now(tick), "seek")

    def go_on(self) -> Future:
        """Make what is shown the present: what came after it is given up. It stands still."""
        return self.host.tell(self.go_on_now, "go on", runs=False)

    def to_now(self) -> Future:
        """End looking back."""
        return self.host.tell(self.to_now_now, "to now")

    # The simulation's own thread.

    def seek_now(self, tick: int) -> None:
        host, run = self.host, self.host.require_run()
        if isinstance(run, Playback):
            run.seek(tick)
        else:
            now = self.present or self.checkpoint(run)
            then = now if tick >= now.tick else self.history.last_before(tick)
            if then is None:
                raise InputError("this run has no past to look back at yet")
            self.present = None if then is now else now
            restore(run, then)
            values, others = run.values, run.beside_values
            host.state = replace(
                host.state,
                running=False,
                rate=0.0,
                values=values,
                beside_values=others,
                kinds=run.kinds,
            )
            for flock_run in run.both:
                flock_run.readings.notes = self.present is None
                flock_run.readings.aside.forget()
        self.sought = tick, run.flock.tick
        self.moved = time.perf_counter()
        host.stale = True

    def go_on_now(self) -> None:
        host, run = self.host, self.host.require_run()
        if isinstance(run, Playback):
            host.begin(run.state_to_go_on())
        elif self.present is not None:
            then = self.history.last_before(run.flock.tick)
            if then is None:
                raise InputError("this run has no earlier tick to go on from")
            self.present = None
            self.history.cut(then.tick)
            host.renumber(run)
            for flock_run, least in zip(run.both, then.least, strict=True):
                flock_run.readings.notes = True
                flock_run.readings.cut(flock_run.flock.tick)
                flock_run.readings.extremes.resume(least)
            host.edits.editor = then.editor
            host.state = replace(
                host.state,
                spec=then.spec,
                values=run.values,
                beside_values=run.beside_values,
                kinds=run.kinds,
            )
            host.stale = True

    def to_now_now(self) -> None:
        if self.present is not None:
            self.seek_now(self.present.tick)

    def resume(self) -> None:
        """It is to run: from what is shown, and a recording that is over from its beginning."""
        run = self.host.run
        if isinstance(run, Playback):
            if run.is_over:
                run.seek(run.first)
        elif self.present is not None:
            self.go_on_now()

    def demand_now(self, name: str = "", beside: bool = False) -> None:
        """Raise InputError where nothing can be changed: in a recording, and while looking back.

        `name`: the parameter that is to be set, of the flock beside if so; empty for other changes.
        """
        run = self.host.run
        if isinstance(run, Playback):
            run.demand_change(name, beside)
        if self.present is not None and run is not None:
            raise InputError(
                f"you look back at tick {run.flock.tick}: go on from here, or go back to now, "
                "before you change anything"
            )

    def forget(self) -> None:
        """Another run begins."""
        self.history.forget()
        self.present = self.moved = None
        self.sought = 0, 0
        self.changed()

    def changed(self) -> None:
        """What is kept of this tick is no longer what it was."""
        self.rate_limit.renew()

    def note(self, run: FlockRun) -> None:
        """Keep the run as it is, if that is due."""
        if isinstance(run, Playback) or self.present is not None:
            return
        if self.rate_limit.is_due(time.perf_counter()):
            with self.rate_limit.measure_duration():
                self.history.note(self.checkpoint(run))

    def checkpoint(self, run: FlockRun) -> RunCheckpoint:
        """The run as it is."""
        return RunCheckpoint(
            tuple(run.flock.snapshot() for run in run.both),
            tuple(run.readings.extremes.least for run in run.both),
            run.owed if isinstance(run, PairedRun) else 0.0,
            self.host.state.spec,
            self.host.edits.editor,
        )

    def line(self, run: FlockRun) -> TimeLineState | None:
        """What there is to move along; None where there is nothing yet."""
        at = run.flock.tick
        if isinstance(run, Playback):
            line = TimeLineState(run.first, run.last, at, recording=run.stored.name)
        elif self.history.moments:
            last = at if self.present is None else self.present.tick
            line = TimeLineState(self.history.moments[0].tick, last, at, self.present is not None)
        else:
            return None
        asked, shown = self.sought
        is_other = shown == at < asked <= line.last and (line.recording or line.looks_back)
        return replace(line, sought=asked) if is_other else line

    def time_to_settle(self, now: float) -> float | None:
        """Time until everything is to be measured where one has moved to, s; None: it has been."""
        return None if self.moved is None else max(0.0, self.moved + SETTLED - now)

    def settle(self) -> None:
        """Have everything measured as soon as one has moved for the last time."""
        if self.time_to_settle(time.perf_counter()) == 0.0:
            self.moved = None
            self.host.stale = True


def restore(run: FlockRun, then: RunCheckpoint) -> None:
    """Put the flocks of a run where they were."""
    for flock_run, snapshot in zip(run.both, then.snapshots, strict=True):
        flock_run.flock.return_to(snapshot)
    if isinstance(run, PairedRun):
        run.owed = then.owed
