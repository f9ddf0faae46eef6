"""Our own files: recordings of runs, the tidy tables that `convert` writes, and plain tables."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.readers.text_columns import (
    beginning_of,
    lower_names,
    numbers_of,
    read_frame,
    stem_ids,
    whole_numbers,
)
from app.tracks.readers.track_reader import BOTTOM_LEFT, FileTracks, ReadingOptions, TrackReader
from app.tracks.tracks import PIXELS, UNITS
from worlds.file_writer import unguard_cell
from worlds.input_error import InputError, shorten, unknown

# Recordings of runs: Parquet with a spec. A tick is a frame.

RECORDING_KEY = b"flockscope"
"""`agents.recordings.recorder.KEY`, which is not imported to tell what a file is."""


def is_recording(beginning: FileBeginning) -> bool:
    """Whether it is Parquet with the metadata of ours, which is at its end."""
    return RECORDING_KEY in beginning.keys


def read_recording(files: Sequence[Path], options: ReadingOptions) -> FileTracks:
    """A recording of a run, or a saved state. Raises InputError."""
    from agents.recordings.recording import Recording

    recording = Recording(files[0])
    dim = recording.spec.dim
    axes = ["x", "y", "z"][:dim]
    pointing = [name for name in ("ux", "uy", "uz")[:dim] if name in recording.names]
    table = recording.table(["tick", "id", *axes, *pointing])

    def columns(names: Sequence[str]) -> np.ndarray:
        return np.column_stack([table[name].to_numpy().astype(float) for name in names])

    world, seconds = recording.world, recording.time_unit == "s"
    period = tuple(
        float(side) if edge == "wrap" else 0.0
        for side, edge in zip(world.size, world.edges, strict=True)
    ) if world.dim == dim else ()  # fmt: skip
    tracks = FileTracks(
        columns(axes),
        table["id"].to_numpy(),
        table["tick"].to_numpy().astype(np.int64),
        rate=1.0 / recording.time_per_tick if seconds or options.rate is None else None,
        unit="m",
        origin=BOTTOM_LEFT,
        up="z",
        heading=columns(pointing) if len(pointing) == dim else None,
        period=period if any(period) else (),
    )
    if not seconds:
        tracks.notes.append("its model counts ticks: a tick is taken as a second")
    if recording.length_unit != "m":
        tracks.notes.append("its model has no unit of length: a length of 1 is taken as a metre")
    return tracks


# The tidy table that `convert` writes, and any other with columns for frame or time, id, x and y.

TIDY_KEY = "flockscope_tracks"
"""The key of the metadata of Parquet, and the word that begins the first line of a CSV file."""
ALIASES: Mapping[str, tuple[str, ...]] = {
    "frame": ("frame", "frames", "frame_number", "fr"),
    "time": ("time", "t", "seconds"),
    "id": ("id", "individual", "track_id", "agent", "agent_id", "identity", "track", "ped_id"),
    "x": ("x", "pos_x", "x_m", "position_x"),
    "y": ("y", "pos_y", "y_m", "position_y"),
    "z": ("z", "pos_z", "z_m", "position_z"),
    "angle": ("angle", "heading", "yaw"),
    "confidence": ("confidence", "likelihood", "probability"),
}
"""The names of columns that need no option, lower case."""


def tidy_header(beginning: FileBeginning) -> dict[str, Any]:
    """What the first line of our CSV, or the metadata of our Parquet, says; empty if nothing."""
    if beginning.kind == "text" and beginning.first.startswith(f"# {TIDY_KEY} "):
        text = beginning.first.removeprefix(f"# {TIDY_KEY} ")
    elif TIDY_KEY.encode() in beginning.keys:
        from agents.recordings.parquet_table import ParquetTable

        return ParquetTable(beginning.path, None, "a table of tracks").metadata(TIDY_KEY.encode())
    else:
        return {}
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(f"{beginning.name} is damaged: its first line cannot be read") from None
    return values if isinstance(values, dict) else {}


def columns_of(names: Sequence[str], options: ReadingOptions, file: str) -> dict[str, str]:
    """What of a table holds what: by option, else by name. Raises InputError."""
    for held, column in options.columns.items():
        if column not in names:
            raise unknown("column", column, names[:50], f"--column {held}={column}")
    lower = lower_names(names)
    found = dict(options.columns)
    for held, aliases in ALIASES.items():
        if held not in found:
            column = next((lower[name] for name in aliases if name in lower), "")
            if column and column not in found.values():
                found[held] = column
    if "x" not in found or "y" not in found or not {"frame", "time"} & set(found):
        lacks = [held for held in ("x", "y") if held not in found]
        lacks += [] if {"frame", "time"} & set(found) else ["frame"]
        raise InputError(
            f"{file} has no column for {lacks[0]}: name it with --column {lacks[0]}=NAME "
            f"(its columns: {', '.join(map(str, names[:20]))})"
        )
    return found


def read_plain(files: Sequence[Path], options: ReadingOptions) -> FileTracks:
    """Plain tables, each of one individual if it names none. Raises InputError."""
    parts = [
        plain_rows(path, animal, options, len(files) > 1)
        for path, animal in zip(files, stem_ids(files), strict=True)
    ]
    if len({frozenset(part) for part in parts}) > 1:
        raise InputError(f"{files[0].name} and others do not have the same columns")
    rows = {held: np.concatenate([part[held] for part in parts]) for held in parts[0]}
    header = tidy_header(beginning_of(files[0]))
    axes = [axis for axis in "xyz" if axis in rows]
    heading = None
    if "angle" in rows and len(axes) == 2:
        heading = np.column_stack([np.cos(rows["angle"]), np.sin(rows["angle"])])
    frame = rows.get("frame")
    tracks = FileTracks(
        np.column_stack([rows[axis] for axis in axes]),
        rows["id"],
        None if frame is None else whole_numbers(frame, "frame", files[0].name),
        rows.get("time"),
        heading=heading,
        confidence=rows.get("confidence"),
        filled=rows["filled"] == 1.0 if "filled" in rows else None,
    )
    return with_header(tracks, header)


def with_header(tracks: FileTracks, header: Mapping[str, Any]) -> FileTracks:
    """Tracks with what our own header says of them, as far as it is sound."""
    if not header:
        return tracks
    unit, rate = header.get("unit"), header.get("rate")
    tracks.unit = str(unit) if unit in (*UNITS, PIXELS) else ""
    tracks.origin, tracks.up = BOTTOM_LEFT, "z"  # as `Tracks` has them
    if tracks.time is None and isinstance(rate, int | float) and rate > 0.0:
        tracks.rate = float(rate)
    period, boundary = header.get("period"), header.get("boundary")
    dim = tracks.position.shape[1]
    if (
        isinstance(period, list)
        and len(period) == dim
        and all(isinstance(side, int | float) and side >= 0.0 for side in period)
    ):
        tracks.period = tuple(map(float, period))
    tracks.boundary = boundary if isinstance(boundary, str) else ""
    return tracks


def plain_rows(
    path: Path, animal: str, options: ReadingOptions, is_one_of_several: bool
) -> dict[str, np.ndarray]:
    """The columns of a table (R,), by what they hold. Raises InputError."""
    beginning = beginning_of(path)
    if beginning.kind == "parquet":
        from agents.recordings.parquet_table import ParquetTable

        table = ParquetTable(path, None, "a table of tracks")
        found = columns_of(table.names, options, path.name)
        frame = table.read(own_columns(found, table.names)).to_pandas(ignore_metadata=True)
    else:
        if beginning.kind != "text":
            raise InputError(f"{path.name} is in no format of tracks that is known")
        skip = 1 if tidy_header(beginning) else 0
        names = beginning.words(skip)
        if skip:  # the separator is that of the line of names
            names = tuple(name.strip() for name in beginning.lines[1].split(",")) if len(
                beginning.lines) > 1 else ()  # fmt: skip
        found = columns_of(names, options, path.name)
        frame = read_frame(
            beginning,
            own_columns(found, names),
            skip=skip,
            separator="," if skip else None,
            texts=[found["id"]] if "id" in found else (),
            width=len(names),
        )
        line = 2 + skip
    rows = {
        held: numbers_of(frame, column, path.name, 2 if beginning.kind == "parquet" else line)
        for held, column in found.items()
        if held != "id"
    }
    if "filled" in frame.columns:
        rows["filled"] = numbers_of(frame, "filled", path.name)
    who = found.get("id")
    moments = rows.get("frame", rows.get("time"))
    is_repeated = len(np.unique(moments)) < len(frame) if moments is not None else False
    if who is None and not is_one_of_several and is_repeated:
        raise InputError(
            f"{path.name} has no column for id: name it with --column id=NAME "
            f"(its columns: {', '.join(map(str, list(frame.columns)[:20]))})"
        )
    if who is None:
        rows["id"] = np.full(len(frame), animal, object)
    else:
        ids = frame[who].astype(object).map(id_text)
        is_guarded = beginning.kind == "text" and bool(tidy_header(beginning))
        rows["id"] = (ids.map(unguard_cell) if is_guarded else ids).to_numpy(object)
    return rows


def own_columns(found: Mapping[str, str], names: Sequence[str]) -> list[str]:
    """The columns that are read: those that were found, and `filled` of our own tables."""
    return [*dict.fromkeys(found.values()), *(["filled"] if "filled" in names else [])]


def id_text(value: object) -> str:
    """The name of an individual; whole numbers without a point.

    >>> id_text(3.0), id_text("fish 2"), id_text(7)
    ('3', 'fish 2', '7')
    """
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    text = str(value)
    return text if len(text) <= 200 else shorten(text, 200)


def is_tidy(beginning: FileBeginning) -> bool:
    """Whether `convert` wrote it."""
    return bool(tidy_header(beginning))


def is_table(beginning: FileBeginning) -> bool:
    """Whether it is a table of some kind, whose columns have names."""
    if beginning.kind == "parquet":
        return True
    columns = beginning.columns
    return (
        len(columns) > 1
        and len(beginning.words(1)) == len(columns)
        and not set(beginning.first) & set("<>{}")
        and not all(name.replace(".", "").replace("-", "").isdigit() for name in columns)
    )


RECORDINGS = (
    TrackReader("recording", "flockscope, recording", (".parquet",), is_recording, read_recording),
    TrackReader("tidy", "flockscope, tracks", (".csv", ".parquet"), is_tidy, read_plain),
)
TABLES = (
    TrackReader(
        "table",
        "plain table: frame or time, id, x, y[, z, angle, confidence]",
        (".csv", ".parquet"),
        is_table,
        read_plain,
        needs=("--rate", "--unit", "--origin", "--column, where names differ"),
        takes_several=True,
    ),
)
READERS = RECORDINGS
