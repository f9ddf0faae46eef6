"""Tracks as snapshots of a flock at ticks, with the same attributes as a recording of a run."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from agents.catalogue import model as find_model
from agents.engine.arrays import Arrays
from agents.flock import Flock
from agents.flock_world import complete_spec
from agents.models.model import Model
from agents.observables.neighbours import nearest_neighbour
from agents.snapshot import Snapshot
from agents.spec import CompleteSpec, Spec
from agents.state.agent_rows import select_rows
from app.tracks.playing.track_headings import headings_and_speeds
from app.tracks.playing.tracks_world import world_of_tracks
from app.tracks.tracks import PIXELS, Tracks
from worlds.input_error import InputError

IN_METRES, IN_PIXELS, IN_LENGTHS = "tracks", "tracks-px", "tracks-lengths"
"""The models of tracks, by the unit of their lengths."""
MOST_NUMBERS = 30_000_000
"""Numbers of a table of positions that are played at most: places, headings and speeds of them are
kept, 1 GB."""
MOST_INDIVIDUALS = 20_000
"""Individuals that are played at most: each has a row all the time."""
LONGEST_GAP = 2.0, 50
"""How long an individual that is not seen is drawn at its last place: s, or frames if longer."""
FEWEST = 5
"""Individuals seen below which order says nothing: random headings of n have order 1/sqrt(n)."""
SAMPLED = 50
"""Frames of which the spacing is taken."""
GROUPED = 2.0
"""Within how many times their spacing individuals count as neighbours."""
MOST_TICKS = 2**40
"""Ticks at most: where places are rare, and never evenly apart, ticks are longer."""


@dataclass(frozen=True, eq=False)
class TracksSnapshot(Snapshot):
    """Tracks at one frame, a row for each individual of the file, seen or not."""

    seen: np.ndarray | None = None
    hollow: np.ndarray | None = None
    paired: np.ndarray | None = None
    usual: int = 0
    apart: float = math.inf

    def measurable(self) -> Snapshot:
        """Those that are seen."""
        assert self.seen is not None
        return self if self.seen.all() else self.of(np.flatnonzero(self.seen))

    def of(self, rows: np.ndarray) -> Snapshot:
        """The individuals of some rows, as if there were no others."""
        columns: dict[str, Any] = {
            name: None if getattr(self, name) is None else getattr(self, name)[rows]
            for name in ("seen", "hollow", "paired")
        }
        return replace(
            self, arrays=select_rows(self.arrays, rows), whole=self.whole or self, **columns
        )

    def links(self) -> np.ndarray:
        """Pairs of rows (i < j) of those seen that are within reach, int (M, 2)."""
        assert self.seen is not None
        if self.seen.all():
            return super().links()
        return np.flatnonzero(self.seen)[self.measurable().links()]

    def group_labels(self) -> np.ndarray:
        """The group of each individual, int (N,); those not seen are of the last."""
        assert self.seen is not None
        if self.seen.all():
            return super().group_labels()
        labels = np.full(len(self.seen), max(int(self.seen.sum()) - 1, 0))
        labels[self.seen] = self.measurable().group_labels()
        return labels


class PlayedFlock(Flock):
    """A flock that is put where individuals were seen; it is never run."""

    seen: np.ndarray | None = None
    hollow: np.ndarray | None = None
    paired: np.ndarray | None = None

    @property
    def warning(self) -> str:
        """Nothing: where somebody was seen, there he was."""
        return ""

    def snapshot(self, copy: bool = True, signals: bool = False) -> Snapshot:
        """The individuals frozen as they are now; see `agents.motion.motion.Motion.snapshot`."""
        arrays = Arrays._make(map(np.array, self.arrays)) if copy else self.arrays
        seen = np.ones(len(self.ids), bool) if self.seen is None else self.seen
        return TracksSnapshot(
            self.model, self.world, self.parameters, self.seed, self.tick, arrays, self.next_id,
            signals, seen=seen, hollow=self.hollow, paired=self.paired,
        )  # fmt: skip

    def return_to(self, past: Snapshot) -> None:
        """Be as the snapshot of a frame is."""
        super().return_to(past)
        self.seen, self.hollow = past.seen, past.hollow


class PlayedTracks:
    """Tracks, of which a snapshot can be taken at every frame.

    Lengths are metres, or pixels where nobody has said how large one is; with `length`, that many
    metres or pixels are one length. `window`, s: over which headings and speeds are smoothed, by
    default five frames. Raises InputError for tracks that are too large.

    Attributes
    ----------
    name: the file's. tracks: `Tracks`, as they are played. spec: CompleteSpec, model: Model and
    world: World, as a recording has them. ticks: (T,) int, those of the frames, rising. A tick is
    `time_per_tick` long, in `time_unit`, which is s; lengths are in `length_unit`.
    place, heading: (T, N, dim); speed: (T, N), length/s. An individual that is not seen has its
    last place and heading, or its first before that. since: (T, N), s since it was last seen, inf
    where it was not seen yet. in_gap: (T, N) bool, whether it is not seen now, and was before and
    is afterwards.
    """

    time_unit = "s"

    def __init__(self, tracks: Tracks, length: float = 1.0, window: float | None = None):
        if not 0.0 < length < math.inf:
            raise InputError(f"length = {length:g} is not allowed: it is above 0")
        frames, count, dim = tracks.position.shape
        if tracks.position.size > MOST_NUMBERS or count > MOST_INDIVIDUALS:
            raise InputError(
                f"{tracks.name}: {count} individuals in {frames} frames are too many to be played: "
                f"at most {MOST_INDIVIDUALS} individuals and {MOST_NUMBERS // dim} places; read "
                "some of the frames, with --frames or --every"
            )
        self.name = tracks.name
        self.tracks = tracks = tracks if tracks.unit == PIXELS else tracks.in_metres()
        self.length = length
        kind = IN_PIXELS if tracks.unit == PIXELS else IN_METRES
        self.model: Model = find_model(kind if length == 1.0 else IN_LENGTHS)
        self.world = world_of_tracks(tracks, 1.0 / length)
        self.ticks, self.time_per_tick = ticks_of(tracks.time)
        self.seen = tracks.seen
        self._fill(window)
        self.spacing = self._spacing()
        parameters = {"within": GROUPED * self.spacing, "frame_time": self.time_per_tick}
        self.spec: CompleteSpec = complete_spec(
            Spec(
                self.model.name, world=self.world, agents=count, dim=dim, seed=1,
                parameters=parameters,
            ),
            self.model,
        )  # fmt: skip
        self._parameters = self.model.parameters(**parameters)
        self.frames = self

    def __repr__(self) -> str:
        return f"<PlayedTracks {self.name}, {self.count} individuals, {len(self.ticks)} frames>"

    @property
    def count(self) -> int:
        """Individuals, seen or not."""
        return self.seen.shape[1]

    @property
    def length_unit(self) -> str:
        """m, px or length."""
        return self.model.in_units("length")

    @property
    def title(self) -> str:
        """What a picture is called."""
        return self.name

    @property
    def starts(self) -> np.ndarray:
        """(T,), where rows of a frame would begin in a table with a row for each individual."""
        return np.arange(len(self.ticks)) * self.count

    @property
    def ends(self) -> np.ndarray:
        """(T,), behind the last of them."""
        return self.starts + self.count

    def last_tick_until(self, tick: float) -> int:
        """The last tick of a frame that is not after one; the first of all before that."""
        return int(self.ticks[self.index_until(tick)])

    def index_until(self, tick: float) -> int:
        """The place of that frame."""
        return max(0, int(np.searchsorted(self.ticks, tick, side="right")) - 1)

    def at(self, tick: int | None = None) -> TracksSnapshot:
        """The individuals at the tick of a frame, by default the last. Raises InputError."""
        k = len(self.ticks) - 1 if tick is None else self.index_until(tick)
        if tick is not None and self.ticks[k] != tick:
            raise InputError(f"tick = {tick} is not in {self.name}")
        n = self.count
        arrays = Arrays(
            np.array(self.place[k]),
            np.array(self.heading[k], float),
            np.array(self.speed[k], float),
            np.zeros(n, bool),
            np.arange(1, n + 1),
            np.zeros(n, np.int32),
            np.empty((0, n)),
            np.empty((0, 2 + self.world.dim)),
            np.empty((n, 0, 0)),
            own=np.empty((n, 0)),
        )
        return TracksSnapshot(
            self.model, self.world, self._parameters, 1, int(self.ticks[k]), arrays, n + 1, True,
            seen=self.seen[k], hollow=self.is_hollow(k), usual=self.usual,
            apart=self.spacing,
        )  # fmt: skip

    def is_hollow(self, k: int) -> np.ndarray:
        """Who is drawn at its last place in the frame at place k, (N,) bool."""
        longest = max(LONGEST_GAP[0], LONGEST_GAP[1] * self.time_per_tick)
        return self.in_gap[k] & (self.since[k] <= longest)

    def flock(self) -> PlayedFlock:
        """A flock as it is in the first frame."""
        now = self.at(int(self.ticks[0]))
        start = {"position": now.position, "heading": now.heading, "speed": now.speed}
        flock = PlayedFlock(self.spec, start=start)
        flock.return_to(now)
        return flock

    def _fill(self, window: float | None) -> None:
        """Give everybody a place, a heading and a speed at all times."""
        at = np.arange(len(self.ticks))[:, None]
        ever = self.seen.any(axis=0)
        last = np.maximum.accumulate(np.where(self.seen, at, -1), axis=0)
        first = np.argmax(self.seen, axis=0)
        known = np.where(last < 0, first, last)
        column = np.arange(self.count)
        time = self.tracks.time
        place = np.where(ever[:, None], self.tracks.position[known, column], self._middle)
        self.place = place / self.length
        self.since = np.where(last < 0, math.inf, time[:, None] - time[known])
        final = len(at) - 1 - np.argmax(self.seen[::-1], axis=0)
        self.in_gap = ~self.seen & (last >= 0) & (at < final)
        heading, speed = headings_and_speeds(self.tracks, window)
        self.heading = heading
        speed = speed / self.length
        self.speed = np.where(self.seen, speed, 0.0).astype(np.float32)

    @property
    def _middle(self) -> np.ndarray:
        low, high = self.tracks.extent
        return 0.5 * (low + high)

    def _spacing(self) -> float:
        """The median distance to the nearest other, length; of one individual a part of the box."""
        chosen = np.unique(np.linspace(0, len(self.ticks) - 1, SAMPLED).astype(int))
        apart: list[Any] = []
        for k in chosen.tolist():
            places = self.place[k][self.seen[k]]
            if len(places) > 1:
                apart.append(nearest_neighbour(places, self.world.size, self.world.images))
        found = np.concatenate(apart) if apart else np.empty(0)
        found = found[np.isfinite(found) & (found > 0.0)]
        return float(np.median(found)) if len(found) else 0.1 * float(max(self.world.size))

    @cached_property
    def usual(self) -> int:
        """How many are seen in a frame as a rule: nine frames of ten have no more."""
        return max(1, int(np.quantile(self.seen.sum(axis=1), 0.9)))

    @cached_property
    def median_speed(self) -> float:
        """The median speed of those seen, length/s; 0 of those that stand."""
        return float(np.median(self.speed[self.seen]))

    def gaps_of(self, row: int) -> int:
        """How many gaps an individual has between two times that it is seen."""
        return int(np.count_nonzero(np.diff(self.in_gap[:, row].astype(int)) == 1))

    def describe(self, row: int, tick: int) -> dict[str, str]:
        """What is to be known of an individual at a tick beside its place and speed, by words."""
        k = self.index_until(tick)
        share = float(self.seen[:, row].mean())
        now = "yes"
        if not self.seen[k, row]:
            since = self.since[k, row]
            now = f"no, {since:.3g} s ago" if math.isfinite(since) else "not yet"
            if math.isfinite(since) and not self.in_gap[k, row]:
                now = f"no, gone for {since:.3g} s"
        return {
            "seen now": now,
            "seen": f"{100.0 * share:.3g} % of frames",
            "gaps": str(self.gaps_of(row)),
        }


def ticks_of(time: np.ndarray) -> tuple[np.ndarray, float]:
    """The ticks (T,) of frames at times (T,), s, rising, and how long a tick is, s.

    A tick is the median step between frames; where that would put two frames on one tick, it is as
    short as the least step, within reason. Times before 0 are moved to begin there.

    >>> ticks_of(np.array([0.0, 0.04, 0.08, 0.2]))
    (array([0, 1, 2, 5]), 0.04)
    """
    if len(time) < 2:
        return np.zeros(len(time), int), 1.0
    steps = np.diff(time)
    begin = min(float(time[0]), 0.0)
    for step in (float(np.median(steps)), float(steps.min())):
        ticks = np.round((time - begin) / step)
        if (np.diff(ticks) > 0).all() and ticks[-1] < MOST_TICKS:
            return ticks.astype(int), round(step, 12)
    return np.arange(len(time)), round(float((time[-1] - time[0]) / (len(time) - 1)), 12)
