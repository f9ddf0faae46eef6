"""One run of a sweep: from its spec and its seed to an outcome; what the processes are given."""

from __future__ import annotations

import hashlib
import inspect
import math
from collections import deque
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from agents.engine.cache import fingerprint as feed
from agents.flock import Flock
from agents.models.rule_file import run as run_file
from agents.observables.catalogue import OBSERVABLES
from agents.observables.observable import SERIES
from agents.recordings.recorder import Recorder
from agents.spec import Spec
from app.studies.runs.database import FIXED, Outcome, Status
from app.studies.sweeps.designs import find_file
from app.studies.sweeps.sweep_file import ObservableBound, Observe
from app.studies.workers.flock_pool import FlockPool, run_ticks
from app.studies.workers.run_worker import stop_if_unwanted
from worlds.input_error import InputError, unknown
from worlds.text_file import read_text

# What is measured of a run: observables by name and functions of one's own, now or over time.

K = "k"
"""The column of the tick from which the condition of [stop] held."""
HEADS = (*FIXED, "place", "observable", "value", "tick")
"""Columns of every table of runs: no axis and no measure has their names."""
RESERVED = (*HEADS, K, "replicate")
"""Names that no column of a measure has."""


@dataclass(frozen=True)
class SweepMeasure:
    """One thing that is measured of runs."""

    column: str
    name: str = ""
    """An observable, or else"""
    path: str = ""
    function: str = ""
    every: int | None = None
    """Ticks between two looks along the run; None: at its end only."""
    over: int | None = None
    """Ticks at the end of the run over which it is measured."""

    @property
    def is_series(self) -> bool:
        """Whether it has a value for each look, and none for the run."""
        return self.every is not None

    def getter(self) -> Callable[[Flock], float]:
        """What measures it of a flock now. Raises InputError if a file of one's own has it not."""
        if not self.path:
            name = SERIES if OBSERVABLES[self.name].over else self.name
            return lambda flock: float(flock.observe(name))
        function = getattr(module_of(Path(self.path)), self.function, None)
        if not callable(function):
            raise InputError(f"measure {self.function!r}: there is no such function in {self.path}")
        return lambda flock: float(function(flock.snapshot(copy=False).measurable()))

    def summarise(self, values: list[float], agents: list[int]) -> float:
        """What the looks at the end of a run come to: their mean, or what is taken of a series."""
        if not values:
            return math.nan
        take = OBSERVABLES[self.name].over if self.name else None
        if take is not None:
            return take(np.array(values), float(np.mean(agents)))
        return float(np.mean(values))

    @property
    def fingerprint(self) -> str:
        """A hash of what it does."""
        digest = hashlib.sha256()
        if self.path:
            digest.update(Path(self.path).read_bytes())
            return digest.hexdigest()[:12]
        observable = OBSERVABLES[self.name]
        for function in (observable.measure, observable.over):
            if inspect.isfunction(function):
                feed(function, digest, set())
        return digest.hexdigest()[:12]


def module_of(path: Path) -> ModuleType:
    """A Python file of one's own, run. Raises InputError naming the file and the line of a
    fault."""
    text = read_text(f"measure {str(path)!r}", path)
    return run_file(path, text, f"measures_{hashlib.sha256(text.encode()).hexdigest()[:16]}")


def measure_of(entry: Observe, folder: Path) -> SweepMeasure:
    """What a table [[observe]] asks for. Raises InputError."""
    if entry.measure:
        file, colon, function = entry.measure.rpartition(":")
        if not colon or not file.endswith(".py") or not function.isidentifier():
            raise InputError(
                f"measure = {entry.measure!r} is not allowed: FILE.py:FUNCTION is needed"
            )
        path, name = str(find_file(file, folder).absolute()), ""
    else:
        path, function, name = "", "", entry.name
        demand_number(name)
        if OBSERVABLES[name].over and entry.over is None:
            raise InputError(f"{name} is measured over a run: give over, the ticks at its end")
    column = entry.column or (name or function)
    if not entry.column and entry.over is not None and not (name and OBSERVABLES[name].over):
        column += f"-over-{entry.over}"
    if column.lower() in RESERVED or not column.isprintable():
        raise InputError(f"column = {column!r} is not allowed: name another")
    measure = SweepMeasure(column, name, path, function, entry.every, entry.over)
    measure.getter()
    return measure


def demand_number(name: str) -> None:
    """Refuse what is no observable, or a table. Raises InputError."""
    if name not in OBSERVABLES:
        raise unknown("observable", name, OBSERVABLES)
    if OBSERVABLES[name].is_table:
        raise InputError(f"{name} is a table, not a number: a sweep cannot keep it")


class RunObserver:
    """What has been seen of a running flock, for all that is measured of it."""

    def __init__(self, measures: tuple[SweepMeasure, ...], getters: list[Callable[[Flock], float]]):
        self.measures = measures
        self.getters = getters
        self.windows: list[deque[float] | None] = [
            deque(maxlen=measure.over) if measure.over else None for measure in measures
        ]
        self.agents: deque[int] = deque(
            maxlen=max((measure.over or 1 for measure in measures), default=1)
        )
        self.series: list[tuple[list[int], list[float]]] = [([], []) for _ in measures]

    def look(self, flock: Flock, windows: bool) -> None:
        """Look at the flock after a tick; at what is measured over the last ticks if `windows`."""
        values: dict[int, float] = {}
        if windows:
            self.agents.append(int(flock.active.sum()))
        for k, (measure, get) in enumerate(zip(self.measures, self.getters, strict=True)):
            window = self.windows[k]
            if window is not None and windows:
                window.append(get(flock))
            elif measure.every is not None and flock.tick % measure.every == 0:
                values[k] = get(flock)
        for k, value in values.items():
            self.series[k][0].append(flock.tick)
            self.series[k][1].append(value)

    def values(self, flock: Flock) -> dict[str, Any]:
        """What the run comes to, by column."""
        values: dict[str, Any] = {}
        agents = list(self.agents)
        for measure, get, window in zip(self.measures, self.getters, self.windows, strict=True):
            if window is not None:
                values[measure.column] = measure.summarise(
                    list(window), agents[-len(window) or None :]
                )
            elif not measure.is_series:
                values[measure.column] = get(flock)
        return values

    def series_by_column(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """The series, by column."""
        return {
            measure.column: (np.array(ticks, np.int64), np.array(values, float))
            for measure, (ticks, values) in zip(self.measures, self.series, strict=True)
            if measure.is_series
        }


class RunRequest(NamedTuple):
    """A run that is asked of a process."""

    spec: Spec
    recording: str = ""
    """The file to record it to; empty: none."""
    every: int = 1
    """Ticks between two frames of it."""


@dataclass(frozen=True)
class StopCondition:
    """When a run is over before its last tick."""

    says: ObservableBound
    hold: int
    every: int


@dataclass
class SweepJob:
    """How the runs of a sweep are made: the same for all of them."""

    ticks: int
    measures: tuple[SweepMeasure, ...]
    until: StopCondition | None = None
    getters: list[Callable[[Flock], float]] = field(default_factory=list)
    flocks: FlockPool = field(default_factory=FlockPool, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        """Without what a process makes for itself."""
        return self.__dict__ | {"getters": []}

    def prepare(self) -> None:
        """Find what measures. Raises InputError."""
        self.getters = [measure.getter() for measure in self.measures]

    @property
    def columns(self) -> list[str]:
        """What a run has one value of."""
        stops = [K] if self.until else []
        return stops + [measure.column for measure in self.measures if not measure.is_series]

    @property
    def names(self) -> list[str]:
        """Of all that is measured, series too."""
        return self.columns + [measure.column for measure in self.measures if measure.is_series]

    @property
    def window(self) -> int:
        """Ticks at the end at each of which something is measured."""
        return max((measure.over or 0 for measure in self.measures), default=0)

    def run(self, request: RunRequest, seed: int) -> Outcome:
        """Make a run."""
        spec = request.spec
        with self.flocks.begin(spec, seed, lambda: Flock(spec.but(seed=seed))) as flock:
            return self.run_flock(flock, request)

    def run_flock(self, flock: Flock, request: RunRequest) -> Outcome:
        """Run a flock to its end."""
        looks = RunObserver(self.measures, self.getters)
        k: int | None = None
        astray: list[str] = []

        def glance() -> None:
            stop_if_unwanted()
            stray_agents = None if astray else flock.stray()
            if stray_agents is not None:
                astray.append(str(stray_agents))

        with ExitStack() as stack:
            frame: Callable[[], None] | None = None
            if request.recording:
                frame = stack.enter_context(recorder(request.recording, flock)).write
            until = self.until
            if until is not None and self.is_compiled(flock) and frame is None:
                bound, hold = until.says.bound, until.hold
                k = flock.run_until_consistent(self.ticks, bound, hold, between=glance)
            else:
                k = self.run_observed(flock, looks, glance, frame, request.every)
            glance()
            values = looks.values(flock)
        if self.until:
            values[K] = k
        status: Status = "gave-up" if self.until and k is None else "ok"
        return Outcome(
            status,
            values,
            ticks=flock.tick,
            astray="".join(astray),
            series=looks.series_by_column(),
        )

    def try_out(self, flock: Flock) -> None:
        """Call once whatever measures, so that it is compiled; the flock may be used up."""
        flock.run(1)
        for get in self.getters:
            get(flock)
        if self.until:
            flock.observe(self.until.says.name)
            if self.is_compiled(flock):
                flock.run_until_consistent(2, self.until.says.bound, 1)

    def is_compiled(self, flock: Flock) -> bool:
        """Whether the compiled loop itself can tell when to stop, and nobody else has to look."""
        if self.until is None or self.until.every > 1 or flock.can_crash:
            return False
        says, inside = self.until.says, 0.0 < self.until.says.bound < 1.0
        looked = any(measure.is_series or measure.over for measure in self.measures)
        return (says.name, says.sign) == ("consistency", ">=") and inside and not looked

    def run_observed(
        self,
        flock: Flock,
        looks: RunObserver,
        glance: Callable[[], None],
        frame: Callable[[], None] | None,
        frames: int,
    ) -> int | None:
        """Run to the end, stopping wherever somebody has to look; the tick from which it held."""
        steps = [measure.every for measure in self.measures if measure.every]
        windows_from = 0 if self.until else self.ticks - self.window
        since: int | None = None
        if frame:
            frame()
        while True:
            now = flock.tick
            if self.until and now < self.ticks and now % self.until.every == 0:
                if self.until.says.holds(float(flock.observe(self.until.says.name))):
                    since = now if since is None else since
                    if now - since + 1 >= self.until.hold:
                        break
                else:
                    since = None
            if now >= self.ticks:
                since = None
                break
            nexts = [self.ticks, *(next_multiple(now, step) for step in steps)]
            if self.window:
                nexts.append(max(now, windows_from) + 1)
            if self.until:
                nexts.append(next_multiple(now, self.until.every))
            if frame:
                nexts.append(next_multiple(now, frames))
            run_ticks(flock, min(nexts) - now)
            if flock.world.is_solid:
                glance()
            looks.look(flock, bool(self.window) and flock.tick > windows_from)
            if frame and (flock.tick % frames == 0 or flock.tick == self.ticks):
                frame()
        if frame and flock.tick % frames and flock.tick < self.ticks:
            frame()
        return since if self.until else None


def next_multiple(now: int, step: int) -> int:
    """The next multiple of a step."""
    return (now // step + 1) * step


def recorder(path: str, flock: Flock) -> Recorder:
    """A recorder; what a kill has left of the same run is made anew."""
    place = Path(path)
    place.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileNotFoundError):
        place.with_name(place.name + ".part").unlink()
    return Recorder(place, flock, overwrite=True)
