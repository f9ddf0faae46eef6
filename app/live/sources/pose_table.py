"""A table of poses, CSV or Parquet: one row for each body in each frame.

Columns, in any order: t (seconds), frame (whole number), name, x, y, z, qx, qy, qz, qw, valid (1 or
0, true or false). Rows of one frame stand together, with one t; frame and t rise. A row that is not
valid may leave its pose empty: a gap stays a gap. Where the file's maker wrote quaternions w first,
the four columns qx to qw hold w, x, y, z.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from agents.parquet import ParquetTable
from app.live.control.pose import Sighting, unseen
from app.live.sources.axes import Axes
from app.live.sources.recorded_frames import RecordedFrame
from worlds.input_error import InputError

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
    given = _of_parquet(path) if path.suffix.lower() == ".parquet" else _of_csv(path)
    rows = (_row(values, where, axes, order) for where, values in given)
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
        said = "it is empty" if value in ("", None) else f"{value!r} is not a number"
        raise InputError(f"{where}, column {column}: {said}")
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


def _check_columns(path: Path, given: list[str] | Any) -> None:
    missing = [column for column in COLUMNS if column not in given]
    if missing:
        raise InputError(f"{path} has no column {', '.join(missing)}: a table of poses needs "
                      f"{', '.join(COLUMNS)}")  # fmt: skip
    twice = [column for column in COLUMNS if list(given).count(column) > 1]
    if twice:
        raise InputError(f"{path} has the column {twice[0]} twice")
