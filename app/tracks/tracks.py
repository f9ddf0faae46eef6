"""Tracks: where individuals were, frame by frame, with gaps where they were not seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from worlds.input_error import InputError, shorten

if TYPE_CHECKING:
    import pandas as pd

UNITS = {"m": 1.0, "km": 1000.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
"""Metres in each unit of length."""
PIXELS = "px"
"""The unit of tracks that are in pixels of a video."""
MOST_PLACES = 100_000_000
"""Numbers of a table of positions (T, N, dim) at most: 0.8 GB."""
EVEN = 0.01
"""By which share of a frame's time the times of frames may differ from an even rate."""


@dataclass(frozen=True)
class DroppedRows:
    """Rows of a file that are not in its tracks."""

    rows: int
    reason: str

    def __str__(self) -> str:
        return f"{self.rows} rows dropped: {self.reason}"


@dataclass(frozen=True, eq=False)
class Tracks:
    """Where individuals were, frame by frame.

    Axes are right-handed, with y up: a reader turns what a video's file says from the top. Nothing
    is interpolated unless somebody asked for it, and `filled` then says where. Raises InputError
    for arrays that do not fit each other, or tell of no individual.
    """

    position: np.ndarray
    """(T, N, dim) float64, in `unit`; NaN where an individual is not seen."""
    frame: np.ndarray
    """(T,) int64, the frames' numbers in the file, rising."""
    time: np.ndarray
    """(T,) float64, s, rising; from the rate where a file has frames alone."""
    ids: tuple[str, ...]
    """(N,), each once."""
    unit: str
    """One of UNITS, or PIXELS."""
    name: str = "tracks"
    """The file's own name, without its folders, which may name people."""
    format: str = ""
    """The name of its reader."""
    period: tuple[float, ...] = ()
    """Sides (dim,) of the box that places are wrapped into, 0 along axes that do not wrap; empty
    for an open plane or space."""
    boundary: str = ""
    """What one can walk on, as WKT in `unit`, if the file says it."""
    heading: np.ndarray | None = None
    """(T, N, dim) unit vectors, if the file has where individuals point; NaN where it does not."""
    confidence: np.ndarray | None = None
    """(T, N), in [0, 1], if the file has how sure its tracker is."""
    filled: np.ndarray | None = None
    """(T, N) bool, where a place is interpolated, by request or by the tracker."""
    dropped: tuple[DroppedRows, ...] = ()
    notes: tuple[str, ...] = ()
    """What a reader did that its user should know, a line each."""

    def __post_init__(self) -> None:
        shape = self.position.shape
        if self.position.ndim != 3 or shape[2] not in (2, 3):
            raise InputError(f"{self.name}: positions are (T, N, 2) or (T, N, 3), not {shape}")
        if not shape[0] or not shape[1]:
            raise InputError(f"{self.name} has no individual that is seen")
        if len(self.frame) != shape[0] or len(self.time) != shape[0] or len(self.ids) != shape[1]:
            raise InputError(
                f"{self.name}: {len(self.frame)} frames, {len(self.time)} times and "
                f"{len(self.ids)} individuals do not fit positions of shape {shape}"
            )
        for k in np.flatnonzero(np.diff(self.frame) <= 0)[:1]:
            raise InputError(
                f"{self.name}: frame {self.frame[k + 1]} comes after {self.frame[k]}: frames rise"
            )
        for k in np.flatnonzero(~(np.diff(self.time) > 0.0))[:1]:
            raise InputError(
                f"{self.name}: frame {self.frame[k + 1]} is at {self.time[k + 1]:g} s, after "
                f"{self.time[k]:g} s: times rise"
            )
        if len(set(self.ids)) < len(self.ids):
            twice = next(one for one in self.ids if self.ids.count(one) > 1)
            raise InputError(f"{self.name} has the individual {shorten(twice)} twice")
        if self.unit not in UNITS and self.unit != PIXELS:
            raise InputError(
                f"{self.name}: unit = {shorten(self.unit)} is not known: "
                f"{', '.join((*UNITS, PIXELS))}"
            )

    def __repr__(self) -> str:
        frames, individuals, dim = self.position.shape
        return (
            f"<Tracks {self.name}, {individuals} individuals, {frames} frames, "
            f"{dim}-D, {self.unit}>"
        )

    @property
    def dim(self) -> int:
        """2 or 3."""
        return self.position.shape[2]

    @cached_property
    def seen(self) -> np.ndarray:
        """(T, N) bool: where an individual has a place."""
        return np.isfinite(self.position).all(axis=2)

    @cached_property
    def step(self) -> float:
        """Seconds from frame to frame, the median; NaN for one frame."""
        return float(np.median(np.diff(self.time))) if len(self.time) > 1 else math.nan

    @cached_property
    def is_even(self) -> bool:
        """Whether all frames are equally far apart in time, as derivatives need it."""
        return bool((np.abs(np.diff(self.time) - self.step) <= EVEN * self.step).all())

    @property
    def rate(self) -> float:
        """Frames per second, of the median step."""
        return 1.0 / self.step

    @cached_property
    def extent(self) -> tuple[np.ndarray, np.ndarray]:
        """The least and the largest coordinate of all places, (dim,) each, in `unit`."""
        places = self.position[self.seen]
        return places.min(axis=0), places.max(axis=0)

    def frames(self, first: int = 0, end: int | None = None, every: int = 1) -> Tracks:
        """The same individuals in some of the frames, by their places from 0 on."""
        return self._at((slice(first, end, every), slice(None)))

    def individuals(self, rows: Sequence[int] | np.ndarray) -> Tracks:
        """Some of the individuals, by their places among `ids`."""
        return self._at((slice(None), np.asarray(rows)))

    def _at(self, at: tuple) -> Tracks:
        def cut(array: np.ndarray | None) -> np.ndarray | None:
            return None if array is None else array[at[0]][:, at[1]]

        ids = np.array(self.ids, object)[at[1]]
        return replace(
            self,
            position=self.position[at[0]][:, at[1]],
            frame=self.frame[at[0]],
            time=self.time[at[0]],
            ids=tuple(ids.tolist()),
            heading=cut(self.heading),
            confidence=cut(self.confidence),
            filled=cut(self.filled),
        )

    def in_metres(self) -> Tracks:
        """The same in metres. Raises InputError for pixels, whose size nobody told."""
        if self.unit == PIXELS:
            raise InputError(f"{self.name} is in pixels: give --scale, metres in a pixel")
        factor = UNITS[self.unit]
        if factor == 1.0:
            return self
        boundary = self.boundary
        if boundary:
            from shapely import from_wkt, transform

            boundary = transform(from_wkt(boundary), lambda places: places * factor).wkt
        return replace(
            self,
            position=self.position * factor,
            unit="m",
            period=tuple(side * factor for side in self.period),
            boundary=boundary,
        )

    def to_dataframe(self) -> pd.DataFrame:
        """One row for each place: frame, time, id, x, y and z, in the order of frames."""
        import pandas as pd

        at, row = np.nonzero(self.seen)
        columns = {
            "frame": self.frame[at],
            "time": self.time[at],
            "id": np.array(self.ids, object)[row],
        }
        places = self.position[at, row]
        return pd.DataFrame(columns | dict(zip("xyz", places.T, strict=False)))


def tracks_of_rows(
    frame: np.ndarray,
    individual: Sequence[str] | np.ndarray,
    position: np.ndarray,
    *,
    name: str,
    unit: str,
    rate: float = math.nan,
    time: np.ndarray | None = None,
    heading: np.ndarray | None = None,
    confidence: np.ndarray | None = None,
    filled: np.ndarray | None = None,
    **others,
) -> Tracks:
    """Tracks of rows in any order: one for each individual and frame.

    Parameters
    ----------
    frame: (R,) whole numbers; individual: (R,) names or numbers; position: (R, dim), `unit`.
    rate: frames per second, or `time` (R,), s, which is the same in all rows of a frame.
    heading: (R, dim); confidence, filled: (R,). others: fields of `Tracks`.

    Raises InputError for an individual that is twice in a frame, and for tables that are too large.
    """
    numbers, at = np.unique(np.asarray(frame), return_inverse=True)
    names, row = np.unique(np.asarray(individual), return_inverse=True)
    dim = position.shape[1]
    if len(numbers) * len(names) * dim > MOST_PLACES:
        raise InputError(
            f"{name}: {len(names)} individuals in {len(numbers)} frames are too many: "
            f"{MOST_PLACES} numbers at most; read some of the frames, with --frames or --every"
        )
    place = at * len(names) + row
    if len(np.unique(place)) < len(place):
        order = np.argsort(place, kind="stable")
        k = order[np.flatnonzero(np.diff(place[order]) == 0)[0]]
        raise InputError(
            f"{name}: {shorten(str(names[row[k]]))} is twice in frame {numbers[at[k]]}"
        )

    def spread(values: np.ndarray | None, empty: float) -> np.ndarray | None:
        if values is None:
            return None
        values = np.asarray(values)
        table = np.full((len(numbers), len(names), *values.shape[1:]), empty, values.dtype)
        table[at, row] = values
        return table

    if time is None:
        seconds = numbers / rate
    else:
        seconds = np.full(len(numbers), np.nan)
        seconds[at] = time
    table = spread(np.asarray(position, float), np.nan)
    assert table is not None
    return Tracks(
        position=table,
        frame=numbers.astype(np.int64),
        time=seconds.astype(float),
        ids=tuple(map(str, names.tolist())),
        unit=unit,
        name=name,
        heading=spread(heading, np.nan),
        confidence=spread(confidence, np.nan),
        filled=spread(filled, False),
        **others,
    )
