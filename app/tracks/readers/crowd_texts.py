"""Crowds as text: PeTrack and JuPedSim, ETH and UCY, PedPy's table, CITR's folders.

Sources: PeTrack and JuPedSim, https://www.jupedsim.org; Pellegrini et al. (2009) for ETH; Lerner et
al. (2007) for UCY; PedPy, https://pedpy.readthedocs.io; Yang et al. (2019) for CITR.

PedPy reads some of these too. It is not used here: importing it takes seconds, it makes an object
of each place, drops z, takes "in mm" for metres and refuses a rate that is given beside that of the
file.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.readers.text_columns import (
    beginning_of,
    numbers_of,
    read_frame,
    whole_numbers,
)
from app.tracks.readers.track_reader import BOTTOM_LEFT, FileTracks, ReadingOptions, TrackReader
from worlds.input_error import InputError

RATE = re.compile(r"frame\s*rate\s*[:=]?\s*([0-9]+(?:\.[0-9]*)?)", re.IGNORECASE)
UNIT = re.compile(r"\bx\s*[/\[(]\s*(mm|cm|m)\b|\bin\s+(mm|cm|m|meters?|metres?)\b", re.IGNORECASE)
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|nan", re.IGNORECASE)
LOOKED_AT = 200
"""Rows by which a table without names is told."""


def comment_lines(beginning: FileBeginning) -> list[str]:
    """The lines at the beginning that are comments."""
    lines = []
    for line in beginning.lines:
        if line.strip() and not line.lstrip().startswith("#"):
            break
        lines.append(line)
    return lines


def first_numbers(beginning: FileBeginning) -> np.ndarray | None:
    """The first rows of a table of blanks and numbers alone, (R, C); None if it is none."""
    rows: list[list[float]] = []
    for line in beginning.lines[len(comment_lines(beginning)) :]:
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        words = line.split()
        if len(words) != len(rows[0] if rows else words) or not all(
            NUMBER.fullmatch(word) for word in words
        ):
            return None
        rows.append([float(word) for word in words])
        if len(rows) == LOOKED_AT:
            break
    return np.array(rows) if rows else None


def header_names(beginning: FileBeginning) -> list[str]:
    """The names of columns in the last comment that has them, lower case, without units."""
    for line in reversed(comment_lines(beginning)):
        words = [re.split(r"[/\[(]", word)[0].lower() for word in line.lstrip("# \t").split()]
        if {"x", "y"} <= set(words) and any("id" in word for word in words[:2]):
            return words
    return []


def is_crowd_text(beginning: FileBeginning) -> bool:
    """Whether its rows are id, frame, x, y and perhaps more.

    Without a line of names it is told by its rows: one person after the other, each with rising
    frames; other files have the frame first.
    """
    rows = first_numbers(beginning)
    if rows is None or rows.shape[1] < 4 or (rows[:, :2] != np.round(rows[:, :2])).any():
        return False
    names = header_names(beginning)
    if names:
        return "id" in names[0] and names[1].startswith("fr")
    if rows.shape[1] not in (4, 5):
        return False
    same = np.diff(rows[:, 0]) == 0
    return bool(same.mean() > 0.5 and (np.diff(rows[:, 1])[same] > 0).all()) if len(same) else False


def read_crowd_text(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """A table of PeTrack or JuPedSim without z, often a person's height. Raises InputError."""
    beginning = beginning_of(files[0])
    name, comments = beginning.name, comment_lines(beginning)
    rows = first_numbers(beginning)
    if rows is None:
        raise InputError(f"{name} is no table of numbers")
    names = header_names(beginning)
    angle = names.index("angle") if "angle" in names and len(names) == rows.shape[1] else None
    x, y = (names.index("x"), names.index("y")) if names else (2, 3)
    used = sorted({0, 1, x, y} | ({angle} if angle is not None else set()))
    frame = read_frame(
        beginning, header=None, used=used, comment="#", separator="", width=rows.shape[1]
    )
    line = len(comments) + 1
    columns = {k: numbers_of(frame, k, name, line) for k in used}
    told = [match for comment in comments if (match := RATE.search(comment))]
    units = [match for comment in comments if (match := UNIT.search(comment))]
    unit = (units[-1][1] or units[-1][2]).lower() if units else ""
    heading = None
    if angle is not None:
        turned = np.radians(columns[angle])
        heading = np.column_stack([np.cos(turned), np.sin(turned)])
    return FileTracks(
        np.column_stack([columns[x], columns[y]]),
        whole_numbers(columns[0], "id", name, line),
        whole_numbers(columns[1], "frame", name, line),
        rate=float(told[0][1]) if told and float(told[0][1]) > 0.0 else None,
        unit=unit if unit in ("mm", "cm") else "m" if unit else "",
        origin=BOTTOM_LEFT,
        heading=heading,
    )


# ETH and UCY: frame id x z y vx vz vy, so that the third column of places is y.


def is_obsmat(beginning: FileBeginning) -> bool:
    """Whether it is an obsmat.txt: eight numbers, z and its velocity 0, the rest no rotation."""
    rows = first_numbers(beginning)
    if rows is None or rows.shape[1] != 8:
        return False
    whole = (rows[:, :2] == np.round(rows[:, :2])).all()
    return bool(whole and (rows[:, [3, 6]] == 0.0).all())


def read_obsmat(files: Sequence[Path], options: ReadingOptions) -> FileTracks:
    """The table of ETH and UCY, in metres. Raises InputError, which tells the rate if it can."""
    beginning = beginning_of(files[0])
    name = beginning.name
    frame = read_frame(beginning, header=None, separator="", width=8)
    number, individual, x, _, y, v_x, _, v_y = (
        numbers_of(frame, k, name, 1) for k in range(8)
    )  # fmt: skip
    number, individual = whole_numbers(number, "frame", name), whole_numbers(individual, "id", name)
    position = np.column_stack([x, y])
    if options.rate is None:
        told = rate_of_velocities(number, individual, position, np.column_stack([v_x, v_y]))
        hint = f" (its places and velocities fit {told:.4g})" if told else ""
        raise InputError(f"{name} says no frames per second: give --rate{hint}")
    return FileTracks(position, individual, number, unit="m", origin=BOTTOM_LEFT)


def rate_of_velocities(
    frame: np.ndarray, individual: np.ndarray, position: np.ndarray, velocity: np.ndarray
) -> float:
    """Frames per second by which velocities, per s, fit the steps between rows; 0 if none do."""
    order = np.lexsort((frame, individual))
    frame, individual = frame[order], individual[order]
    same = individual[1:] == individual[:-1]
    steps = np.linalg.norm(np.diff(position[order], axis=0)[same], axis=1)
    speeds = np.linalg.norm(velocity[order][1:][same], axis=1)
    frames = np.diff(frame)[same]
    moving = (speeds > 0.2) & (steps > 0.0) & (frames > 0)
    if moving.sum() < 10:
        return 0.0
    return float(np.median(speeds[moving] * frames[moving] / steps[moving]))


def refuse_splines(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """Say why splines are not tracks. Raises InputError."""
    raise InputError(
        f"{files[0].name} holds splines through points that were clicked, in pixels, and no place "
        "per frame: read the obsmat.txt of the same scene"
    )


# Tables with names.


def read_pedpy(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """A table of PedPy's examples, ID, Frame, x, y, in metres. Raises InputError."""
    beginning = beginning_of(files[0])
    frame = read_frame(beginning, ["ID", "Frame", "x", "y"])
    return rows_of(frame, beginning.name, "ID", "Frame", "x", "y")


def rows_of(frame: Any, name: str, who: str, when: str, x: str, y: str) -> FileTracks:
    """Tracks in metres of four columns. Raises InputError."""
    columns = {column: numbers_of(frame, column, name) for column in (who, when, x, y)}
    return FileTracks(
        np.column_stack([columns[x], columns[y]]),
        whole_numbers(columns[who], who, name),
        whole_numbers(columns[when], when, name),
        unit="m",
        origin=BOTTOM_LEFT,
    )


CITR = ("frame", "id", "x", "y", "type")
FILTERED = ("id", "frame", "label", "x_est", "y_est")


def read_citr(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """The persons of one clip of CITR, a file for each. Raises InputError.

    Its places are metres already: the scale in the file beside them was used for it. They are in
    the axes of the picture of a drone, in which nothing says where up is.
    """
    parts = []
    for path in files:
        beginning = beginning_of(path)
        filtered = beginning.has_columns(*FILTERED)
        x, y = ("x_est", "y_est") if filtered else ("x", "y")
        frame = read_frame(beginning, ["id", "frame", x, y])
        parts.append(rows_of(frame, path.name, "id", "frame", x, y))
    numbers = [part.frame for part in parts if part.frame is not None]
    return FileTracks(
        np.concatenate([part.position for part in parts]),
        np.concatenate([np.asarray(part.ids) for part in parts]),
        np.concatenate(numbers),
        unit="m",
    )


READERS = (
    TrackReader(
        "petrack",
        "PeTrack and JuPedSim text",
        (".txt",),
        is_crowd_text,
        read_crowd_text,
    ),
    TrackReader(
        "obsmat",
        "ETH and UCY, obsmat.txt",
        (".txt",),
        is_obsmat,
        read_obsmat,
        needs=("--rate",),
    ),
    TrackReader(
        "vsp",
        "UCY, splines: refused",
        (".vsp",),
        lambda beginning: bool(re.match(r"\s*\d+\s*-\s*the number of splines", beginning.first)),
        refuse_splines,
    ),
    TrackReader(
        "pedpy",
        "PedPy, table",
        (".csv",),
        lambda beginning: beginning.has_columns("ID", "Frame", "x", "y"),
        read_pedpy,
        needs=("--rate",),
    ),
    TrackReader(
        "citr",
        "CITR, a file for each person",
        (".csv",),
        lambda beginning: beginning.columns == CITR or beginning.has_columns(*FILTERED),
        read_citr,
        needs=("--rate", "--origin"),
        takes_several=True,
    ),
)
