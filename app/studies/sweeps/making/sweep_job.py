"""One run of a sweep: from its spec and its seed to an outcome; what the processes are given."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from agents.flock import Flock
from agents.record import Recorder
from agents.spec import Spec
from app.studies.runs.run_outcome import Outcome, Status
from app.studies.sweeps.given.sweep_conditions import ObservableBound
from app.studies.sweeps.making.measures import K, RunObserver, SweepMeasure


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

    def __getstate__(self) -> dict[str, Any]:
        """Without what a process makes for itself."""
        return self.__dict__ | {"getters": []}

    def prepare(self) -> None:
        """Find what measures. Raises InputError."""
        self.getters = [one.getter() for one in self.measures]

    @property
    def columns(self) -> list[str]:
        """What a run has one value of."""
        stops = [K] if self.until else []
        return stops + [one.column for one in self.measures if not one.is_series]

    @property
    def names(self) -> list[str]:
        """Of all that is measured, series too."""
        return self.columns + [one.column for one in self.measures if one.is_series]

    @property
    def window(self) -> int:
        """Ticks at the end at each of which something is measured."""
        return max((one.over or 0 for one in self.measures), default=0)

    def run(self, wanted: RunRequest, seed: int) -> Outcome:
        """Make a run."""
        flock = Flock(wanted.spec.but(seed=seed))
        looks = RunObserver(self.measures, self.getters)
        k: int | None = None
        astray: list[str] = []

        def glance() -> None:
            found = None if astray else flock.stray()
            if found is not None:
                astray.append(str(found))

        with ExitStack() as stack:
            frame: Callable[[], None] | None = None
            if wanted.recording:
                frame = stack.enter_context(recorder(wanted.recording, flock)).write
            if self.is_compiled(flock) and frame is None:
                assert self.until is not None
                bound, hold = self.until.says.bound, self.until.hold
                k = flock.run_until_consistent(self.ticks, bound, hold, between=glance)
            else:
                k = self.look_on(flock, looks, glance, frame, wanted.every)
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
            series=looks.along(),
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
        looked = any(one.is_series or one.over for one in self.measures)
        return (says.name, says.sign) == ("consistency", ">=") and inside and not looked

    def look_on(
        self,
        flock: Flock,
        looks: RunObserver,
        glance: Callable[[], None],
        frame: Callable[[], None] | None,
        frames: int,
    ) -> int | None:
        """Run to the end, stopping wherever somebody has to look; the tick from which it held."""
        steps = [one.every for one in self.measures if one.every]
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
            nexts = [self.ticks, *(following(now, step) for step in steps)]
            if self.window:
                nexts.append(max(now, windows_from) + 1)
            if self.until:
                nexts.append(following(now, self.until.every))
            if frame:
                nexts.append(following(now, frames))
            flock.run(min(nexts) - now)
            if flock.world.is_solid:
                glance()
            looks.look(flock, bool(self.window) and flock.tick > windows_from)
            if frame and (flock.tick % frames == 0 or flock.tick == self.ticks):
                frame()
        if frame and flock.tick % frames and flock.tick < self.ticks:
            frame()
        return since if self.until else None


def following(now: int, step: int) -> int:
    """The next multiple of a step."""
    return (now // step + 1) * step


def recorder(path: str, flock: Flock) -> Recorder:
    """A recorder; what a kill has left of the same run is made anew."""
    place = Path(path)
    place.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileNotFoundError):
        place.with_name(place.name + ".part").unlink()
    return Recorder(place, flock, overwrite=True)
