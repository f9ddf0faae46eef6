"""What a measure of tracks is: what it needs, what it costs, and what it comes to."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from agents.observables.neighbours import tree
from app.studies.charts.array_charts import draw_time_series
from app.studies.measure import UNBOUNDED, MeasureBounds
from app.tracks.motion import SmoothedMotion
from app.tracks.tracks import Tracks

LEAST = 5
"""Individuals that a frame's value is of, at least."""
UNEVEN = 1.5
"""By what factor the number of individuals may change without a word."""
Progress = Callable[[float], None]
"""Is told the share that is done, in [0, 1]."""


@dataclass(frozen=True)
class MeasureOptions:
    """What a user may choose of all measures; None takes what is said beside the result."""

    least: int = LEAST
    """Individuals that a frame's value is of, at least."""
    reach: float | None = None
    """Length within which individuals are of one group."""
    map_reach: float | None = None
    """Half the side of the neighbour map, length."""
    longest_delay: float = 2.0
    """s, up to which followers are looked for."""
    neighbours: int = 20
    """Up to which neighbour the structure is measured."""
    walkable: str = ""
    """Where people can walk, WKT in metres; what the file says, if it does."""
    area: str = ""
    """Of which density is measured, WKT, convex; the walkable area if it is convex."""
    line: str = ""
    """Across which flow is counted, WKT."""


@dataclass(frozen=True, eq=False)
class MeasureInput:
    """Tracks, how they move, and what was chosen."""

    tracks: Tracks
    motion: SmoothedMotion
    options: MeasureOptions = MeasureOptions()

    @cached_property
    def images(self) -> np.ndarray:
        """(dim,) bool, the axes that are seen across the seam."""
        period = self.tracks.period or (0.0,) * self.tracks.dim
        return np.array(period) > 0.0

    @cached_property
    def size(self) -> np.ndarray:
        """(dim,) sides of the box; along other axes a length that is large enough."""
        low, high = self.tracks.extent
        wide = np.maximum(2.0 * np.abs(np.stack([low, high])).max(axis=0), 1e-9)
        return np.where(self.images, self.tracks.period or wide, wide)

    @cached_property
    def spacing(self) -> float:
        """Median distance to the nearest neighbour over at most 200 frames, length; NaN if nobody
        ever has one."""
        frames = np.unique(np.linspace(0, len(self.tracks.frame) - 1, 200).astype(int))
        near = []
        for t in frames:
            places = self.tracks.position[t][self.tracks.seen[t]]
            if len(places) > 1:
                known = tree(places, self.size, self.images)
                near.append(known.query(known.data, 2)[0][:, 1])
        return float(np.median(np.concatenate(near))) if near else math.nan

    @cached_property
    def unit(self) -> str:
        """Of lengths."""
        return self.tracks.unit

    def by_frame(
        self, measure: Callable[..., float], *arrays: np.ndarray, progress: Progress | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """A number for each frame from the rows (n, ...) of arrays (T, N, ...) that are there.

        Returns values (T,), NaN below `least` individuals, and how many they are of, int (T,).
        """
        there = np.logical_and.reduce([np.isfinite(a).all(axis=2) for a in arrays])
        count = there.sum(axis=1)
        values = np.full(len(count), np.nan)
        for t in np.flatnonzero(count >= max(self.options.least, 1)):
            rows = there[t]
            values[t] = measure(*(a[t] if count[t] == len(rows) else a[t][rows] for a in arrays))
            if progress is not None and t % 64 == 0:
                progress((t + 1) / len(count))
        return values, count


@dataclass(frozen=True)
class MeasureChart:
    """A chart that is not drawn yet."""

    x: str
    y: str
    draw: Callable[[Any], None]
    """Takes the axes of a figure of matplotlib."""
    title: str = ""
    is_square: bool = False


@dataclass(frozen=True)
class MeasureResult:
    """What a measure comes to."""

    numbers: Mapping[str, float]
    """Name -> value; the unit stands in the name's brackets, if it has one."""
    tables: Mapping[str, Mapping[str, np.ndarray]] = field(default_factory=dict)
    """Name of a file -> its columns; "" is the measure's own name."""
    charts: tuple[MeasureChart, ...] = ()
    notes: tuple[str, ...] = ()
    """Sentences: what is not resolved, what was chosen, what was left out."""


@dataclass(frozen=True)
class TrackMeasure:
    """One thing that is measured of tracks, and what others have to know of it."""

    name: str
    title: str
    source: str
    """Paper or package."""
    compute: Callable[[MeasureInput, Progress], MeasureResult]
    cost: Callable[[int, int], float] = lambda frames, n: 2e-5 * frames + 1e-8 * frames * n
    """About how many seconds it takes, of so many frames and individuals seen in each."""
    lacks: Callable[[MeasureInput], str] = lambda _: ""
    """What is missing to measure these tracks, as half a sentence; "" if nothing is."""
    by_frame: str = ""
    """The unit of its values by frame, `{u}` for that of lengths; "" if it has none by frame."""


def needs_plane(given: MeasureInput) -> str:
    """What is missing where a measure is of tracks in the plane alone."""
    return "" if given.tracks.dim == 2 else "tracks in the plane are needed, these are in space"


def needs_neighbours(given: MeasureInput) -> str:
    """What is missing where lengths are chosen by the distance to the nearest neighbour."""
    return "" if given.spacing > 0.0 else "two individuals in one frame are needed, apart"


def needs_neighbours_in_plane(given: MeasureInput) -> str:
    """The same of tracks in the plane alone."""
    return needs_plane(given) or needs_neighbours(given)


def describe_values(values: np.ndarray) -> dict[str, float]:
    """Mean, spread and quantiles of those values that are numbers; nothing of none."""
    values = values[np.isfinite(values)]
    if not len(values):
        return {"values": 0}
    low, median, high = np.quantile(values, (0.05, 0.5, 0.95))
    return {
        "mean": float(values.mean()),
        "standard deviation": float(values.std()),
        "5 %": float(low),
        "median": float(median),
        "95 %": float(high),
    }


def frame_series(
    given: MeasureInput,
    name: str,
    unit: str,
    values: np.ndarray,
    count: np.ndarray,
    bounds: MeasureBounds = UNBOUNDED,
    level: float | None = None,
) -> MeasureResult:
    """What a number for each frame comes to: itself with the number seen, mean and spread.

    `values` and `count` are (T,); `level` is a value to compare with.
    """
    has_value = np.isfinite(values)
    frames = int(has_value.sum())
    numbers = describe_values(values) | {"frames": frames}
    notes = []
    few = int((count < given.options.least).sum())
    if few:
        notes.append(
            f"{few} of {len(count)} frames have no value: fewer than {given.options.least} "
            "individuals are seen in them"
        )
    if frames:
        low, high = int(count[has_value].min()), int(count[has_value].max())
        numbers |= {"least number seen": low, "largest number seen": high}
        if high > UNEVEN * low:
            notes.append(
                f"between {low} and {high} individuals are seen: the mean is over frames of very "
                "different numbers, see the curve beside it"
            )
    unit = unit.format(u=given.unit)
    label = name if unit in ("", "1") else f"{name} ({unit})"
    time = given.tracks.time

    def draw(axes: Any) -> None:
        draw_time_series(axes, time, values, count, bounds, level)

    columns = {
        "frame": given.tracks.frame,
        "time": time,
        "n": count,
        name.replace(" ", "_").replace("-", "_"): values,
    }
    return MeasureResult(
        numbers, {"": columns}, (MeasureChart("time (s)", label, draw),), tuple(notes)
    )


def distribution_chart(
    values: np.ndarray, label: str, bins: int = 60
) -> tuple[Mapping[str, np.ndarray], MeasureChart]:
    """The distribution of values as a table and a chart; the highest 0.1 % are in the last bin."""
    from app.studies.charts.array_charts import draw_distribution

    values = values[np.isfinite(values)]
    high = float(np.quantile(values, 0.999)) if len(values) else 1.0
    edges = np.linspace(0.0, high or 1.0, bins + 1)
    many = np.histogram(np.minimum(values, edges[-1]), edges)[0]
    share = many / max(len(values), 1)
    columns = {"from": edges[:-1], "to": edges[1:], "number": many, "share": share}
    return columns, MeasureChart(label, "share", lambda axes: draw_distribution(axes, edges, share))
