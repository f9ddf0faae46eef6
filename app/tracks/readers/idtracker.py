"""idtracker.ai: a dictionary in NumPy or HDF5, a table wide or long, Parquet. Pixels, y down.

Source: idtracker.ai, its `trajectories` files; Romero-Ferrero et al. (2019). Where the file lies
on its maker's disk is in it too, and is not taken.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.readers.stored_arrays import opened_hdf5, read_npy
from app.tracks.readers.text_columns import beginning_of, numbers_of, read_frame, whole_numbers
from app.tracks.readers.track_reader import TOP_LEFT, FileTracks, ReadingOptions, TrackReader
from app.tracks.tracks import PIXELS
from worlds.input_error import InputError
from worlds.text_file import read_text

TIDY = ("frame", "time", "individual", "x", "y", "probability")
TABLE = "idtrackerai_attributes"
"""The key of the metadata of a Parquet file."""
MOST_IDS = 100_000


def told_by(attributes: Mapping[str, Any], tracks: FileTracks) -> FileTracks:
    """The tracks with what the attributes of idtracker.ai say of them."""
    rate = attributes.get("frames_per_second")
    tracks.unit, tracks.origin = PIXELS, TOP_LEFT
    with suppress(TypeError, ValueError):
        tracks.rate = float(np.ravel(rate)[0]) if rate is not None else None
    with suppress(KeyError, TypeError, ValueError, IndexError):
        length = float(np.ravel(attributes["body_length"])[0])
        tracks.notes.append(f"a body is {length:.4g} px long, says the file")
    with suppress(KeyError, TypeError, ValueError, IndexError):
        length = float(np.ravel(attributes["length_unit"])[0])
        if length > 0.0:
            tracks.notes.append(
                f"a unit of its calibration is {length:.6g} px long: --scale takes metres in a px"
            )
    labels = attributes.get("identities_labels")
    if (
        isinstance(labels, list)
        and len(labels) == len(tracks.ids)
        and len(set(map(str, labels))) == len(labels)
        and tracks.is_table
    ):
        tracks.ids = [str(label) for label in labels]
    return tracks


def table_of(positions: Any, probabilities: Any, name: str) -> FileTracks:
    """Tracks of an array (T, N, 2). Raises InputError."""
    array = np.asarray(positions if positions is not None else [])
    if array.ndim != 3 or array.shape[2] not in (2, 3) or array.dtype.kind not in "iuf":
        raise InputError(f"{name}: its trajectories are no numbers of shape (T, N, 2)")
    frames, individuals = array.shape[0], array.shape[1]
    if individuals > MOST_IDS:
        raise InputError(f"{name} has {individuals} individuals: at most {MOST_IDS} are read")
    confidence = None
    if probabilities is not None:
        sure = np.asarray(probabilities)
        if sure.size == frames * individuals and sure.dtype.kind in "iuf":
            confidence = sure.reshape(frames, individuals).astype(float)
    return FileTracks(
        array.astype(float),
        [str(k + 1) for k in range(individuals)],
        np.arange(frames),
        confidence=confidence,
    )


def read_dictionary(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """A .npy file: its dictionary, or a bare array of the first versions. Raises InputError."""
    name, values = files[0].name, read_npy(files[0])
    if isinstance(values, np.ndarray):
        tracks = table_of(values, None, name)
        tracks.notes.append("a bare array: neither rate nor unit nor origin is in it")
        return tracks
    if not isinstance(values, dict) or "trajectories" not in values:
        raise InputError(f"{name} holds no trajectories of idtracker.ai")
    return told_by(values, table_of(values["trajectories"], values.get("id_probabilities"), name))


def read_hdf5(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """A trajectories.h5. Raises InputError."""
    with opened_hdf5(files[0]) as file:
        sure = file.array("id_probabilities") if file.has("id_probabilities") else None
        tracks = table_of(file.array("trajectories"), sure, files[0].name)
        names = ("frames_per_second", "body_length", "length_unit", "identities_labels")
        attributes = {name: file.attribute(name) for name in names}
        for name in names:
            if attributes[name] is None and file.has(name):
                with suppress(InputError):
                    attributes[name] = file.array(name)
    return told_by(attributes, tracks)


def attributes_beside(path: Path) -> Mapping[str, Any]:
    """What idtracker.ai says of a table in a file beside it; empty if there is none."""
    for name in ("attributes_tidy.json", "attributes.json"):
        beside = path.with_name(name)
        if beside.is_file():
            with suppress(ValueError, RecursionError):
                values = json.loads(read_text(name, beside))
                if isinstance(values, dict):
                    return values
    return {}


def read_tidy(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """A row for each individual and frame. Raises InputError."""
    beginning = beginning_of(files[0])
    frame = read_frame(beginning, TIDY)
    rows = rows_of(frame, beginning.name)
    attributes = attributes_beside(files[0])
    tracks = told_by(attributes, rows)
    if "frames_per_second" not in attributes:
        tracks.rate = rate_of(frame, beginning.name)
    return tracks


def rows_of(frame: Any, name: str) -> FileTracks:
    """Tracks of the columns TIDY; individuals, counted from 0 there, are counted from 1."""
    columns = {column: numbers_of(frame, column, name) for column in TIDY if column != "time"}
    individual = whole_numbers(columns["individual"], "individual", name) + 1
    return FileTracks(
        np.column_stack([columns["x"], columns["y"]]),
        individual,
        whole_numbers(columns["frame"], "frame", name),
        confidence=columns["probability"],
    )


def rate_of(frame: Any, name: str) -> float | None:
    """Frames per second, from the columns frame and time; None if they do not say it."""
    number, time = numbers_of(frame, "frame", name), numbers_of(frame, "time", name)
    told = np.isfinite(number) & np.isfinite(time)
    if told.sum() < 2 or np.ptp(time[told]) <= 0.0:
        return None
    return float(round(np.ptp(number[told]) / np.ptp(time[told]), 3))


def read_wide(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """A row for each frame: time, x1, y1, x2, y2, ... Raises InputError."""
    beginning = beginning_of(files[0])
    frame = read_frame(beginning)
    names = [name for name in frame.columns if name != "time"]
    values = np.column_stack([numbers_of(frame, name, beginning.name) for name in names])
    tracks = told_by(
        attributes_beside(files[0]),
        table_of(values.reshape(len(frame), -1, 2), None, beginning.name),
    )
    if "time" in frame.columns and len(frame) > 1:
        time = numbers_of(frame, "time", beginning.name)
        if tracks.rate is None and time[-1] > time[0]:
            tracks.rate = float(round((len(time) - 1) / (time[-1] - time[0]), 2))
    return tracks


def read_parquet(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """The long table as Parquet, its attributes in the metadata. Raises InputError."""
    from agents.recordings.parquet_table import ParquetTable

    table = ParquetTable(files[0], None, "a table of idtracker.ai")
    frame = table.read(TIDY).to_pandas(ignore_metadata=True)
    attributes = table.metadata(TABLE.encode())
    tracks = told_by(attributes, rows_of(frame, files[0].name))
    if tracks.rate is None:
        tracks.rate = rate_of(frame, files[0].name)
    return tracks


def is_wide(beginning: FileBeginning) -> bool:
    """Whether its columns are [time,] x1, y1, x2, y2, ..."""
    columns = [name for name in beginning.columns if name != "time"]
    return len(columns) >= 2 and all(
        re.fullmatch(rf"{'xy'[k % 2]}{k // 2 + 1}", name) for k, name in enumerate(columns)
    )


def has_trajectories(beginning: FileBeginning) -> bool:
    """Whether it is an HDF5 file of idtracker.ai."""
    return beginning.kind == "hdf5" and "trajectories" in beginning.parts


READERS = (
    TrackReader(
        "idtracker-npy",
        "idtracker.ai, NumPy",
        (".npy",),
        lambda beginning: beginning.kind == "npy",
        read_dictionary,
    ),
    TrackReader(
        "idtracker-h5",
        "idtracker.ai, HDF5",
        (".h5",),
        has_trajectories,
        read_hdf5,
    ),
    TrackReader(
        "idtracker-tidy",
        "idtracker.ai, a row for each individual and frame",
        (".csv",),
        lambda beginning: beginning.has_columns(*TIDY),
        read_tidy,
    ),
    TrackReader(
        "idtracker-wide",
        "idtracker.ai, a row for each frame",
        (".csv",),
        is_wide,
        read_wide,
    ),
    TrackReader(
        "idtracker-parquet",
        "idtracker.ai, Parquet",
        (".parquet",),
        lambda beginning: TABLE.encode() in beginning.keys,
        read_parquet,
    ),
)
