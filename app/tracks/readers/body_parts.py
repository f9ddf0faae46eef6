"""Trackers of body parts: SLEAP, DeepLabCut and `movement`. One part stands for the individual.

Sources: SLEAP's analysis files, https://docs.sleap.ai (axes in the order of Fortran); DeepLabCut's
tables (Mathis et al. 2018); `movement`, https://movement.neuroinformatics.dev, saved as netCDF,
which is HDF5.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.readers.stored_arrays import ArrayFile, opened_hdf5
from app.tracks.readers.text_columns import beginning_of, numbers_of, read_frame
from app.tracks.readers.track_reader import TOP_LEFT, FileTracks, ReadingOptions, TrackReader
from app.tracks.tracks import PIXELS
from worlds.input_error import InputError, shorten, unknown

LEAST_LIKELIHOOD = 0.6
"""Below this a place is a tracker's guess: DeepLabCut leaves no place blank."""


def chosen_node(names: Sequence[str], options: ReadingOptions, name: str) -> int:
    """The place of the part that is asked for, or of the only one. Raises InputError."""
    if options.node is None and len(names) == 1:
        return 0
    if options.node is None:
        raise InputError(
            f"{name} has {len(names)} parts of a body: choose one with --node "
            f"({', '.join(map(str, names[:20]))})"
        )
    if options.node not in names:
        raise unknown("part of a body", options.node, names[:50], name)
    return list(names).index(options.node)


def distinct(names: Sequence[str]) -> list[str]:
    """Names that are each there once: a number is added to one that is not."""
    return [f"{name} {k + 1}" if names.count(name) > 1 else name for k, name in enumerate(names)]


def read_sleap(files: Sequence[Path], options: ReadingOptions) -> FileTracks:
    """The `tracks` (track, 2, node, frame) of an analysis file. Raises InputError."""
    name = files[0].name
    with opened_hdf5(files[0]) as file:
        nodes = file.texts("node_names")
        node = chosen_node(nodes, options, name)
        places = file.dataset("tracks")
        if places.ndim != 4 or places.dtype.kind not in "fiu":
            raise InputError(f"{name}: its tracks are no numbers of four axes")
        if places.shape[1:3] == (2, len(nodes)):
            table = np.asarray(places[:, :, node, :]).transpose(2, 0, 1)
        elif places.shape[2:] == (len(nodes), 2):  # as newer versions write for Python
            table = np.asarray(places[:, :, node, :])
        else:
            raise InputError(
                f"{name}: tracks of shape {places.shape} do not fit {len(nodes)} parts of a body"
            )
        frames, individuals = table.shape[:2]
        ids = file.texts("track_names") if file.has("track_names") else []
        if len(ids) != individuals:
            ids = [f"track {k}" for k in range(individuals)]
        confidence = scores_of(file, node, frames, individuals, len(nodes))
    return FileTracks(
        table.astype(float),
        distinct(ids),
        np.arange(frames),
        unit=PIXELS,
        origin=TOP_LEFT,
        confidence=confidence,
        notes=[f"{nodes[node]} stands for the individual"],
    )


def scores_of(
    file: ArrayFile, node: int, frames: int, individuals: int, nodes: int
) -> np.ndarray | None:
    """How sure SLEAP is of a part, (T, N), if it says it."""
    if not file.has("point_scores"):
        return None
    scores = file.dataset("point_scores")
    if scores.shape == (individuals, nodes, frames):
        return np.asarray(scores[:, node, :]).T.astype(float)
    if scores.shape == (frames, individuals, nodes):
        return np.asarray(scores[:, :, node]).astype(float)
    return None


# DeepLabCut: three or four rows of names, then a row for each frame.

ROWS = ("scorer", "individuals", "bodyparts", "coords")


def header_rows(beginning: FileBeginning) -> dict[str, tuple[str, ...]]:
    """The rows of names of a table of DeepLabCut; empty for any other."""
    rows = {}
    for k in range(min(4, len(beginning.lines))):
        words = beginning.words(k)
        if not words or words[0] not in ROWS:
            break
        rows[words[0]] = words[1:]
    return rows if {"scorer", "bodyparts", "coords"} <= set(rows) else {}


def read_deeplabcut(files: Sequence[Path], options: ReadingOptions) -> FileTracks:
    """A table of DeepLabCut. Raises InputError."""
    beginning = beginning_of(files[0])
    name, rows = beginning.name, header_rows(beginning)
    parts, coords = rows["bodyparts"], rows["coords"]
    owners = rows.get("individuals", ("1",) * len(parts))
    if not len(parts) == len(coords) == len(owners):
        raise InputError(f"{name}: its rows of names are not equally long")
    nodes = list(dict.fromkeys(parts))
    node = nodes[chosen_node(nodes, options, name)]
    places: dict[str, dict[str, int]] = {}
    for k, (owner, part, coord) in enumerate(zip(owners, parts, coords, strict=True)):
        if part == node:
            places.setdefault(owner, {}).setdefault(coord, k + 1)
    axes = [axis for axis in "xyz" if all(axis in held for held in places.values())]
    if axes[:2] != ["x", "y"]:
        raise InputError(f"{name}: {shorten(node)} has no columns x and y")
    used = sorted({0} | {held[c] for held in places.values() for c in (*axes, "likelihood")
                         if c in held})  # fmt: skip
    frame = read_frame(beginning, header=None, skip=len(rows), used=used, width=len(parts) + 1)
    line = len(rows) + 1
    table = np.stack(
        [
            np.column_stack([numbers_of(frame, held[axis], name, line) for axis in axes])
            for held in places.values()
        ],
        axis=1,
    )
    likelihood = None
    if all("likelihood" in held for held in places.values()):
        likelihood = np.column_stack(
            [numbers_of(frame, held["likelihood"], name, line) for held in places.values()]
        )
    return FileTracks(
        table,
        list(places),
        number_of_frames(frame, name, line),
        unit=PIXELS if len(axes) == 2 else "",
        origin=TOP_LEFT,
        confidence=likelihood,
        least_confidence=LEAST_LIKELIHOOD,
        notes=[f"{node} stands for the individual"],
    )


def number_of_frames(frame: Any, name: str, line: int) -> np.ndarray:
    """The numbers of frames in the first column. Raises InputError, as for tables of labels."""
    with suppress(InputError):
        numbers = numbers_of(frame, 0, name, line)
        if np.isfinite(numbers).all():
            return numbers.astype(np.int64)
    raise InputError(
        f"{name}: its first column holds no numbers of frames: is it a table of labels?"
    )


# movement: one array for all parts, in netCDF.

AXES = {"time": "time", "space": "space", "keypoints": "keypoint", "keypoint": "keypoint",
        "individuals": "individual", "individual": "individual"}  # fmt: skip
"""The names of axes, in old and new versions."""


def axes_of(array: Any) -> list[str]:
    """The axes of an array of netCDF, in its order."""
    names = []
    for k in range(array.ndim):
        scales = array.dims[k]
        name = scales[0].name.rsplit("/", 1)[-1] if len(scales) else ""
        names.append(AXES.get(name, name))
    if not any(names):
        return ["time", "space", "keypoint", "individual"] if array.ndim == 4 else [
            "time", "space", "individual"]  # fmt: skip
    return names


def ordered(array: Any, axes: list[str], wanted: Sequence[str], node: int) -> np.ndarray:
    """An array with the axes wanted, of one part."""
    index = tuple(node if axis == "keypoint" else slice(None) for axis in axes)
    remaining = [axis for axis in axes if axis != "keypoint"]
    return np.asarray(array[index]).transpose([remaining.index(axis) for axis in wanted])


def read_movement(files: Sequence[Path], options: ReadingOptions) -> FileTracks:
    """A data set of `movement`. Raises InputError."""
    name = files[0].name
    with opened_hdf5(files[0]) as file:
        array = file.dataset("position")
        axes = axes_of(array)
        if not {"time", "space", "individual"} <= set(axes) or array.dtype.kind not in "fiu":
            raise InputError(f"{name}: its position has the axes {', '.join(axes)}")

        def names_of(axis: str) -> list[str]:
            for stored in (f"{axis}s", axis):
                if file.has(stored):
                    return file.texts(stored)
            return [f"{axis} {k}" for k in range(array.shape[axes.index(axis)])]

        nodes = names_of("keypoint") if "keypoint" in axes else ["centroid"]
        node = chosen_node(nodes, options, name)
        table = ordered(array, axes, ("time", "individual", "space"), node).astype(float)
        confidence = None
        if file.has("confidence"):
            sure = file.dataset("confidence")
            confidence = ordered(sure, axes_of(sure), ("time", "individual"), node).astype(float)
        rate = file.attribute("fps")
        frame, time = None, None
        if file.has("time") and file.dataset("time").dtype.kind in "fiu":
            stored_time = file.array("time")
            if file.attribute("time_unit") == "seconds":
                time = stored_time.astype(float)
            else:
                frame = stored_time.astype(np.int64)
        ids = distinct(names_of("individual"))
    if table.shape[2] not in (2, 3) or len(ids) != table.shape[1]:
        raise InputError(f"{name}: its axes do not fit each other")
    told = float(rate) if isinstance(rate, int | float) and rate > 0 else None
    if frame is None or told is not None:
        frame = np.arange(len(table)) if told is not None and frame is None else frame
    return FileTracks(
        table,
        ids,
        frame,
        None if told is not None else time,
        rate=told,
        unit=PIXELS if table.shape[2] == 2 else "",
        origin=TOP_LEFT,
        confidence=confidence,
        least_confidence=LEAST_LIKELIHOOD,
        notes=[f"{nodes[node]} stands for the individual"] if len(nodes) > 1 else [],
    )


READERS = (
    TrackReader(
        "sleap",
        "SLEAP, analysis file",
        (".h5",),
        lambda beginning: {"tracks", "node_names"} <= beginning.parts,
        read_sleap,
        needs=("--rate", "--node"),
    ),
    TrackReader(
        "movement",
        "movement, netCDF",
        (".nc",),
        lambda beginning: beginning.kind == "hdf5" and {"position", "space"} <= beginning.parts,
        read_movement,
        needs=("--node",),
    ),
    TrackReader(
        "deeplabcut",
        "DeepLabCut",
        (".csv",),
        lambda beginning: bool(header_rows(beginning)),
        read_deeplabcut,
        needs=("--rate", "--node"),
    ),
)
