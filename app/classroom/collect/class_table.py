"""The points of a question as a table: CSV for people and programs, JSON for a page's plot."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any, get_args

from agents.observables.catalogue import OBSERVABLES
from agents.observables.observable import Range
from app.classroom.collect.collection import MOST_POINTS, Collection
from app.classroom.collect.hand_in import Point, ResultGroup
from app.classroom.collect.question import Question
from app.classroom.student import student_name
from app.studies.run_axes import AGENTS
from app.studies.runs.database import Status
from app.studies.sweeps.sweep_table import as_csv
from worlds.file_writer import unguard_cell
from worlds.input_error import InputError, shorten

APART = "; "
"""Between two differences."""
LONGEST = 4_000
"""Letters of a text in a table."""
ROUNDING = 1e-9
"""By which a result may be beyond an end of its range, as a share of that."""
FIGURES = 6
"""Of a number in a page's plot."""


def headed(name: str, unit: str) -> str:
    """The head of a column, with its unit.

    >>> headed("eta", "rad"), headed("p2", "1")
    ('eta [rad]', 'p2')
    """
    return name if unit == "1" else f"{name} [{unit}]"


def heads(question: Question) -> list[str]:
    """The columns of the table of a question."""
    return [
        "number",
        "student",
        headed(question.parameter, question.unit),
        *(headed(name, question.unit_of(name)) for name in question.free),
        headed(question.column, question.result_unit),
        *("status", "counts", "seed", "ticks", "differs", "reason", "when"),
    ]


def to_csv(collection: Collection, beside: Mapping[str, list[Any]] | None = None) -> str:
    """A row for each result, in the order in which they came in.

    As in the table of a sweep floats come back to the bit, and there is nothing where there is no
    result; units stand in the head. `beside`: more columns by their heads, a value for each result.
    """
    points, counting = collection.points, collection.counting
    columns: list[list[Any]] = [
        list(range(1, len(points) + 1)),
        [point.student for point in points],
        [point.value for point in points],
        *([point.free[k] for point in points] for k in range(len(collection.question.free))),
        [point.result for point in points],
        [point.status for point in points],
        counting,
        [point.seed for point in points],
        [point.ticks for point in points],
        [APART.join(point.differs) for point in points],
        [point.reason for point in points],
        [point.when.isoformat() for point in points],
    ]
    return as_csv(dict(zip(heads(collection.question), columns, strict=True)) | dict(beside or {}))


def points_from_csv(
    text: str, question: Question, spec_of: Callable[[int], str], origin: str
) -> list[Point]:
    """The points of a table that `to_csv` wrote. Raises InputError.

    `spec_of` has the specs, which stand elsewhere, by the number of their row from 1.
    """
    try:
        rows = list(csv.reader(io.StringIO(text, newline=""), strict=True))
        rows = [[unguard_cell(cell) for cell in row] for row in rows]
    except csv.Error as error:
        raise InputError(f"{origin} is no CSV: {error}") from None
    if not rows or rows[0] != heads(question):
        raise InputError(f"{origin} has not the columns {', '.join(heads(question))}")
    if len(rows) - 1 > MOST_POINTS:
        raise InputError(f"{origin} has {len(rows) - 1:,} rows: at most {MOST_POINTS:,}")
    made = []
    for number, row in enumerate(rows[1:], 1):
        at = f"{origin}, row {number}"
        if len(row) != len(rows[0]) or row[0] != str(number):
            raise InputError(f"{at} is not as its columns, or not in order")
        point = point_of(row, spec_of(number), at)
        demand_possible(point, question, at)
        made.append(point)
    return made


def demand_possible(point: Point, question: Question, at: str) -> None:
    """Refuse a result that no run of the question has. Raises InputError."""
    if point.ticks > question.ticks:
        raise InputError(
            f"ticks = {point.ticks} is more than {question.ticks}, those of a run ({at})"
        )
    if point.result is not None:
        demand_in_range(point.result, question, at)


def demand_in_range(result: float, question: Question, at: str) -> None:
    """Refuse a value that what a question measures cannot have. Raises InputError."""
    low, high, name = 0.0, float(question.ticks), question.column
    if not question.measure.until:
        name = question.measure.observe
        found = OBSERVABLES[name].range
        assert isinstance(found, Range)
        low, high = found.low, found.high
    margin = ROUNDING * max(1.0, *(abs(end) for end in (low, high) if math.isfinite(end)), 0.0)
    if not low - margin <= result <= high + margin:
        raise InputError(
            f"{name} = {result:g} is not allowed: it lies in [{low:g}, {high:g}] ({at})"
        )


def point_of(row: Sequence[str], spec: str, at: str) -> Point:
    """A row as a point. Raises InputError."""
    _, student, value, *free, result, status, _, seed, ticks, differs, reason, when = row
    if status not in get_args(Status):
        raise InputError(f"status = {shorten(status)} is no status of a run ({at})")
    if (status != "ok" and result) or not (result or reason):
        raise InputError(f"a run that is {status} has a result, or else a reason ({at})")
    if max(len(differs), len(reason)) > LONGEST or not (differs + reason).isprintable():
        raise InputError(f"differs or reason is no line of text ({at})")
    name = student_name(student)
    if name != student:
        raise InputError(f"student = {shorten(student)} is not written as a name is ({at})")
    return Point(
        name,
        number(value, at),
        number(result, at) if result else None,
        status,  # type: ignore[arg-type]
        reason,
        whole_number(seed, at),
        whole_number(ticks, at),
        spec,
        moment(when, at),
        tuple(differs.split(APART)) if differs else (),
        tuple(number(one, at) for one in free),
    )


def number(text: str, at: str) -> float:
    """A finite number. Raises InputError."""
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        raise InputError(f"{shorten(text)} is not a finite number ({at})")
    return found


def whole_number(text: str, at: str) -> int:
    """A whole number of at most 19 figures. Raises InputError."""
    if not (text.isascii() and text.isdigit() and len(text) <= 19):
        raise InputError(f"{shorten(text)} is not a whole number ({at})")
    return int(text)


def moment(text: str, at: str) -> datetime:
    """A time in UTC. Raises InputError."""
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        found = None
    if found is None or found.tzinfo is None:
        raise InputError(f"when = {shorten(text)} is no time with its zone ({at})")
    return found.astimezone(UTC)


def to_json(collection: Collection) -> dict[str, Any]:
    """What a page needs for the plot; nothing in it is nan. Names and titles are plain text.

    A point is [number, student, value, result or null, counts, differs]; a group, and a place of
    the curve, is [value, runs, mean, half of its 95 % interval, sd, and the ends of the interval].
    """
    question, curve = collection.question, collection.curve
    along, up = collection.axis_limits(() if curve is None else curve.groups)
    return {
        "title": question.title,
        "x": {
            "name": question.parameter,
            "title": "Agents" if question.parameter == AGENTS else question.parameter_words,
            "symbol": question.symbol,
            "unit": question.unit,
            "log": collection.is_log(() if curve is None else curve.values),
            "limits": list(along),
        },
        "y": {
            "name": question.column,
            "title": question.result_words,
            "unit": question.result_unit,
            "limits": list(up),
        },
        "told": collection.told(),
        "points": [
            [k, one.student, few(one.value), few(one.result), counts, "; ".join(one.differs)]
            for k, (one, counts) in enumerate(
                zip(collection.points, collection.counting, strict=True)
            )
        ],
        "groups": [group_row(group) for group in collection.groups()],
        "curve": None if curve is None else {
            "name": curve.name,
            "differs": list(curve.differs),
            "groups": [group_row(group) for group in curve.groups],
        },
    }  # fmt: skip


def group_row(group: ResultGroup) -> list[float | int | None]:
    """A group as the page has it."""
    numbers = (group.mean, group.half, group.sd, *group.summary.interval)
    return [few(group.value), group.runs, *map(few, numbers)]


def few(value: float | None) -> float | None:
    """A number in few figures; None for none."""
    if value is None or not math.isfinite(value):
        return None
    return float(f"{value:.{FIGURES}g}")
