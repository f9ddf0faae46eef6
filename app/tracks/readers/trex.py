"""TRex: an archive of NumPy arrays, or a table, for each animal. Centimetres, y down.

Source: TRex, https://trex.run (Walter and Couzin 2021). A place that is not there is infinite, one
that TRex has interpolated has `missing` 1, and `X` without a word behind it is the head.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.readers.stored_arrays import read_npz
from app.tracks.readers.text_columns import (
    beginning_of,
    numbers_of,
    read_frame,
    stem_ids,
)
from app.tracks.readers.track_reader import TOP_LEFT, FileTracks, ReadingOptions, TrackReader
from worlds.input_error import InputError

X, Y = "X#wcentroid", "Y#wcentroid"
NAMES = ("frame", "time", X, Y, "missing", "ANGLE", "frame_rate", "cm_per_pixel")


def centroid_column(beginning: FileBeginning, axis: str) -> str:
    """The name of the column of the centroid, whose unit stands behind it; "" if there is none."""
    pattern = rf"{axis}#wcentroid(\s*\(\w+\))?"
    return next((name for name in beginning.columns if re.fullmatch(pattern, name)), "")


def arrays_of(path: Path) -> dict[str, np.ndarray]:
    """What one file holds, by the names NAMES. Raises InputError."""
    if path.suffix.lower() == ".npz" or not beginning_of(path).is_text:
        return read_npz(path, NAMES)
    beginning = beginning_of(path)
    columns = {X: centroid_column(beginning, "X"), Y: centroid_column(beginning, "Y")}
    columns |= {
        name: name for name in ("frame", "time", "missing", "ANGLE") if name in beginning.columns
    }
    frame = read_frame(beginning, [column for column in columns.values() if column])
    return {
        name: numbers_of(frame, column, beginning.name)
        for name, column in columns.items()
        if column
    }


def ids_of(files: Sequence[Path]) -> list[str]:
    """The numbers of the animals, which stand at the end of their files' names."""
    found = [re.search(r"(?:fish|id|individual)_?(\d+)$", path.stem) for path in files]
    ids = [match[1] for match in found if match]
    return ids if len(set(ids)) == len(files) else stem_ids(files)


def read_trex(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """One file for each animal, which may begin at different frames. Raises InputError."""
    pieces: list[dict[str, np.ndarray]] = []
    rates = set()
    for path in files:
        arrays = arrays_of(path)
        missing = [name for name in ("frame", X, Y) if name not in arrays]
        if missing:
            raise InputError(f"{path.name} has no {' and no '.join(missing)}")
        rows = arrays["frame"].size
        if any(arrays[name].shape != (rows,) for name in ("frame", X, Y)):
            raise InputError(f"{path.name}: its arrays are not equally long")
        frame = arrays["frame"].astype(float)
        if not np.isfinite(frame).all() or (frame != np.round(frame)).any():
            raise InputError(f"{path.name}: its frames are no whole numbers")
        rate = arrays.get("frame_rate")
        time = arrays.get("time")
        if rate is not None and rate.size and float(rate.flat[0]) > 0.0:
            rates.add(float(rate.flat[0]))
        elif time is not None and time.shape == (rows,) and rows > 1:
            told = np.isfinite(time)
            if told.sum() > 1 and np.ptp(time[told]) > 0.0:
                rates.add(round(float(np.ptp(frame[told]) / np.ptp(time[told])), 3))
        pieces.append(
            {
                name: np.resize(arrays[name], rows).astype(float)
                if name in arrays and arrays[name].shape == (rows,)
                else np.full(rows, default)
                for name, default in ((X, np.nan), (Y, np.nan), ("missing", 0.0), ("ANGLE", np.nan))
            }
            | {"frame": frame}
        )
    if rates and max(rates) > 1.01 * min(rates):
        raise InputError(
            f"{files[0].name} and others have {min(rates):g} to {max(rates):g} frames per second"
        )
    joined = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}
    ids = np.repeat(np.arange(len(files)), [len(piece["frame"]) for piece in pieces])
    position = np.column_stack([joined[X], joined[Y]])
    position[~np.isfinite(position).all(axis=1)] = np.nan  # how TRex writes a gap
    angle = np.where(np.isfinite(joined["ANGLE"]), joined["ANGLE"], np.nan)
    tracks = FileTracks(
        position,
        np.array(ids_of(files), object)[ids],
        joined["frame"].astype(np.int64),
        rate=min(rates) if rates else None,
        unit="cm",
        origin=TOP_LEFT,
        heading=np.column_stack([np.cos(angle), np.sin(angle)]),
        filled=joined["missing"] == 1.0,
    )
    tracks.notes.append(
        "places are weighted centroids; they are in cm if TRex was told the size of a pixel, else "
        "in px: give --unit px then"
    )
    if tracks.filled is not None and tracks.filled.any():
        tracks.notes.append(f"{int(tracks.filled.sum())} places were interpolated by TRex")
    return tracks


def is_trex(beginning: FileBeginning) -> bool:
    """Whether it is one animal of TRex."""
    if beginning.kind == "zip":
        return {"frame", X, Y} <= beginning.parts
    return bool(centroid_column(beginning, "X")) and "frame" in beginning.columns


READERS = (
    TrackReader(
        "trex",
        "TRex, a file for each animal",
        (".npz", ".csv"),
        is_trex,
        read_trex,
        takes_several=True,
    ),
)
