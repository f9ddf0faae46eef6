"""Fixes of GPS: Movebank's tables, and those of loggers, one for each animal.

Degrees become metres on the plane that touches WGS84 at the median fix: x points east, y north.
Sources: Movebank, https://www.movebank.org (attributes of GPS data); NIMA TR8350.2, WGS84.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.readers.text_columns import (
    beginning_of,
    lower_names,
    read_frame,
    stem_ids,
)
from app.tracks.readers.track_reader import BOTTOM_LEFT, FileTracks, ReadingOptions, TrackReader
from worlds.input_error import InputError, shorten

if TYPE_CHECKING:
    import pandas as pd

MAJOR, FLATTENING = 6_378_137.0, 1.0 / 298.257223563
"""WGS84: half of the longest axis, m, and how flat it is."""
LONGITUDES = ("location-long", "longitude", "lon", "long", "lng")
LATITUDES = ("location-lat", "latitude", "lat")
STAMPS = ("timestamp", "datetime", "date_time", "utc_datetime", "fixtime")
ANIMALS = ("individual-local-identifier", "individual-id", "tag-local-identifier", "animal_id",
           "animal", "individual", "id", "name")  # fmt: skip
MOVEBANK = ("timestamp", "location-long", "location-lat")


def tangent_plane(longitude: np.ndarray, latitude: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Places (R,) in degrees as metres east and north (R, 2) of the median; that, in degrees.

    >>> places, east, north = tangent_plane(np.array([10.0, 10.001]), np.array([0.0, 0.0]))
    >>> float(round(places[1, 0] - places[0, 0], 3)), float(places[0, 1])
    (111.319, 0.0)
    """
    west = longitude[0]
    longitude = west + (longitude - west + 180.0) % 360.0 - 180.0  # across the date line too
    east, north = float(np.median(longitude)), float(np.median(latitude))
    places = geocentric(longitude, latitude) - geocentric(np.array([east]), np.array([north]))
    lon, lat = math.radians(east), math.radians(north)
    axes = np.array(
        [
            [-math.sin(lon), math.cos(lon), 0.0],
            [-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)],
        ]
    )
    return places @ axes.T, (east + 180.0) % 360.0 - 180.0, north


def geocentric(longitude: np.ndarray, latitude: np.ndarray) -> np.ndarray:
    """Places (R,) in degrees on the ellipsoid, in metres from the middle of the earth, (R, 3)."""
    lon, lat = np.radians(longitude), np.radians(latitude)
    squared = FLATTENING * (2.0 - FLATTENING)
    radius = MAJOR / np.sqrt(1.0 - squared * np.sin(lat) ** 2)
    return np.column_stack(
        [
            radius * np.cos(lat) * np.cos(lon),
            radius * np.cos(lat) * np.sin(lon),
            radius * (1.0 - squared) * np.sin(lat),
        ]
    )


def column_named(columns: Mapping[str, str], names: Sequence[str]) -> str:
    """The first of the names that is a column, as the file writes it; "" if none is."""
    return next((columns[name] for name in names if name in columns), "")


def is_movebank(beginning: FileBeginning) -> bool:
    """Whether it has Movebank's columns."""
    return beginning.has_columns(*MOVEBANK)


def is_logger(beginning: FileBeginning) -> bool:
    """Whether it has degrees and times."""
    columns = lower_names(beginning.columns)
    has_time = column_named(columns, STAMPS) or {"date", "time"} <= set(columns)
    return bool(has_time and column_named(columns, LONGITUDES) and column_named(columns, LATITUDES))


def read_fixes(files: Sequence[Path], _options: ReadingOptions) -> FileTracks:
    """Tables of fixes, of which each is one animal if it names none. Raises InputError."""
    tracks = FileTracks(np.zeros((0, 2)), np.zeros(0, object), unit="m", origin=BOTTOM_LEFT)
    parts = [
        fixes_of(path, animal, tracks) for path, animal in zip(files, stem_ids(files), strict=True)
    ]
    seconds, ids, places = (np.concatenate(part) for part in zip(*parts, strict=True))
    if not len(seconds):
        raise InputError(f"{files[0].name} has no fix with a time and a place")
    order = np.lexsort((np.arange(len(seconds)), seconds))
    _, codes = np.unique(ids, return_inverse=True)
    keys = np.stack([codes, np.round(1000.0 * seconds).astype(np.int64)])
    _, first = np.unique(keys, axis=1, return_index=True)
    tracks.drop(len(seconds) - len(first), "another fix of the animal has the same time")
    kept = np.isin(order, first)
    order = order[kept]
    position, east, north = tangent_plane(*places[order].T)
    started = np.datetime64(0, "ms") + np.timedelta64(round(1000.0 * seconds[order[0]]), "ms")
    tracks.position, tracks.ids = position, ids[order]
    tracks.time = seconds[order] - seconds[order[0]]
    tracks.notes += [
        f"(0, 0) is longitude {east:.6f}, latitude {north:.6f}; x points east, y north",
        f"time 0 is {str(started).replace('T', ' ')}, as the file writes it (Movebank: UTC)",
    ]
    return tracks


def fixes_of(
    path: Path, animal: str, tracks: FileTracks
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (R,) in s since 1970, animals (R,) and degrees (R, 2) of a table; what is dropped is
    counted in `tracks`. Raises InputError."""
    beginning = beginning_of(path)
    columns = lower_names(beginning.columns)
    east, north = column_named(columns, LONGITUDES), column_named(columns, LATITUDES)
    stamp = column_named(columns, STAMPS)
    who = column_named(columns, ANIMALS)
    times = [stamp] if stamp else [columns.get("date", ""), columns.get("time", "")]
    visible = columns.get("visible", "")
    if not east or not north or not all(times):
        raise InputError(f"{path.name} has no columns of times, longitudes and latitudes")
    texts = [name for name in (*times, who, visible) if name]
    frame = read_frame(beginning, [*texts, east, north], texts=texts)
    seconds = seconds_of(frame, times, path.name)
    degrees = np.column_stack([degrees_of(frame, column) for column in (east, north)])
    hidden = np.zeros(len(frame), bool)
    if visible:
        hidden = (frame[visible].astype(str).str.strip().str.lower() == "false").to_numpy()
    blank = ~np.isfinite(degrees).all(axis=1) & ~hidden
    timeless = ~np.isfinite(seconds) & ~hidden & ~blank
    fits = (np.abs(degrees[:, 0]) <= 360.0) & (np.abs(degrees[:, 1]) <= 90.0)
    nowhere = ~fits & ~hidden & ~blank & ~timeless
    tracks.drop(hidden.sum(), "visible is false, which marks an outlier")
    tracks.drop(blank.sum(), "the place is blank or no number")
    tracks.drop(timeless.sum(), "the time is none")
    tracks.drop(nowhere.sum(), "the place is not on earth")
    kept = ~(hidden | blank | timeless | nowhere)
    names = np.full(len(frame), animal, object)
    if who:
        names = frame[who].astype(object).fillna("unnamed").astype(str).to_numpy(object)
    return seconds[kept], names[kept], degrees[kept]


def degrees_of(frame: pd.DataFrame, column: str) -> np.ndarray:
    """A column in degrees, NaN for what is no number, which loggers write where they saw none."""
    import pandas as pd

    return pd.to_numeric(frame[column], errors="coerce").to_numpy(float)


def seconds_of(frame: pd.DataFrame, columns: Sequence[str], name: str) -> np.ndarray:
    """Seconds since 1970 (R,), NaN for what is no time. Raises InputError for unclear dates."""
    import pandas as pd

    texts = frame[columns[0]].astype(str).str.strip()
    day = pd.Series(texts.cat.categories if hasattr(texts, "cat") else texts.unique())
    split = day.str.extract(r"^(\d{1,4})[/.-](\d{1,2})[/.-](\d{1,4})")
    lead = pd.to_numeric(split[0], errors="coerce").max()
    if split.notna().all(axis=1).any() and lead <= 31:  # no year comes first
        second = pd.to_numeric(split[1], errors="coerce").max()
        if lead <= 12 and second <= 12 and split.iloc[:, :2].nunique().max() > 1:
            raise InputError(
                f"{name}: {shorten(day.iloc[0])} may be two dates: write them as YYYY-MM-DD"
            )
        first = "%m/%d/%Y" if second > 12 else "%d/%m/%Y"
        texts = reordered(texts, first)
    texts = texts.str.replace("/", "-", regex=False)
    for column in columns[1:]:
        texts = texts + " " + frame[column].astype(str).str.strip()
    moments = pd.to_datetime(texts, format="ISO8601", errors="coerce", utc=True)
    values = moments.dt.tz_localize(None).to_numpy("datetime64[us]")
    seconds = values.astype(np.int64) / 1e6
    return np.where(np.isnat(values), np.nan, seconds)


def reordered(texts: pd.Series, order: str) -> pd.Series:
    """Dates of a day, a month and a year as YYYY-MM-DD, what is behind them kept."""
    pattern = r"^(\d{1,2})[/.-](\d{1,2})[/.-](\d{4})"
    day, month = (r"\1", r"\2") if order.startswith("%d") else (r"\2", r"\1")
    dates = texts.str.replace(pattern, rf"\3-{month}-{day}", regex=True)
    return dates.str.replace(r"-(\d)(?=-|\D|$)", r"-0\1", regex=True)


READERS = (
    TrackReader(
        "movebank",
        "Movebank",
        (".csv",),
        is_movebank,
        read_fixes,
        takes_several=True,
    ),
    TrackReader(
        "gps",
        "GPS loggers, a file for each animal",
        (".csv",),
        is_logger,
        read_fixes,
        takes_several=True,
    ),
)
