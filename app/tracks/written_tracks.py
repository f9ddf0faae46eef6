"""Write tracks: as CSV or Parquet that `read` takes back without an option, or for JuPedSim."""

from __future__ import annotations

import json
import sqlite3
import tempfile
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from app.tracks.readers.own_files import TIDY_KEY
from app.tracks.tracks import PIXELS, Tracks
from worlds.file_writer import demand_writable, guard_cell, writing
from worlds.input_error import InputError
from worlds.plug_ins import demand_parquet

if TYPE_CHECKING:
    import pandas as pd

ENDINGS = (".csv", ".parquet", ".sqlite")
VERSION = "2"
"""Of JuPedSim's format."""


def tidy_table(tracks: Tracks) -> pd.DataFrame:
    """A row for each place: frame, time, id, x, y[, z, angle, confidence, filled]."""
    table = tracks.to_dataframe()
    at, row = np.nonzero(tracks.seen)
    if tracks.heading is not None and tracks.dim == 2:
        pointing = tracks.heading[at, row]
        table["angle"] = np.arctan2(pointing[:, 1], pointing[:, 0])
    if tracks.confidence is not None:
        table["confidence"] = tracks.confidence[at, row]
    if tracks.filled is not None:
        table["filled"] = tracks.filled[at, row].astype(int)
    return table


def tidy_facts(tracks: Tracks) -> dict[str, Any]:
    """What the table does not say."""
    return {
        "format": 1,
        "unit": tracks.unit,
        "rate": frames_rate(tracks),
        "period": list(tracks.period),
        "boundary": tracks.boundary,
        "read_from": tracks.format,
    }


def frames_rate(tracks: Tracks) -> float | None:
    """Frames per second by their numbers, None where times fit no rate."""
    if len(tracks.frame) < 2 or not tracks.is_even:
        return None
    gaps = np.diff(tracks.frame)
    if (gaps != gaps[0]).any():
        return None
    return float(f"{gaps[0] / tracks.step:.9g}")


def write_tracks(tracks: Tracks, path: str | Path, overwrite: bool = False) -> int:
    """Write tracks as the ending of `path` says, one of ENDINGS; returns the rows.

    JuPedSim's database takes metres in the plane alone. Raises InputError.
    """
    path = Path(path)
    demand_writable("--out", path, overwrite, ENDINGS)
    kind = path.suffix.lower()
    if kind == ".sqlite":
        return write_database(tracks, path, overwrite)
    table = tidy_table(tracks)
    facts = tidy_facts(tracks)
    if kind == ".parquet":
        demand_parquet(f"writing {str(path)!r}")
        import pyarrow as pa
        import pyarrow.parquet as pq

        arrow = pa.Table.from_pandas(table, preserve_index=False)
        arrow = arrow.replace_schema_metadata({TIDY_KEY: json.dumps(facts)})
        with writing("--out", path, overwrite, ENDINGS) as file:
            pq.write_table(arrow, file)
        return len(table)
    names = {name: guard_cell(name) for name in tracks.ids}
    table["id"] = table["id"].map(names)
    with writing("--out", path, overwrite, ENDINGS) as file:
        file.write(f"# {TIDY_KEY} {json.dumps(facts)}\n".encode())
        table.to_csv(file, index=False, lineterminator="\n")
    return len(table)


def write_database(tracks: Tracks, path: Path, overwrite: bool) -> int:
    """JuPedSim's SQLite, version 2; who has no whole number for a name gets one. Raises
    InputError."""
    if tracks.dim != 2:
        raise InputError(f"{path.name}: JuPedSim's format has no height: give --flat")
    if tracks.unit == PIXELS:
        raise InputError(f"{path.name}: JuPedSim's format is in metres: give --scale")
    tracks = tracks.in_metres()
    rate = frames_rate(tracks)
    if rate is None:
        raise InputError(f"{path.name}: JuPedSim's format takes even frames: give --rate")
    at, row = np.nonzero(tracks.seen)
    is_numbered = all(name.isdigit() and len(name) < 16 for name in tracks.ids)
    numbers = np.array([int(name) for name in tracks.ids] if is_numbered
                       else range(1, len(tracks.ids) + 1))  # fmt: skip
    places = tracks.position[at, row]
    pointing = np.zeros_like(places)
    if tracks.heading is not None:
        pointing = np.nan_to_num(tracks.heading[at, row])
    low, high = tracks.extent
    area = tracks.boundary or (
        f"POLYGON (({low[0]} {low[1]}, {high[0]} {low[1]}, {high[0]} {high[1]}, {low[0]} {high[1]},"
        f" {low[0]} {low[1]}))"
    )
    told = {
        "version": VERSION, "fps": f"{rate:g}", "xmin": low[0], "xmax": high[0], "ymin": low[1],
        "ymax": high[1],
    }  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "tracks.sqlite"
        with closing(sqlite3.connect(made)) as database, database:
            database.execute(
                "CREATE TABLE trajectory_data (frame INTEGER NOT NULL, id INTEGER NOT NULL, pos_x "
                "REAL NOT NULL, pos_y REAL NOT NULL, ori_x REAL NOT NULL, ori_y REAL NOT NULL)"
            )
            database.execute(
                "CREATE TABLE metadata (key TEXT NOT NULL UNIQUE PRIMARY KEY, value TEXT NOT NULL)"
            )
            database.execute(
                "CREATE TABLE geometry (hash INTEGER NOT NULL PRIMARY KEY, wkt TEXT NOT NULL)"
            )
            database.execute(
                "CREATE TABLE frame_data (frame INTEGER NOT NULL, geometry_hash INTEGER NOT NULL)"
            )
            rows = zip(
                tracks.frame[at].tolist(), numbers[row].tolist(), *places.T.tolist(),
                *pointing.T.tolist(), strict=True,
            )  # fmt: skip
            database.executemany("INSERT INTO trajectory_data VALUES (?, ?, ?, ?, ?, ?)", rows)
            database.executemany(
                "INSERT INTO metadata VALUES (?, ?)",
                [(key, str(value)) for key, value in told.items()],
            )
            database.execute("INSERT INTO geometry VALUES (1, ?)", (area,))
            database.executemany(
                "INSERT INTO frame_data VALUES (?, 1)", [(int(k),) for k in tracks.frame]
            )
            database.execute("CREATE INDEX frame_id_idx ON trajectory_data (frame, id)")
        with writing("--out", path, overwrite, ENDINGS) as file:
            file.write(made.read_bytes())
    return len(at)
