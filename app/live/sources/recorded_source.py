"""A recording as a source: a C3D trial, a table of poses, or what tracking systems export."""

from __future__ import annotations

import csv
import math
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import count, groupby
from pathlib import Path
from typing import Any, NamedTuple

from agents.recordings.parquet_table import ParquetTable
from app.live.control.plausibility import BodyReport, Swap, judge_bodies
from app.live.control.pose import MocapFrame, Sighting, unseen
from app.live.control.safety_limits import CarLimits, SafetyLimits
from app.live.sources.axes import NOSES, UPS, Axes
from app.live.sources.c3d_trial import read_trial
from app.live.sources.pose_source import RecordedFrame, tracks_of
from app.live.sources.room_tables import (
    MarkedBody,
    first_lines,
    kind_of_room,
    read_room_table,
    trial_frames,
    unit_of_trial,
)
from app.live.sources.source_address import AXES, Address
from worlds.input_error import InputError, unknown

# A table of poses, CSV or Parquet: one row for each body in each frame.
#
# Columns, in any order: t (seconds), frame (whole number), name, x, y, z, qx, qy, qz, qw, valid (1
# or 0, true or false). Rows of one frame stand together, with one t; frame and t rise. A row that
# is not valid may leave its pose empty: a gap stays a gap. Where the file's maker wrote quaternions
# w first, the four columns qx to qw hold w, x, y, z.

POINT = ("x", "y", "z")
QUATERNION = ("qx", "qy", "qz", "qw")
COLUMNS = ("t", "frame", "name", *POINT, *QUATERNION, "valid")

ORDERS = ("xyzw", "wxyz")
"""In which a quaternion may stand in its four columns."""
TRUTH = {"1": True, "true": True, "0": False, "false": False}


class _Row(NamedTuple):
    where: str
    """File and line, for what is said of it."""
    time: float
    number: int
    sighting: Sighting
    up: tuple[float, float, float] | None
    """The room's up in the axes of the body, if the row has a pose."""


def read_table(path: Path, axes: Axes, order: str = "xyzw") -> list[RecordedFrame]:
    """The frames of a CSV or Parquet table of poses, in order; `order` is one of `ORDERS`.

    Raises InputError naming the line (or row) and column of the first thing that is wrong.
    """
    named_rows = _of_parquet(path) if path.suffix.lower() == ".parquet" else _of_csv(path)
    rows = (_row(values, where, axes, order) for where, values in named_rows)
    frames: list[RecordedFrame] = []
    for number, together in groupby(rows, key=lambda row: row.number):
        frame = _frame(number, list(together), frames[-1] if frames else None)
        frames.append(frame)
    if not frames:
        raise InputError(f"{path} has no rows")
    return frames


def _frame(number: int, rows: list[_Row], before: RecordedFrame | None) -> RecordedFrame:
    """The rows of one frame, which must agree with each other and follow the frame before."""
    first = rows[0]
    if before is not None and number < before.number:
        raise InputError(
            f"{first.where}: frame = {number} comes after frame {before.number}: frames must rise"
        )
    if before is not None and first.time <= before.time:
        raise InputError(
            f"{first.where}: t = {first.time:g} does not come after {before.time:g}, "
            "that of the frame before"
        )
    names: set[str] = set()
    for row in rows:
        if row.time != first.time:
            raise InputError(
                f"{row.where}: t = {row.time:g}, but frame {number} began with t = {first.time:g}"
            )
        if row.sighting.name in names:
            raise InputError(f"{row.where}: {row.sighting.name!r} is twice in frame {number}")
        names.add(row.sighting.name)
    return RecordedFrame(
        first.time,
        number,
        tuple(row.sighting for row in rows),
        {row.sighting.name: row.up for row in rows if row.up is not None},
    )


def _row(values: dict[str, Any], where: str, axes: Axes, order: str) -> _Row:
    time = _number(values, "t", where)
    number = _number(values, "frame", where)
    if number != int(number):
        raise InputError(f"{where}, column frame: {values['frame']!r} is not a whole number")
    name = str(values["name"] or "").strip()
    if not name:
        raise InputError(f"{where}, column name: it is empty")
    word = str(values["valid"]).strip().lower()
    if word not in TRUTH:
        raise InputError(
            f"{where}, column valid: {values['valid']!r} is none of {', '.join(TRUTH)}"
        )
    if not TRUTH[word]:
        return _Row(where, time, int(number), unseen(name), None)
    return _Row(where, time, int(number), *_orientation(name, values, where, axes, order))


def _orientation(
    name: str, values: dict[str, Any], where: str, axes: Axes, order: str
) -> tuple[Sighting, tuple[float, float, float]]:
    """A body that the row says is tracked, which therefore must have a whole pose, and its up."""
    point = [_number(values, column, where) for column in POINT]
    quaternion = [_number(values, column, where) for column in QUATERNION]
    if order == "wxyz":
        quaternion = [*quaternion[1:], quaternion[0]]
    up = axes.up_in_body(quaternion)
    if up is None:
        length = math.hypot(*quaternion)
        raise InputError(
            f"{where}, columns qx to qw: a quaternion of length {length:.3g} is no rotation, "
            "which has length 1"
        )
    return axes.sighting(name, point, quaternion), up


def _number(values: dict[str, Any], column: str, where: str) -> float:
    value = values[column]
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        reason = "it is empty" if value in ("", None) else f"{value!r} is not a number"
        raise InputError(f"{where}, column {column}: {reason}")
    return number


def _of_csv(path: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """The rows of a CSV file and where each stands."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, strict=True)
            _check_columns(path, reader.fieldnames or [])
            for values in reader:
                where = f"{path}, line {reader.line_num}"
                if None in values or None in values.values():
                    columns = len(reader.fieldnames or [])
                    raise InputError(
                        f"{where}: it does not have {columns} columns, as the first line"
                    )
                yield where, values
    except OSError as trouble:
        raise InputError(f"{path} cannot be read: {trouble.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is not a CSV file in UTF-8") from None
    except csv.Error as trouble:
        raise InputError(f"{path}, line {reader.reader.line_num}: {trouble}") from None


def _of_parquet(path: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """The rows of a Parquet file and where each stands, the first being row 1."""
    file = ParquetTable(path, None, "a Parquet file")
    _check_columns(path, file.names)
    number = 0
    for batch in file.batches(COLUMNS):
        for values in batch.to_pylist():
            number += 1
            yield f"{path}, row {number}", values


def _check_columns(path: Path, columns: list[str] | Any) -> None:
    missing = [column for column in COLUMNS if column not in columns]
    if missing:
        raise InputError(f"{path} has no column {', '.join(missing)}: a table of poses needs "
                      f"{', '.join(COLUMNS)}")  # fmt: skip
    twice = [column for column in COLUMNS if list(columns).count(column) > 1]
    if twice:
        raise InputError(f"{path} has the column {twice[0]} twice")


ROOMS = (".trc", ".tsv", ".txt")
"""How files of tracking systems end that are no tables of poses."""
SUFFIXES = (".c3d", ".csv", ".parquet", *ROOMS)


@dataclass(frozen=True)
class RecordedSource:
    """A recording that is played.

    Raises InputError for a file of another kind or a factor that is none.
    """

    path: Path
    axes: Axes = field(default_factory=Axes)
    """How the recording system was set up; the unit of a C3D file is its own."""
    bodies: tuple[MarkedBody, ...] = ()
    """Of a file of markers: which two make a body; empty: its rotations are the bodies."""
    factor: float = 1.0
    """How many times faster than it was recorded."""
    again: bool = False
    """Whether it begins anew after its end."""
    unit: str = ""
    """Of a file that says none: its unit of length, as declared; empty if it is not."""
    quaternion: str = ""
    """Of a table: the order of its quaternions, one of `ORDERS`; empty if it is not declared, and
    then they are read with w last."""
    name: str = "recorded"
    longest_gap: float = math.inf

    def __post_init__(self) -> None:
        suffix = self.path.suffix.lower()
        if suffix not in SUFFIXES:
            raise unknown("kind of recording", suffix, SUFFIXES, str(self.path))
        if self.bodies and not self.may_have_markers:
            raise InputError(f"{self.path} holds poses, not markers: it has no use for body=")
        if self.quaternion and suffix == ".c3d":
            raise InputError(f"{self.path} holds no quaternions: it has no use for quaternion=")
        if self.quaternion not in ("", *ORDERS):
            raise unknown("order of quaternions", self.quaternion, ORDERS)
        if not 0.0 < self.factor < math.inf:
            raise InputError(f"factor = {self.factor:g} is not a positive number")

    @property
    def may_have_markers(self) -> bool:
        """Whether it is no table of poses."""
        return self.path.suffix.lower() == ".c3d" or bool(kind_of_room(first_lines(self.path)))

    def describe(self) -> str:
        """What it is in a few words."""
        speed = "" if self.factor == 1.0 else f", {self.factor:g} times as fast"
        return f"{self.path.name}{speed}{', over and over' if self.again else ''}"

    def recording(self) -> list[RecordedFrame]:
        """All that it holds.

        Raises InputError naming what is wrong with the file, and where.
        """
        if self.path.suffix.lower() == ".c3d":
            return read_trial(self.path, self.axes, self.bodies, self.unit)
        suffix = self.path.suffix.lower()
        if suffix in ROOMS or (suffix == ".csv" and kind_of_room(first_lines(self.path))):
            trial = read_room_table(self.path)
            unit = unit_of_trial(self.path, trial.unit, self.unit)
            return trial_frames(self.path, trial, replace(self.axes, unit=unit), self.bodies)
        return read_table(self.path, self.axes, self.quaternion or ORDERS[0])

    def judge(
        self, frames: list[RecordedFrame], speed: float = CarLimits().speed
    ) -> tuple[dict[str, BodyReport], list[Swap]]:
        """What can be said of its bodies, were they cars of this top speed (m/s)."""
        tracks = tracks_of(frames)
        fastest = {track.name: speed for track in tracks}
        return judge_bodies(tracks, self.axes.body_top, fastest, SafetyLimits().leap)

    def find_cure(self, misread: set[str]) -> str:
        """The option that makes sense of the orientation of these bodies, empty if none does.

        Each is tried on the whole file, the order of the quaternion first.
        """
        axes = self.axes
        tried: list[tuple[str, RecordedSource]] = []
        if self.path.suffix.lower() != ".c3d":
            order = ORDERS[self.quaternion in ("", ORDERS[0])]
            tried.append((f"quaternion={order}", replace(self, quaternion=order)))
        if not self.bodies:
            for change in (
                *({"up": up} for up in UPS if up != axes.up),
                *({"top": top} for top in NOSES if top[-1] != axes.nose[-1]),
                *({"nose": nose} for nose in NOSES if nose[-1] != axes.body_top[-1:]),
            ):
                option, value = next(iter(change.items()))
                tried.append((f"{option}={value}", replace(self, axes=replace(axes, **change))))
        for option, changed in tried:
            reports, _ = changed.judge(changed.recording())
            if all(name in reports and not reports[name].misread for name in misread):
                return option
        return ""

    def frames(self, stop: threading.Event) -> Iterator[MocapFrame]:
        """Read the file, then give its frames at their times; see `Source.frames`."""
        return self._played(self.recording(), stop)

    def _played(
        self, recording: list[RecordedFrame], stop: threading.Event
    ) -> Iterator[MocapFrame]:
        first, last = recording[0], recording[-1]
        step = (last.time - first.time) / max(1, len(recording) - 1)
        lasts = last.time - first.time + step
        holds = last.number - first.number + 1
        began = time.monotonic()
        for round_ in count() if self.again else range(1):
            for frame in recording:
                elapsed = round_ * lasts + frame.time - first.time
                if stop.wait(max(0.0, began + elapsed / self.factor - time.monotonic())):
                    return
                yield MocapFrame(
                    frame.number + round_ * holds,
                    time.monotonic(),
                    frame.sightings,
                    first.time + elapsed,
                )


def open_recording(address: Address) -> RecordedSource:
    """The recording that an address names, once the whole of it is found readable.

    Raises InputError also where the bodies make sense only with quaternions read w first, unless
    their order is declared.
    """
    recorded = recording_of(address)
    frames = recorded.recording()
    if recorded.path.suffix.lower() != ".c3d" and not recorded.quaternion:
        demand_order(recorded, frames)
    return recorded


def recording_of(address: Address) -> RecordedSource:
    """The recording that an address names, not yet read."""
    address.known((*AXES, "factor", "again", "quaternion"), several=("body",))
    path = Path(address.place).expanduser()
    try:
        return RecordedSource(
            path,
            address.axes(),
            tuple(_marked(word) for word in address.words("body")),
            address.number("factor", 1.0, 0.001, 1000.0),
            address.truth("again", False),
            address.word("unit", ""),
            address.word("quaternion", ""),
        )
    except InputError as refused:
        message = str(refused)
        raise InputError(
            message if address.text in message else f"{message} ({address.text})"
        ) from None


def demand_order(recorded: RecordedSource, frames: list[RecordedFrame]) -> None:
    """Refuse a table whose quaternions make sense with w first and none with w last."""
    reports, _ = recorded.judge(frames)
    misread = {name: report.misread for name, report in reports.items() if report.misread}
    if not misread:
        return
    other = replace(recorded, quaternion="wxyz")
    read_so, _ = other.judge(other.recording())
    for name, fault in misread.items():
        if name in read_so and not read_so[name].misread:
            raise InputError(
                f"{recorded.path}, {name!r}: {fault}; its quaternions are sound if w comes first: "
                "add ?quaternion=wxyz (or declare ?quaternion=xyzw)"
            )


def _marked(word: str) -> MarkedBody:
    parts = [part.strip() for part in word.split(",")]
    if len(parts) != 3 or not all(parts):
        raise InputError(f"body = {word} is not of the form NAME,REAR,FRONT")
    return MarkedBody(*parts)
