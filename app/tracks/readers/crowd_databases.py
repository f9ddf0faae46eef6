"""Crowds in databases: JuPedSim's SQLite, versions 1 and 2, and the pedestrian archive's HDF5.

Sources: JuPedSim, https://www.jupedsim.org; https://ped.fz-juelich.de/da, its description of files.
Both are read here and not by PedPy, which opens a database for writing, takes seconds to import and
makes an object of each place.
"""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.readers.stored_arrays import opened_hdf5
from app.tracks.readers.text_columns import MOST_ROWS
from app.tracks.readers.track_reader import BOTTOM_LEFT, FileTracks, ReadingOptions, TrackReader
from worlds.input_error import InputError, shorten

VERSIONS = (1, 2)
ROW = np.dtype([("frame", "i8"), ("id", "i8"), ("place", "f8", 2), ("pointing", "f8", 2)])
COLUMNS = ("frame", "id", "pos_x", "pos_y", "ori_x", "ori_y")
MOST_STEPS = 2_000_000_000
"""Instructions of SQLite's machine for a query."""
LONGEST_BOUNDARY = 1 << 24
"""Letters of what one can walk on."""


@contextmanager
def opened_database(path: Path) -> Iterator[sqlite3.Connection]:
    """A database that is only read. Raises InputError, also for what SQLite raises."""
    steps = [0]

    def go_on() -> bool:
        steps[0] += 1_000_000
        return steps[0] > MOST_STEPS

    try:
        address = f"file:{quote(str(path.absolute()))}?mode=ro&immutable=1"
        with closing(sqlite3.connect(address, uri=True)) as database:
            database.execute("PRAGMA trusted_schema = OFF")
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LONGEST_BOUNDARY)
            database.set_progress_handler(go_on, 1_000_000)
            yield database
    except (sqlite3.Error, sqlite3.Warning, OverflowError, UnicodeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{path.name} cannot be read as a database: {shorten(reason)}") from None


def tables_of(database: sqlite3.Connection) -> set[str]:
    """The names of tables, not of views, which could be any query."""
    rows = database.execute("SELECT name FROM sqlite_master WHERE type = 'table' LIMIT 1000")
    return {str(name) for (name,) in rows}


def is_jupedsim(beginning: FileBeginning) -> bool:
    """Whether it is a database of trajectories."""
    if beginning.kind != "sqlite":
        return False
    try:
        with opened_database(beginning.path) as database:
            return {"trajectory_data", "metadata"} <= tables_of(database)
    except InputError:
        return False


def read_jupedsim(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """A trajectory of JuPedSim, in metres. Raises InputError."""
    name = files[0].name
    with opened_database(files[0]) as database:
        if not {"trajectory_data", "metadata"} <= tables_of(database):
            raise InputError(f"{name} is no database of JuPedSim: it has no trajectory_data")
        told = dict(database.execute("SELECT key, value FROM metadata LIMIT 1000").fetchall())
        version = whole(told.get("version"))
        if version not in VERSIONS:
            raise InputError(
                f"{name} has version {shorten(told.get('version'))} of JuPedSim's format: 1 and 2 "
                "are read"
            )
        query = f"SELECT {', '.join(COLUMNS)} FROM trajectory_data LIMIT {MOST_ROWS + 1}"
        try:
            rows = np.fromiter(
                ((frame, who, (x, y), (u, v)) for frame, who, x, y, u, v in
                 database.execute(query)),
                ROW,
            )  # fmt: skip
        except (TypeError, ValueError, OverflowError):
            raise InputError(f"{name}: trajectory_data holds something that is no number") from None
        boundary = boundary_of(database)
    if len(rows) > MOST_ROWS:
        raise InputError(f"{name} has more than {MOST_ROWS} rows")
    if not len(rows):
        raise InputError(f"{name} has no rows")
    rate = number(told.get("fps"))
    pointing = rows["pointing"].copy()
    pointing[(pointing == 0.0).all(axis=1)] = np.nan
    return FileTracks(
        rows["place"],
        rows["id"],
        rows["frame"],
        rate=rate if 0.0 < rate < math.inf else None,
        unit="m",
        origin=BOTTOM_LEFT,
        heading=pointing,
        boundary=boundary,
    )


def boundary_of(database: sqlite3.Connection) -> str:
    """What one can walk on, as WKT: the union of all that is stored; empty if nothing is."""
    import shapely

    if "geometry" not in tables_of(database):
        return ""
    texts = [str(row[0]) for row in database.execute("SELECT wkt FROM geometry LIMIT 1000")]
    if not texts or sum(map(len, texts)) > LONGEST_BOUNDARY:
        return ""
    shapes = [shape for shape in shapely.from_wkt(texts, on_invalid="ignore") if shape is not None]
    return shapely.union_all(shapes).wkt if shapes else ""


def number(value: Any) -> float:
    """A number that is stored as text; NaN for none."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan


def whole(value: Any) -> int:
    """A whole number that is stored as text; -1 for none."""
    return int(number(value)) if number(value).is_integer() else -1


# The archive: one array of records, and what is walkable as an attribute.

RECORD = ("id", "frame", "x", "y")


def is_archive(beginning: FileBeginning) -> bool:
    """Whether it has the archive's array."""
    return beginning.kind == "hdf5" and "trajectory" in beginning.parts


def read_archive(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """A file of the pedestrian archive, in metres as the archive demands. Raises InputError."""
    name = files[0].name
    with opened_hdf5(files[0]) as file:
        rows = file.array("trajectory", kinds="V")
        if rows.ndim != 1 or not set(RECORD) <= set(rows.dtype.names or ()):
            raise InputError(f"{name}: its trajectory has no {', '.join(RECORD)}")
        if any(rows.dtype[column].kind not in "iuf" for column in RECORD):
            raise InputError(f"{name}: its trajectory does not hold numbers")
        rate = number(file.attribute("fps", "trajectory"))
        boundary = file.attribute("wkt_geometry")
    return FileTracks(
        np.column_stack([rows["x"], rows["y"]]).astype(float),
        rows["id"],
        rows["frame"].astype(np.int64),
        rate=rate if 0.0 < rate < math.inf else None,
        unit="m",
        origin=BOTTOM_LEFT,
        boundary=sound_boundary(boundary),
    )


def sound_boundary(text: Any) -> str:
    """A text as WKT, empty if it is none."""
    import shapely

    if not isinstance(text, str) or len(text) > LONGEST_BOUNDARY:
        return ""
    shape = shapely.from_wkt(text, on_invalid="ignore")
    return "" if shape is None or shape.is_empty else shape.wkt


READERS = (
    TrackReader(
        "jupedsim",
        "JuPedSim, SQLite",
        (".sqlite",),
        is_jupedsim,
        read_jupedsim,
    ),
    TrackReader(
        "pedestrian-archive",
        "pedestrian dynamics data archive, HDF5",
        (".h5",),
        is_archive,
        read_archive,
    ),
)
