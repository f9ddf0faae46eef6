"""The run of tracks: individuals seen and not seen, and a model that started among them."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.inspection import Inspection
from agents.observables.catalogue import OBSERVABLES, is_compared, is_tracked
from agents.snapshot import Snapshot
from app.tracks.playing.played_tracks import FEWEST, PlayedFlock, TracksSnapshot
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.time_series import TimeSeries, refuse_too_dense
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.frame_builder import FrameBuilder, FrameRequest
from app.viewer.run.paired_run import naming_errors
from app.viewer.run.playback import Playback, restore_snapshot
from app.viewer.run.stored_tracks import ModelFlock, StoredTracks
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError

WITHIN = "within"
"""The one parameter of tracks that is not the file's: how far neighbours are."""
OF_FEW = frozenset(
    name for name, one in OBSERVABLES.items() if one.applies in (is_tracked, is_compared)
)
"""What says something of few individuals too."""
MEMORY = 64 * 2**20
"""Bytes of a model's earlier ticks that are kept, to go back to."""
FAR = 0.25
"""The share of the tracks that is left out at once, from which on curves have a gap there."""
KEPT = 20
"""Ticks of the tracks between two that are kept, at first."""
LONGEST = 1.0
"""Seconds for which a model is run at once, to come to where the time line was moved: commands wait
for it."""


@dataclass
class TracksReadings(FlockReadings):
    """What is measured of tracks: nothing of order where too few are seen."""

    @property
    def too_few(self) -> bool:
        """Whether fewer are seen now than order takes, of tracks that have as many."""
        seen = self.flock.seen
        return seen is not None and len(seen) >= FEWEST and int(seen.sum()) < FEWEST

    def blank(self, values: dict[str, float]) -> dict[str, float]:
        """The values without those that say nothing of so few."""
        if not self.too_few:
            return values
        return {name: value for name, value in values.items() if name in OF_FEW}

    def read_cheap(self) -> None:
        """Read what is cheap."""
        super().read_cheap()
        self.values = self.blank(self.values)

    def series(self, name: str) -> TimeSeries:
        """How an observable went, with gaps."""
        return self.all_series.setdefault(name, TimeSeries(gaps=True))

    def add_values(self, tick: int, values: dict[str, float]) -> None:
        """Take values into their time series; where too few are seen there is a gap."""
        missing = dict.fromkeys(values, math.nan)
        super().add_values(tick, missing | self.blank(values))

    def break_curves(self, tick: int) -> None:
        """Have curves end at a tick: what comes next is far from it."""
        for series in self.all_series.values():
            series.add(tick, math.nan)


@dataclass
class TracksCamera(FrameBuilder):
    """Takes frames of tracks."""

    stored: StoredTracks | None = None

    def build(self) -> Frame:
        """A frame that says who is seen."""
        frame = super().build()
        assert self.stored is not None
        played, flock = self.stored.recording, self.flock
        return replace(
            frame,
            seen=flock.seen,
            hollow=flock.hollow,
            names=played.tracks.ids,
            usual=played.usual,
            apart=played.spacing,
            length_unit=played.length_unit,
        )

    def inspect(self) -> None:
        """Tell what is known of the wanted individual."""
        row, self.inspected = self.wanted.row, None
        if row is not None and 0 <= row < len(self.flock.ids):
            self.inspected = self.inspection(row)

    def inspect_others(self, at_once: bool = False) -> None:  # noqa: ARG002 - it takes no time
        """The same of individuals that other pages inspect."""
        rows = [row for row in self.wanted.others if 0 <= row < len(self.flock.ids)]
        self.others = {row: self.inspection(row) for row in rows}

    def inspection(self, row: int) -> Inspection:
        """What is known of an individual."""
        assert self.stored is not None
        played, nobody = self.stored.recording, np.empty(0, int)
        return Inspection(
            int(self.flock.ids[row]), row, nobody, np.empty((0, self.flock.world.dim)),
            np.empty(0), {}, model=self.flock.model, name=played.tracks.ids[row],
            known=played.describe(row, self.flock.tick),
        )  # fmt: skip


class TracksRun(Playback):
    """The run of tracks. Nothing in it can be changed but what counts as near."""

    flock: PlayedFlock
    stored: StoredTracks

    def __init__(
        self,
        flock: Flock,
        number: int,
        request: FrameRequest,
        watched: frozenset[str],
        stored: StoredTracks,
    ):
        super().__init__(flock, number, request, watched, stored)
        self.readings = TracksReadings(flock, watched)
        self.readings.extremes.keeps = False
        self.camera = TracksCamera(flock, number, request, stored=stored)
        if stored.begins is not None:
            self.show(min(max(stored.begins, self.first), self.last))

    def show(self, tick: int) -> None:
        """Put everybody where they were seen at a tick, or last before it."""
        then = self.frames.last_tick_until(tick)
        if then != self.flock.tick:
            snapshot: TracksSnapshot = self.frames.at(then)
            restore_snapshot(self.flock, snapshot)
            self.flock.seen, self.flock.hollow = snapshot.seen, snapshot.hollow
        self.clock = tick

    def seek(self, tick: int) -> None:
        """Go to a tick; curves have a gap where much is left out."""
        before = self.flock.tick
        super().seek(tick)
        if self.flock.tick - before > FAR * (self.last - self.first):
            for run in self.both:
                if isinstance(run.readings, TracksReadings):
                    run.readings.break_curves(before + 1)

    def demand_change(self, name: str = "", beside: bool = False) -> None:
        """Raise InputError for a change of anything but what counts as near."""
        if name != WITHIN or beside:
            raise InputError(
                f"{self.stored.name} is a file of tracks, in which nothing can be changed: "
                "'Start a model here', in the tab Tracks, begins a model from its places"
            )

    def spec(self) -> bytes:
        """Raise InputError: there is none."""
        raise InputError(f"{self.stored.name} is a file of tracks: there is no spec of a run")

    def save(self) -> bytes:
        """Raise InputError: it is on the disk already."""
        raise InputError(
            f"{self.stored.name} is a file of tracks: there is no state of a run; "
            "`flockscope tracks convert` writes it in other formats"
        )


class ModelBesideTracks(TracksRun):
    """Tracks, and the run of a model that started in one of their frames.

    Time goes by the tracks. The model has as many ticks behind it as go into that time; to go back
    it is taken to an earlier tick that was kept, and run from there, with its parameters as they
    are now.
    """

    second: FlockRun

    def __init__(
        self,
        flock: Flock,
        second: ModelFlock,
        number: int,
        request: FrameRequest,
        watched: frozenset[str],
        stored: StoredTracks,
    ):
        assert stored.start is not None
        refuse_too_dense(second)
        self.begins = int(stored.recording.ticks[stored.recording.index_until(stored.start.tick)])
        super().__init__(flock, number, request, watched, stored)
        self.model = second
        self.second = FlockRun(second, number, FrameRequest(), watched)
        self.origin = second.tick
        """The tick of the model at which it started."""
        self.kept: list[tuple[int, Snapshot]] = [(self.begins, second.snapshot())]
        """The model at some ticks of the tracks, rising."""
        self.apart = KEPT
        self.pair()
        self.set_request(request)

    @property
    def first(self) -> int:
        """The tick at which the model starts: there is none before."""
        return self.begins

    @property
    def is_ready(self) -> bool:
        """Whether all that the model calls has been compiled, or is on disk."""
        return self.second.is_ready

    @property
    def is_compiled(self) -> bool:
        """Whether the next tick of the model need not be compiled."""
        return self.second.compiled

    @property
    def computed(self) -> tuple[FlockRun, ...]:
        """The model's run."""
        return (self.second,)

    @property
    def beside_values(self) -> dict[str, Any]:
        """The parameters of the model."""
        return self.second.values

    def set_request(self, request: FrameRequest) -> None:
        """Change what frames hold; only the flock that is meant is looked at from close."""
        nobody = replace(request, row=None)
        self.camera.set_request(nobody if request.beside else request)
        second = request if request.beside else nobody
        self.second.camera.set_request(replace(second, others=request.others_beside))

    def model_tick(self, tick: int) -> int:
        """The tick of the model that goes with one of the tracks."""
        assert self.stored.start is not None
        seconds = (tick - self.begins) * self.stored.recording.time_per_tick
        return self.origin + int(seconds * self.stored.start.ticks_per_second + 1e-6)

    def show(self, tick: int) -> None:
        """Bring tracks and model to a tick of the tracks, or as far as the model comes in a second:
        others wait."""
        if self.second is not None:
            with naming_errors(self.model):
                tick = self.bring_model(tick)
        super().show(tick)
        if self.second is not None:
            self.pair()

    def bring_model(self, tick: int) -> int:
        """Bring the model to a tick of the tracks; the tick that it has come to."""
        end, now = time.perf_counter() + LONGEST, self.clock
        if tick < now:
            now = self.take_back(tick)
        while now < tick:
            now = min(tick, now + KEPT)
            self.second.advance(self.model_tick(now) - self.model.tick)
            if now - self.kept[-1][0] >= self.apart:
                self.keep(now)
            if time.perf_counter() > end:
                break
        return now

    def take_back(self, tick: int) -> int:
        """Take the model to the last kept tick that is not after one; it keeps its parameters."""
        then, snapshot = next(kept for kept in reversed(self.kept) if kept[0] <= tick)
        now = self.model.parameters.model_dump()
        self.model.return_to(snapshot)
        if self.model.parameters.model_dump() != now:
            self.model.set(**now)
        self.second.readings.cut(self.model.tick)
        return then

    def keep(self, tick: int) -> None:
        """Keep the model as it is at a tick, and of too many such moments every other."""
        self.kept.append((tick, self.model.snapshot()))
        size = sum(array.nbytes for array in self.kept[0][1].arrays)
        if len(self.kept) * size > MEMORY and len(self.kept) > 2:
            self.kept = self.kept[::2]
            self.apart *= 2

    def pair(self) -> None:
        """Tell the tracks where the counterparts of individuals are."""
        rows = self.model.rows
        paired = np.full(self.flock.position.shape, np.nan)
        paired[rows] = self.model.position
        self.flock.paired = paired

    def look(self, closely: bool, measured: bool = True) -> Frame:
        """A frame of the tracks that holds one of the model; raises as `FlockRun.look`."""
        frame = super().look(closely, measured)
        with naming_errors(self.model):
            other = self.second.look(closely, measured)
        for trouble in self.second.troubles:
            if repr(trouble) not in map(repr, self.troubles):
                self.troubles.append(trouble)
        assert self.stored.start is not None
        is_over = self.stored.start.is_over
        dt, unit = self.model.clock
        other = replace(
            other,
            title=self.model.model.title,
            dt=dt,
            unit=unit,
            usual=frame.usual,
            apart=frame.apart,
        )
        return replace(frame, title=self.flock.model.title, beside=other, is_over=is_over)

    def allowed(self, name: str, value: Any, beside: bool = False) -> Any:
        """The value nearest to the wanted one that keeps zones in order."""
        return self.second.allowed(name, value) if beside else super().allowed(name, value)

    def set(self, name: str, value: Any, beside: bool = False) -> None:
        """Give a parameter of the model, or what counts as near, a value. Raises InputError."""
        if beside:
            with naming_errors(self.model):
                self.second.set(name, value)
        else:
            super().set(name, value)

    def demand_change(self, name: str = "", beside: bool = False) -> None:
        """Raise InputError for a change of the tracks."""
        if not (beside and name):
            super().demand_change(name, beside)

    def spec(self) -> bytes:
        """The spec of the model as TOML."""
        return self.second.spec()

    def save(self) -> bytes:
        """The state of the model as a file."""
        return self.second.save()
