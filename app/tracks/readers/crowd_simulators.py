"""Crowd simulators: Pathfinder, Vadere, Viswalk, crowd:it. All write metres, most of them times.

Vadere's events are put into frames by PedPy. The others are read here: PedPy rounds the rate to a
whole number, so that steps of 0.4 s become frames of 0.5 s, and takes those who are not active.
Names of people in a file are not taken.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.readers.text_columns import (
    beginning_of,
    numbers_of,
    read_frame,
    whole_numbers,
)
from app.tracks.readers.track_reader import BOTTOM_LEFT, FileTracks, ReadingOptions, TrackReader
from worlds.input_error import InputError, shorten
from worlds.plug_ins import demand
from worlds.text_file import read_text

FLOOR = 1.0
"""Metres of height from which people are on several floors."""


def timed(
    time: np.ndarray, who: np.ndarray, places: np.ndarray, kept: np.ndarray, heights: np.ndarray
) -> FileTracks:
    """Tracks in metres of rows with times, those that are kept."""
    tracks = FileTracks(places[kept], who[kept], time=time[kept], unit="m", origin=BOTTOM_LEFT)
    tracks.drop(np.count_nonzero(~kept), "the person is not active")
    if len(heights) and np.ptp(heights[kept]) > FLOOR if kept.any() else False:
        tracks.notes.append("people are on several floors: their heights are left out")
    return tracks


def read_pathfinder(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """Pathfinder's table, whose second row is of units. Raises InputError."""
    beginning = beginning_of(files[0])
    name = beginning.name
    units = beginning.words(1)[:1] == ("s",)
    columns = [column for column in ("t", "id", "x", "y", "z", "active")
               if column in beginning.columns]  # fmt: skip
    frame = read_frame(beginning, columns, skip=[1] if units else ())
    line = 3 if units else 2
    values = {column: numbers_of(frame, column, name, line) for column in columns}
    kept = values["active"] != 0.0 if "active" in values else np.ones(len(frame), bool)
    return timed(
        values["t"],
        whole_numbers(values["id"], "id", name, line),
        np.column_stack([values["x"], values["y"]]),
        kept,
        values.get("z", np.zeros(0)),
    )


def is_pathfinder_json(beginning: FileBeginning) -> bool:
    """Whether it is Pathfinder's JSON: persons by number, then times, with positions."""
    text = beginning.data[:4000].decode("utf-8", "replace")
    return beginning.kind == "text" and text.lstrip().startswith("{") and '"isActive"' in text


def read_pathfinder_json(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """Pathfinder's JSON. Raises InputError."""
    name = files[0].name
    try:
        persons = json.loads(read_text(name, files[0]))
    except RecursionError:
        raise InputError(f"{name} is nested too deep") from None
    except ValueError as error:
        raise InputError(f"{name} is not JSON: {shorten(str(error))}") from None
    rows = []
    try:
        for who, moments in persons.items():
            for moment, told in moments.items():
                place = told["position"]
                rows.append(
                    (float(moment), int(who), place["x"], place["y"], place["z"], told["isActive"])
                )
        values = np.array(rows, float).reshape(-1, 6)
    except (AttributeError, KeyError, TypeError, ValueError, OverflowError):
        raise InputError(
            f"{name} is damaged: a person needs a position and isActive at each time"
        ) from None
    if not len(values):
        raise InputError(f"{name} has no person")
    who = whole_numbers(values[:, 1], "id", name)
    return timed(values[:, 0], who, values[:, 2:4], values[:, 5] != 0.0, values[:, 4])


# Viswalk: comments, then a line of names that begins with $PEDESTRIAN:, apart by semicolons.

VISWALK = ("NO", "SIMSEC", "COORDCENTX", "COORDCENTY")


def viswalk_header(beginning: FileBeginning) -> int:
    """The place of its line of names; -1 if there is none."""
    for k, line in enumerate(beginning.lines):
        if line.startswith("$PEDESTRIAN:") and set(VISWALK) <= set(viswalk_names(line)):
            return k
    return -1


def viswalk_names(line: str) -> list[str]:
    """The names of columns in such a line."""
    return [name.strip() for name in line.removeprefix("$PEDESTRIAN:").split(";")]


def read_viswalk(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """Viswalk's pedestrian record. Raises InputError."""
    beginning = beginning_of(files[0])
    header = viswalk_header(beginning)
    names = viswalk_names(beginning.lines[header])
    used = [names.index(column) for column in VISWALK]
    frame = read_frame(
        beginning, header=None, skip=header + 1, used=sorted(used), separator=";", comment="*",
        width=len(names),
    )  # fmt: skip
    line = header + 2
    who, time, x, y = (numbers_of(frame, place, beginning.name, line) for place in used)
    return FileTracks(
        np.column_stack([x, y]),
        whole_numbers(who, "NO", beginning.name, line),
        time=time,
        unit="m",
        origin=BOTTOM_LEFT,
    )


CROWDIT = ("time", "pedID", "posX", "posY")


def read_crowdit(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """crowd:it's table. Raises InputError."""
    beginning = beginning_of(files[0])
    frame = read_frame(beginning, CROWDIT)
    time, who, x, y = (numbers_of(frame, column, beginning.name) for column in CROWDIT)
    return FileTracks(
        np.column_stack([x, y]),
        whole_numbers(who, "pedID", beginning.name),
        time=time,
        unit="m",
        origin=BOTTOM_LEFT,
    )


# Vadere: a row for each step of a person, at times of its own.


def vadere_line(beginning: FileBeginning) -> str:
    """Its line of names, behind comments; "" if there is none."""
    for line in beginning.lines[:10]:
        if line.startswith("pedestrianId simTime"):
            return line
        if not line.startswith("#"):
            break
    return ""


def read_vadere(files: Sequence[Path], options: ReadingOptions) -> FileTracks:
    """Vadere's steps, put into frames by PedPy along straight lines. Raises InputError."""
    name = files[0].name
    if options.rate is None:
        raise InputError(f"{name} has steps at times of their own, and no frames: give --rate")
    demand("pedpy", f"reading {name}", "tracks")
    import logging

    import pandas as pd
    import pedpy

    logging.getLogger("pedpy").setLevel(logging.ERROR)
    try:
        read = pedpy.load_trajectory_from_vadere(
            trajectory_file=files[0], frame_rate=options.rate, ignore_too_short_trajectories=True
        )
    except (ValueError, KeyError, TypeError, IndexError, OverflowError, MemoryError,
            pedpy.errors.PedPyError, pd.errors.ParserError) as error:  # fmt: skip
        reason = " ".join(str(error).split())
        raise InputError(f"{name} cannot be read: {shorten(reason)}") from None
    table = read.data
    tracks = FileTracks(
        table[["x", "y"]].to_numpy(float),
        table["id"].to_numpy(np.int64),
        table["frame"].to_numpy(np.int64),
        rate=options.rate,
        unit="m",
        origin=BOTTOM_LEFT,
        filled=np.ones(len(table), bool),
    )
    tracks.notes.append(
        f"steps at times of their own are put into {options.rate:g} frames per second along "
        "straight lines"
    )
    with suppress(AttributeError):
        logging.getLogger("pedpy").setLevel(logging.NOTSET)
    return tracks


READERS = (
    TrackReader(
        "pathfinder",
        "Pathfinder, table",
        (".csv",),
        lambda beginning: beginning.has_columns("t", "id", "x", "y", "active"),
        read_pathfinder,
    ),
    TrackReader(
        "pathfinder-json",
        "Pathfinder, JSON",
        (".json",),
        is_pathfinder_json,
        read_pathfinder_json,
    ),
    TrackReader(
        "vadere",
        "Vadere, postvis.traj",
        (".traj",),
        lambda beginning: bool(vadere_line(beginning)),
        read_vadere,
        needs=("--rate",),
    ),
    TrackReader(
        "viswalk",
        "Viswalk, pedestrian record",
        (".pp",),
        lambda beginning: viswalk_header(beginning) >= 0,
        read_viswalk,
    ),
    TrackReader(
        "crowdit",
        "crowd:it, table",
        (".csv",),
        lambda beginning: beginning.has_columns(*CROWDIT),
        read_crowdit,
    ),
)
