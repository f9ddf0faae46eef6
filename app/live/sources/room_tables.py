"""Recordings of rooms as text: Motive, Vicon Nexus and Tracker, TRC, QTM, ROS bags as CSV, TUM.

Each is told by what it holds, and becomes places of bodies or markers, frame by frame. Sources of
cars and readers of tracks both take them from here.

Sources: OptiTrack, Motive's data export, CSV; Vicon, ASCII export of Nexus and of Tracker; OpenSim,
`.trc` files; Qualisys, QTM's TSV export, 3D and 6D; `rostopic echo -p`; the RGB-D benchmark of TUM.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.live.control.pose import Pose, Sighting, seen, unseen
from app.live.sources.axes import UNITS, Axes
from app.live.sources.pose_source import RecordedFrame
from worlds.input_error import InputError, shorten, unknown

BEGINNING = 1 << 20
"""Bytes in which the names of all columns stand."""
MOST_NUMBERS = 300_000_000
MOST_BODIES = 10_000
WORDS_OF_UNITS = {
    "meters": "m", "metres": "m", "m": "m", "centimeters": "cm", "cm": "cm",
    "millimeters": "mm", "mm": "mm", "inches": "in", "in": "in", "feet": "ft", "ft": "ft",
}  # fmt: skip
LEAST_APART = 0.01
"""Metres between the two markers of a body below which they give no heading."""


@dataclass(frozen=True, slots=True)
class MarkedBody:
    """A body that two markers make."""

    name: str
    rear: str
    """The marker that says where the body is: on the rear axle."""
    front: str
    """The marker that says where its nose points."""


@dataclass(frozen=True, eq=False)
class RoomTrial:
    """Bodies or markers of a room, frame by frame, in the axes of its tracking system."""

    names: tuple[str, ...]
    position: np.ndarray
    """(T, B, 3) float64, NaN where one is not seen."""
    quaternion: np.ndarray | None
    """(T, B, 4), x, y, z, w, of bodies; None of markers."""
    frame: np.ndarray
    """(T,) int64, rising."""
    time: np.ndarray
    """(T,) float64, s, rising."""
    unit: str
    """Of places: m, cm, mm, in or ft; empty if the file does not say it."""
    title: str
    """What wrote it, for people."""
    start: float = 0.0
    """The time 0 by the clock of the recording, s."""

    def __post_init__(self) -> None:
        for k in np.flatnonzero(~(np.diff(self.time) > 0.0) | (np.diff(self.frame) <= 0))[:1]:
            raise InputError(
                f"its frame {self.frame[k + 1]} at {self.time[k + 1]:g} s comes after frame "
                f"{self.frame[k]} at {self.time[k]:g} s: frames and times rise"
            )
        twice = [name for name in self.names if self.names.count(name) > 1]
        if twice:
            raise InputError(f"it has {shorten(twice[0])} twice")


# Which of them a file is, by its first lines.


def first_lines(path: Path) -> list[str]:
    """The first lines of a text, without their ends; empty for what is none, or not there."""
    try:
        with path.open("rb") as file:
            data = file.read(BEGINNING)
    except OSError:  # whoever reads it tells so
        return []
    if b"\x00" in data:
        return []
    return data.decode("utf-8-sig", "replace").splitlines()


def kind_of_room(lines: Sequence[str]) -> str:
    """The name of the format that lines begin, one of READERS; empty for none of them.

    >>> kind_of_room(["Format Version,1.23,Take Name,walk"]), kind_of_room(["t,frame,name"])
    ('motive', '')
    """
    first = lines[0] if lines else ""
    cells = [cell.strip().strip('"') for cell in re.split("[,;\t]", first)]
    if cells[0] == "Format Version":
        return "motive"
    if cells[0] == "PathFileType":
        return "trc"
    if cells[0] == "NO_OF_FRAMES":
        return "qtm"
    if cells[0] == "%time":
        return "rosbag"
    for k, line in enumerate(lines[:-1]):
        word = line.strip().strip(",").strip('"')
        if word in VICON and lines[k + 1].split(",")[0].strip().replace(".", "").isdigit():
            return VICON[word]
    return "tum" if is_tum(lines) else ""


VICON = {"Trajectories": "nexus", "Objects": "tracker", "Segments": "tracker"}
"""The word that begins a block of a Vicon table -> its format."""


def is_tum(lines: Sequence[str]) -> bool:
    """Whether lines are times, places and rotations: eight numbers, four of length 1."""
    rows = [line.split() for line in lines[:50] if line.strip() and not line.startswith("#")]
    rows = rows[:-1] if len(rows) > 1 else rows
    if not rows or any(len(row) != 8 for row in rows):
        return False
    try:
        lengths = [math.hypot(*map(float, row[4:])) for row in rows]
    except ValueError:
        return False
    return all(abs(length - 1.0) < 0.01 for length in lengths)


# Tables of numbers under the names.


def read_numbers(
    path: Path, skip: int, width: int, separator: str = ",", rows: int | None = None
) -> np.ndarray:
    """The numbers (R, width) of a table behind `skip` lines, NaN where they are blank.

    Raises InputError for what is no number, and for more than `MOST_NUMBERS`.
    """
    import pandas as pd

    if width > 3 * MOST_BODIES + 100:
        raise InputError(f"{path.name} has {width} columns, too many to read")
    most = MOST_NUMBERS // max(width, 1) + 1
    try:
        frame = pd.read_csv(
            path, sep=separator, header=None, names=range(width), usecols=range(width),
            skiprows=skip, nrows=most if rows is None else min(rows, most), compression=None,
            skip_blank_lines=True, encoding="utf-8-sig", encoding_errors="replace",
            low_memory=False, skipinitialspace=True, index_col=False, comment="#",
        )  # fmt: skip
    except (ValueError, pd.errors.ParserError, OverflowError) as error:
        reason = " ".join(str(error).split()).removeprefix("Error tokenizing data. C error: ")
        raise InputError(f"{path.name} cannot be read: {reason[:150]}") from None
    if len(frame) >= most:
        raise InputError(f"{path.name} holds more than {MOST_NUMBERS} numbers")
    if not len(frame):
        raise InputError(f"{path.name} has no frames")
    table = np.empty(frame.shape)
    for k in range(width):
        column = frame[k]
        if column.dtype.kind not in "fiu":
            numbers = pd.to_numeric(column.astype(object), errors="coerce")
            for row in np.flatnonzero(numbers.isna() & column.notna())[:1]:
                raise InputError(
                    f"{path.name}, line {row + skip + 1}, column {k + 1}: "
                    f"{shorten(str(column.iloc[row]))} is not a number"
                )
            column = numbers
        table[:, k] = column
    return table


def cells_of(line: str, separator: str = ",") -> list[str]:
    """The cells of a line of names, without quotes and blanks around."""
    return [cell.strip().strip('"').strip() for cell in line.split(separator)]


def filled_right(cells: Sequence[str]) -> list[str]:
    """Cells with each name over all columns up to the next."""
    names, name = [], ""
    for cell in cells:
        name = cell or name
        names.append(name)
    return names


def unit_in(word: str) -> str:
    """The unit that a word stands for, empty for none."""
    return WORDS_OF_UNITS.get(word.strip().lower(), "")


def rate_in(text: str, path: Path) -> float:
    """Frames per second that a text says. Raises InputError."""
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    if not 0.0 < rate < math.inf:
        raise InputError(f"{path.name}: {shorten(text)} is not a number of frames per second")
    return rate


def columns_of_bodies(
    table: np.ndarray, groups: dict[str, dict[str, int]], axes: Sequence[str]
) -> np.ndarray:
    """Some columns of each body, (T, B, len(axes)), NaN for a body that lacks one."""
    blank = np.full(len(table), np.nan)
    return np.stack(
        [
            np.column_stack([table[:, held[axis]] if axis in held else blank for axis in axes])
            for held in groups.values()
        ],
        axis=1,
    )


def numbered(table: np.ndarray, path: Path) -> np.ndarray:
    """The first column as numbers of frames. Raises InputError."""
    frame = table[:, 0]
    if not np.isfinite(frame).all() or (np.abs(frame) > 2**53).any():
        raise InputError(f"{path.name}: its first column is not a number of a frame everywhere")
    return frame.astype(np.int64)


# Motive.


def read_motive(path: Path, lines: Sequence[str]) -> RoomTrial:
    """Motive's CSV: rigid bodies if there are any, else markers. Raises InputError."""
    told = cells_of(lines[0])
    facts = dict(zip(told[::2], told[1::2], strict=False))
    header = next((k for k, line in enumerate(lines[:20]) if line.startswith("Frame,")), None)
    if header is None or header < 4:
        raise InputError(f"{path.name} has no row of columns that begins with Frame")
    rows = [cells_of(line) for line in lines[1 : header + 1]]
    by_word = {word: row for row in rows[:-1] for word in row[:2] if word in ("Type", "Name")}
    kinds, names = by_word.get("Type"), by_word.get("Name")
    axes, components = rows[-1], rows[-2]
    if kinds is None or names is None:
        raise InputError(f"{path.name} has no rows of types and names")
    width = min(map(len, (kinds, names, axes, components)))
    has_bodies = "Rigid Body" in kinds
    wanted = ("Rigid Body",) if has_bodies else ("Marker", "Rigid Body Marker", "Bone Marker")
    groups: dict[str, dict[str, int]] = {}
    for k in range(2, width):
        if kinds[k] in wanted and components[k] in ("Position", "Rotation"):
            part = axes[k].lower() if components[k] == "Position" else f"q{axes[k].lower()}"
            groups.setdefault(names[k], {})[part] = k
    if not groups:
        raise InputError(f"{path.name} has neither rigid bodies nor markers")
    table = read_numbers(path, header + 1, len(axes))
    rotation = facts.get("Rotation Type", "Quaternion")
    is_turned = has_bodies and all({"qx", "qy", "qz", "qw"} <= set(one) for one in groups.values())
    rate = facts.get("Export Frame Rate") or facts.get("Capture Frame Rate") or ""
    frame = numbered(table, path)
    return RoomTrial(
        tuple(groups),
        columns_of_bodies(table, groups, "xyz"),
        columns_of_bodies(table, groups, ("qx", "qy", "qz", "qw"))
        if is_turned and rotation == "Quaternion"
        else None,
        frame,
        frame / rate_in(rate, path) if not np.isfinite(table[:, 1]).all() else table[:, 1],
        unit_in(facts.get("Length Units", "")),
        "Motive",
    )


# Vicon: blocks of a word, a rate, names over columns, columns and units.


def read_vicon(path: Path, lines: Sequence[str]) -> RoomTrial:
    """The block of Nexus's trajectories, or of Tracker's objects. Raises InputError."""
    start = next(k for k, line in enumerate(lines) if line.strip().strip(',"') in VICON)
    is_tracker = VICON[lines[start].strip().strip(',"')] == "tracker"
    if len(lines) < start + 6:
        raise InputError(f"{path.name} ends before its first frame")
    rate = rate_in(cells_of(lines[start + 1])[0], path)
    names = filled_right(cells_of(lines[start + 2]))
    columns, units = cells_of(lines[start + 3]), cells_of(lines[start + 4])
    if columns[:2] != ["Frame", "Sub Frame"]:
        raise InputError(f"{path.name}, line {start + 4}: Frame,Sub Frame is needed")
    groups: dict[str, dict[str, int]] = {}
    for k in range(2, len(columns)):
        name = names[k] if k < len(names) else names[-1]
        if name and re.fullmatch(r"[RT]?[XYZ]|RW", columns[k]):
            part = columns[k].lower()
            groups.setdefault(body_name(name), {}).setdefault(part.removeprefix("t"), k)
    if not groups:
        raise InputError(f"{path.name}, line {start + 3}: no name of a body or marker is in it")
    first = next(iter(groups.values()))
    unit = units[first["x"]] if "x" in first and first["x"] < len(units) else ""
    table = read_numbers(path, start + 5, len(columns), rows=rows_of_block(path, start + 5))
    # A sub frame is a sample of a device between two frames of the cameras.
    table = table[np.nan_to_num(table[:, 1]) == 0.0]
    frame = numbered(table, path)
    turned = None
    if is_tracker and {"rx", "ry", "rz"} <= set(first):
        angles = units[first["rx"]] if first["rx"] < len(units) else ""
        turned = rotations_of(table, groups, angles)
    return RoomTrial(
        tuple(groups),
        columns_of_bodies(table, groups, "xyz"),
        turned,
        frame,
        frame / rate,
        unit_in(unit),
        "Vicon Tracker" if is_tracker else "Vicon Nexus",
    )


def body_name(name: str) -> str:
    """A name without that of its subject, if both are the same, as Tracker repeats it.

    >>> body_name("car1:car1"), body_name("Anna:LANK")
    ('car1', 'Anna:LANK')
    """
    subject, _, own = name.partition(":")
    return own if own == subject else name


def rotations_of(table: np.ndarray, groups: dict[str, dict[str, int]], unit: str) -> np.ndarray:
    """Quaternions (T, B, 4) of Tracker, which writes them or vectors along the axis of a turn."""
    if all("rw" in held for held in groups.values()):
        return columns_of_bodies(table, groups, ("rx", "ry", "rz", "rw"))
    vector = columns_of_bodies(table, groups, ("rx", "ry", "rz"))
    vector = np.radians(vector) if unit == "deg" else vector
    half = 0.5 * np.linalg.norm(vector, axis=2, keepdims=True)
    # sinc is finite where there is no turn: sin(half) / (2 half) of the vector
    return np.concatenate([0.5 * np.sinc(half / np.pi) * vector, np.cos(half)], axis=2)


def rows_of_block(path: Path, skip: int) -> int:
    """How many lines there are behind `skip` lines up to the next blank one, or to the end."""
    count = 0
    with path.open("rb") as file:
        for number, line in enumerate(file):
            if number < skip:
                continue
            if not line.strip().strip(b","):
                break
            count += 1
    return count


# TRC and QTM: tabs between columns.


def read_trc(path: Path, lines: Sequence[str]) -> RoomTrial:
    """A table of OpenSim and others. Raises InputError."""
    if len(lines) < 5:
        raise InputError(f"{path.name} ends before its first frame")
    facts = dict(zip(cells_of(lines[1], "\t"), cells_of(lines[2], "\t"), strict=False))
    names = cells_of(lines[3], "\t")
    if names[:2] != ["Frame#", "Time"]:
        raise InputError(f"{path.name}, line 4: Frame# and Time are needed")
    markers = [name for name in names[2:] if name]
    if not markers:
        raise InputError(f"{path.name}, line 4: there is no name of a marker")
    groups = {
        name: {axis: 2 + 3 * k + place for place, axis in enumerate("xyz")}
        for k, name in enumerate(dict.fromkeys(markers))
    }
    if len(groups) < len(markers):
        raise InputError(f"{path.name}, line 4: a marker is twice in it")
    table = read_numbers(path, 5, 2 + 3 * len(markers), "\t")
    frame = numbered(table, path)
    rate = rate_in(facts.get("DataRate", ""), path)
    return RoomTrial(
        tuple(groups),
        columns_of_bodies(table, groups, "xyz"),
        None,
        frame,
        table[:, 1] if np.isfinite(table[:, 1]).all() else frame / rate,
        unit_in(facts.get("Units", "")),
        "TRC",
    )


def read_qtm(path: Path, lines: Sequence[str]) -> RoomTrial:
    """QTM's table, of markers (3D) or of bodies (6D), in mm. Raises InputError."""
    facts: dict[str, list[str]] = {}
    start = len(lines)
    for k, line in enumerate(lines[:60]):
        cells = cells_of(line, "\t")
        if not re.fullmatch("[A-Z][A-Z_]+", cells[0]):
            start = k
            break
        facts[cells[0]] = cells[1:]
    names = [name for name in facts.get("MARKER_NAMES", facts.get("BODY_NAMES", ())) if name]
    if not names:
        raise InputError(f"{path.name} has neither MARKER_NAMES nor BODY_NAMES")
    header = cells_of(lines[start], "\t") if start < len(lines) else []
    has_header = any(cell and not is_number(cell) for cell in header)
    lead = 2 if has_header and header[:1] == ["Frame"] else 0
    is_body = "BODY_NAMES" in facts and "MARKER_NAMES" not in facts
    width = 16 if is_body else 3  # x, y, z, three angles, a residual, nine of a matrix
    if is_body and not lead and len(header) >= len(names) * 17:
        width = 17  # a blank column between bodies
    total = lead + width * len(names)
    table = read_numbers(path, start + has_header, total, "\t")
    block = table[:, lead:].reshape(len(table), len(names), width)
    position = block[:, :, :3].copy()
    position[(position == 0.0).all(axis=2)] = np.nan  # how older versions write a gap
    rate = rate_in((facts.get("FREQUENCY") or [""])[0], path)
    frame = numbered(table, path) if lead else np.arange(1, len(table) + 1)
    return RoomTrial(
        tuple(names),
        position,
        quaternions(block[:, :, 7:16]) if is_body else None,
        frame,
        frame / rate,
        "mm",
        "QTM",
    )


def is_number(text: str) -> bool:
    """Whether a cell is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def quaternions(matrix: np.ndarray) -> np.ndarray:
    """Rotations (T, B, 9), row by row as QTM writes them by columns, as quaternions (T, B, 4)."""
    from scipy.spatial.transform import Rotation

    turned = np.full((*matrix.shape[:2], 4), np.nan)
    square = matrix.reshape(*matrix.shape[:2], 3, 3).swapaxes(2, 3)
    sound = np.isfinite(square).all(axis=(2, 3))
    sound &= np.where(sound, np.abs(np.linalg.det(np.nan_to_num(square)) - 1.0) < 0.05, False)
    if sound.any():
        turned[sound] = Rotation.from_matrix(square[sound]).as_quat()
    return turned


# ROS and TUM: one body in a file, which is called as the file.

ROS_PLACES = ("pose.position", "pose.pose.position", "transform.translation")
ROS_TURNS = ("pose.orientation", "pose.pose.orientation", "transform.rotation")


def read_rosbag(path: Path, lines: Sequence[str]) -> RoomTrial:
    """Poses of a bag as `rostopic echo -p` writes them, in m and ns. Raises InputError."""
    import pandas as pd

    columns = cells_of(lines[0])
    place = next((one for one in ROS_PLACES if f"field.{one}.x" in columns), "")
    turn = ROS_TURNS[ROS_PLACES.index(place)] if place else ""
    if not place:
        raise InputError(f"{path.name} has no column field.pose.position.x")
    stamp = "field.header.stamp" if "field.header.stamp" in columns else "%time"
    wanted = [stamp, *(f"field.{place}.{axis}" for axis in "xyz")]
    turns = [f"field.{turn}.{axis}" for axis in "xyzw"]
    has_turns = set(turns) <= set(columns)
    wanted += turns if has_turns else []
    try:
        frame = pd.read_csv(path, usecols=wanted, compression=None, low_memory=False)
        table = frame[wanted].to_numpy(float)
    except (ValueError, pd.errors.ParserError, KeyError, UnicodeDecodeError) as error:
        raise InputError(f"{path.name} cannot be read: {shorten(str(error), 150)}") from None
    if not len(table) or not np.isfinite(table[:, 0]).all():
        raise InputError(f"{path.name} has no poses with times")
    return single_body(path, 1e-9 * table[:, 0], table[:, 1:], "a ROS bag")


def read_tum(path: Path, _: Sequence[str]) -> RoomTrial:
    """Times in s, places in m and quaternions. Raises InputError."""
    table = read_numbers(path, 0, 8, r"\s+")
    if not np.isfinite(table[:, 0]).all():
        raise InputError(f"{path.name} has a row without a time")
    return single_body(path, table[:, 0], table[:, 1:], "TUM")


def single_body(path: Path, time: np.ndarray, table: np.ndarray, title: str) -> RoomTrial:
    """One body, of rows of a place and perhaps a quaternion (R, 3 or 7); the order is by time."""
    order = np.argsort(time, kind="stable")
    order = order[np.concatenate([[True], np.diff(time[order]) > 0.0])]
    quaternion = table[order, None, 3:7] if table.shape[1] == 7 else None
    return RoomTrial(
        (path.stem,),
        table[order, None, :3],
        quaternion,
        np.arange(len(order)),
        time[order] - time[order[0]],
        "m",
        title,
        float(time[order[0]]),
    )


READERS: dict[str, Callable[[Path, Sequence[str]], RoomTrial]] = {
    "motive": read_motive,
    "nexus": read_vicon,
    "tracker": read_vicon,
    "trc": read_trc,
    "qtm": read_qtm,
    "rosbag": read_rosbag,
    "tum": read_tum,
}
"""The formats by name."""


def read_room_table(path: Path) -> RoomTrial:
    """The places of a recording of a room. Raises InputError for what is none, or is damaged."""
    if not path.is_file():
        raise InputError(f"{path} cannot be read: there is no such file")
    lines = first_lines(path)
    kind = kind_of_room(lines)
    if not kind:
        raise InputError(f"{path} is in no format of a room that is known: {', '.join(READERS)}")
    try:
        return READERS[kind](path, lines)
    except InputError as refusal:
        message = str(refusal)
        if path.name in message:
            raise
        raise InputError(f"{path.name}: {message}") from None
    except (ValueError, IndexError, KeyError, OverflowError, StopIteration, OSError) as error:
        raise InputError(f"{path.name} is damaged: {shorten(str(error), 120)}") from None


# As a source of cars.


def trial_frames(
    path: Path, trial: RoomTrial, axes: Axes, bodies: tuple[MarkedBody, ...]
) -> list[RecordedFrame]:
    """The frames of a trial, its bodies by their rotations or by two markers each.

    The unit of `axes` counts. Raises InputError if nothing makes a body.
    """
    if not bodies and trial.quaternion is None:
        raise InputError(
            f"{path} has no rotations: say which markers make a body, as body=NAME,REAR,FRONT "
            f"(its markers: {', '.join(trial.names[:50])})"
        )
    for body in bodies:
        for marker in (body.rear, body.front):
            if marker not in trial.names:
                raise unknown("marker", marker, trial.names, str(path))
    return list(_marked_frames(trial, axes, bodies) if bodies else _turned_frames(trial, axes))


def _marked_frames(
    trial: RoomTrial, axes: Axes, bodies: tuple[MarkedBody, ...]
) -> Iterator[RecordedFrame]:
    pairs = [(body.name, trial.names.index(body.rear), trial.names.index(body.front))
             for body in bodies]  # fmt: skip
    for places, number, time in zip(trial.position, trial.frame, trial.time, strict=True):
        sightings = tuple(
            marked_sighting(name, places[rear], places[front], axes) for name, rear, front in pairs
        )
        yield RecordedFrame(float(time), int(number), sightings)


def marked_sighting(name: str, rear: Any, front: Any, axes: Axes) -> Sighting:
    """A body in one frame, from its two markers (3,)."""
    x, y = axes.floor(rear)
    ahead, aside = axes.floor(front)
    apart = math.hypot(ahead - x, aside - y)
    if not LEAST_APART <= apart < math.inf:  # nor where one of them is NaN
        return unseen(name)
    return seen(name, Pose(x, y, math.atan2(aside - y, ahead - x)))


def _turned_frames(trial: RoomTrial, axes: Axes) -> Iterator[RecordedFrame]:
    assert trial.quaternion is not None
    for places, turns, number, time in zip(
        trial.position.tolist(), trial.quaternion.tolist(), trial.frame, trial.time, strict=True
    ):
        sightings, ups = [], {}
        for name, place, turn in zip(trial.names, places, turns, strict=True):
            if math.isfinite(sum(place)) and math.isfinite(sum(turn)):
                sightings.append(axes.sighting(name, place, turn))
                up = axes.up_in_body(turn)
                if up is not None:
                    ups[name] = up
            else:
                sightings.append(unseen(name))
        yield RecordedFrame(float(time), int(number), tuple(sightings), ups)


def unit_of_trial(path: Path, says: str, declared: str, where: str = "") -> str:
    """The unit of a recording: what it says, or what is declared where it says none that is known.

    Raises InputError where neither does, and where they differ.
    """
    place = f" ({where})" if where else ""
    if says in UNITS and declared not in ("", says):
        raise InputError(f"unit = {declared} is declared, but {path} is in {says}{place}")
    if says not in UNITS and not declared:
        lacks = f"has the unknown unit of length {shorten(says)}" if says else "has no unit"
        raise InputError(
            f"{path} {lacks}{place}: declare that of its numbers, ?unit={', '.join(UNITS)}"
        )
    return says if says in UNITS else declared
