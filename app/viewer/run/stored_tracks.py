"""Tracks to play, by themselves or with a model that starts in one of their frames."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from agents.catalogue import model as find_model
from agents.flock import Flock
from agents.models.model import Model
from agents.snapshot import Snapshot
from agents.spec import CompleteSpec, Spec
from app.tracks.playing.played_tracks import PlayedTracks
from app.tracks.tracks import PIXELS
from app.viewer.editing.free_places import move_out
from worlds.input_error import InputError

SLOWEST = 4.0
"""Frames per second at least at which tracks are played at first: fixes of hours are not waited
for."""
TICKS_PER_SECOND = 1e-6, 1e4
"""Ticks of a model in a second of tracks: least and most."""
MOST_TICKS_OF_A_FRAME = 1000.0
"""Ticks of a model between two ticks of the tracks at most."""


@dataclass(frozen=True)
class ModelStart:
    """A model that starts where individuals of tracks are seen."""

    spec: Spec
    """The model, and the parameters that differ from its own."""
    tick: int
    """The tick of the tracks at which it starts."""
    ticks_per_second: float
    """How many of its ticks are a second of the tracks."""
    is_over: bool = False
    """Whether it is drawn over the tracks, as ghosts, and not beside them."""


@dataclass(frozen=True)
class StoredTracks:
    """Tracks that are played; with a `start` beside a model."""

    recording: PlayedTracks
    start: ModelStart | None = None
    begins: int | None = None
    """The tick that is shown first; None: that of the first frame."""
    is_played = True
    kind = "tracks"
    tick = None

    @property
    def name(self) -> str:
        """The file's name."""
        return self.recording.name

    @property
    def spec(self) -> CompleteSpec:
        """What is played, as a run."""
        return self.recording.spec

    @property
    def beside(self) -> Spec | None:
        """The model that starts in it."""
        return None if self.start is None else self.start.spec

    @property
    def speed(self) -> float:
        """Ticks per second at which time goes as it went, but not too slowly."""
        return max(1.0 / self.recording.time_per_tick, SLOWEST)

    @property
    def most(self) -> int:
        """Individuals that it has."""
        return self.recording.count

    @property
    def first(self) -> Snapshot:
        """The individuals as they begin."""
        ticks = self.recording.ticks
        return self.recording.at(int(ticks[0]))

    def flock(self, *_: Any, **__: Any) -> Flock:
        """A flock that is put where they were."""
        return self.recording.flock()

    def with_model(self, start: ModelStart) -> StoredTracks:
        """The same with a model that starts at one of its ticks."""
        return replace(self, start=start, begins=start.tick)

    def without_model(self, tick: int) -> StoredTracks:
        """The same tracks alone, from a tick on."""
        return replace(self, start=None, begins=tick)

    def going_on(self, tick: int) -> StoredTracks:
        """Raise InputError: tracks have no rule to go on by."""
        raise InputError(
            f"{self.name} cannot go on from {tick * self.recording.time_per_tick:.4g} s: tracks "
            "follow no rule; 'Start a model here', in the tab Tracks, starts one from their places"
        )

    def model_flock(self) -> ModelFlock:
        """The flock of its model as it starts. Raises InputError."""
        assert self.start is not None
        return start_model(self.recording, self.start)


class ModelFlock(Flock):
    """A flock that started where individuals of tracks were seen."""

    rows: np.ndarray
    """Of each of its agents the row of its individual, int (M,)."""
    clock: tuple[float, str]
    """How long a tick is in the time of the tracks, and in which unit."""
    moved: int = 0
    """How many of its agents start elsewhere, since their individual stands in something solid."""


def start_model(played: PlayedTracks, start: ModelStart) -> ModelFlock:
    """A flock with the places, headings and speeds of those seen at a tick. Raises InputError.

    Its agents have the numbers of their individuals. Bodies of one speed go at that; others begin
    at the speed of the tracks. Its first tick is numbered so that its time goes with that of the
    tracks.
    """
    model = find_model(start.spec.model)
    demand_ticks(played, model, start.ticks_per_second)
    then = played.at(int(played.ticks[played.index_until(start.tick)]))
    assert then.seen is not None
    rows = np.flatnonzero(then.seen)
    if not len(rows):
        raise InputError(
            f"nobody is seen at {start.tick * played.time_per_tick:.4g} s in {played.name}: "
            "move to a frame with individuals, then start the model"
        )
    world = played.world
    if world.dim not in model.dimensions:
        raise InputError(f"{model.title} is not defined in {world.dim} dimensions")
    position = move_out(world, then.position[rows])
    arrays = {"position": position, "heading": then.heading[rows]}
    if model.body.speed is None:
        per_tick = model.body.unit == "ticks"
        arrays["speed"] = then.speed[rows] / (start.ticks_per_second if per_tick else 1.0)
    spec = Spec(
        model.name, world=world, agents=len(rows), informed=0, seed=1,
        parameters=start.spec.all_parameters,
    )  # fmt: skip
    try:
        flock = ModelFlock(spec, start=arrays)
    except InputError as refusal:
        raise InputError(f"{model.title}: {refusal}") from None
    flock.ids[:] = rows + 1
    flock.next_id = played.count + 1
    flock.rows = rows
    flock.moved = int(np.count_nonzero((position != then.position[rows]).any(axis=1)))
    flock.clock = 1.0 / start.ticks_per_second, "s"
    flock.tick = round(then.tick * played.time_per_tick * start.ticks_per_second)
    return flock


def demand_ticks(played: PlayedTracks, model: Model, ticks_per_second: float) -> None:
    """Raise InputError for a number of ticks in a second of tracks that cannot be."""
    least, most = TICKS_PER_SECOND
    if not least <= ticks_per_second <= most:
        raise InputError(
            f"ticks per second = {ticks_per_second:g} is outside [{least:g}, {most:g}]"
        )
    if ticks_per_second * played.time_per_tick > MOST_TICKS_OF_A_FRAME:
        raise InputError(
            f"{model.title}: {ticks_per_second * played.time_per_tick:.4g} ticks between two "
            f"frames are too many: {MOST_TICKS_OF_A_FRAME:g} at most; give fewer ticks per second"
        )


def proposed_ticks(played: PlayedTracks, spec: Spec) -> float:
    """How many ticks of a model are a second of the tracks, unless somebody says otherwise.

    Of a model that counts seconds that is given. Of one whose agents all have one speed it is such
    that this is the median speed of the tracks, else each frame is a tick.
    """
    model = find_model(spec.model)
    parameters = model.parameters(**spec.parameters)
    if model.body.unit != "ticks":
        return 1.0 / float(model.body.lasts(parameters))
    frames = 1.0 / played.time_per_tick
    own = 0.0 if model.body.speed is None else float(model.body.speed(parameters))
    if own <= 0.0 or played.median_speed <= 0.0:
        return float(np.clip(frames, *TICKS_PER_SECOND))
    wanted = played.median_speed / own
    most = min(TICKS_PER_SECOND[1], MOST_TICKS_OF_A_FRAME * frames)
    return float(f"{min(max(wanted, TICKS_PER_SECOND[0]), most):.3g}")


def proposed_length(played: PlayedTracks) -> float:
    """How many metres or pixels of the tracks are one length of a model, unless somebody says.

    Metres stay metres. Of pixels it is the median distance to the nearest other.
    """
    if played.tracks.unit != PIXELS:
        return 1.0
    return float(f"{spacing_of(played):.3g}")


def spacing_of(played: PlayedTracks) -> float:
    """The median distance to the nearest other in the tracks' own unit."""
    spacing = played.spacing * played.length
    return spacing if math.isfinite(spacing) and spacing > 0.0 else 1.0
