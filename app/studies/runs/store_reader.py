"""Reading a store, at any time, from any process: counts, and runs in the order of its plan."""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, NoReturn, TypedDict

import numpy as np
from pydantic import (
    AfterValidator,
    ConfigDict,
    StrictInt,
    StrictStr,
    TypeAdapter,
    ValidationError,
)

from app.studies.runs.database import (
    FILE,
    FIXED,
    LONGEST,
    STATUSES,
    QueryTimeLimit,
    naming_file,
    open_for_reading,
    quote_column,
)
from worlds.input_error import InputError, demand_line

# What the tables of a store may hold: who sends one chooses every value and every kind of value.
#
# SQLite keeps any kind of value in any column, and JSON any kind under any key. What is read is
# checked here once, so that whoever asks a store gets what flockscope writes, or one InputError.

DEEPEST = 40
"""Lists and tables within each other."""
LONGEST_NAME = 200
"""Characters of the name of an axis or of a column."""

Kinds = set[type]
WHOLE: Kinds = {int}
NUMBER: Kinds = {int, float}
TEXT: Kinds = {str}
WORDS: Kinds = {str, type(None)}
FIXED_KINDS: tuple[Kinds, ...] = (WHOLE, WHOLE, TEXT, WORDS, NUMBER, WHOLE, WORDS)
"""Of the FIXED columns of `run`, in order."""
MEASURED_KINDS = {int, float, type(None)}


class StoredProgress(TypedDict, total=False):
    """How fast a sweep is."""

    rate: float | None
    seconds_left: float | None
    workers: StrictInt
    pid: StrictInt


class StoreState(TypedDict, total=False):
    """What the process that writes has left word of."""

    __pydantic_config__ = ConfigDict(extra="ignore", allow_inf_nan=False)  # type: ignore[misc]

    kind: StrictStr
    title: Annotated[StrictStr, AfterValidator(demand_line)]
    axes: list[StrictStr]
    columns: list[StrictStr]
    base: StrictStr
    from_folder: StrictStr
    limit: StrictInt
    runs: StrictInt
    progress: StoredProgress | None


STATE = TypeAdapter(StoreState)


class StoreContentError(ValueError):
    """What a store holds that flockscope does not write."""


def json_value(text: Any) -> Any:
    """A value from its JSON: finite numbers, whole characters, not deep. Raises Contents."""
    try:
        if not isinstance(text, str):
            raise ValueError
        value = json.loads(text, parse_constant=refuse_constant, parse_float=finite)
        if "\\ud" in text.lower():
            json.dumps(value, ensure_ascii=False).encode()  # half of a pair cannot be written
        if text.count("[") + text.count("{") > DEEPEST and depth(value) > DEEPEST:
            raise ValueError
    except (ValueError, RecursionError):
        raise StoreContentError("it holds broken JSON") from None
    return value


def refuse_constant(name: str) -> NoReturn:
    """Refuse NaN and Infinity, which are no JSON."""
    raise ValueError(name)


def finite(text: str) -> float:
    """A number with a point. Raises ValueError for one that is too large for a float."""
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def depth(value: Any) -> int:
    """How many lists and tables are within each other."""
    level, deep = [value], 0
    while level := [item for item in level if isinstance(item, dict | list)]:
        level = [
            item
            for container in level
            for item in (container.values() if type(container) is dict else container)
        ]
        deep += 1
    return deep


def demand_state(state: dict[str, Any]) -> dict[str, Any]:
    """The state, if each key that is known has its kind. Raises Contents."""
    try:
        STATE.validate_python(state)
    except ValidationError as error:
        key = ".".join(map(str, error.errors()[0]["loc"]))
        raise StoreContentError(f"its state {key!r} is of another kind") from None
    for key in ("axes", "columns"):
        names = state.get(key, [])
        if len(set(names)) < len(names) or any(len(name) > LONGEST_NAME for name in names):
            raise StoreContentError(f"its state {key!r} has a name twice, or one that is too long")
    return state


def demand_cell(cell: Any) -> dict[str, Any]:
    """A cell, if it has axes with plain values, and what it is and depends on. Raises Contents."""
    if not isinstance(cell, dict) or not isinstance(cell.get("axes"), dict):
        raise StoreContentError("a cell has no axes")
    if not all(isinstance(value, bool | int | float | str) for value in cell["axes"].values()):
        raise StoreContentError("a cell has an axis with no plain value")
    if any(type(v) is int and abs(v) >= 2**63 for v in cell["axes"].values()):
        raise StoreContentError("a cell has an axis with a number that is too large")
    for key in ("identity", "basis"):
        if not isinstance(cell.get(key, {}), dict):
            raise StoreContentError(f"the {key} of a cell is no table")
    return cell


def demand_kinds(table: str, rows: list[tuple], kinds: Sequence[set[type]]) -> list[tuple]:
    """The rows, if each column has values of its kinds only. Raises Contents."""
    columns = zip(*rows, strict=True) if rows else ([],) * len(kinds)
    for number, (values, allowed) in enumerate(zip(columns, kinds, strict=True)):
        if not set(map(type, values)) <= allowed:
            raise StoreContentError(f"column {number + 1} of what {table} holds is of another kind")
    return rows


def demand_runs(rows: list[tuple], measured: int) -> list[tuple]:
    """The runs, if they have FIXED columns, then `measured` numbers. Raises Contents."""
    demand_kinds("run", rows, (*FIXED_KINDS, *(MEASURED_KINDS,) * measured))
    if not {row[2] for row in rows} <= set(STATUSES):
        raise StoreContentError("a run has an unknown status")
    if not all(0 <= row[4] < math.inf and row[5] >= 0 for row in rows):
        raise StoreContentError("a run has a time that none can take")
    return rows


def series_of(ticks: Any, values: Any) -> tuple[np.ndarray, np.ndarray]:
    """Ticks (K,) int and values (K,) float from their bytes. Raises Contents."""
    if not (isinstance(ticks, bytes) and isinstance(values, bytes)):
        raise StoreContentError("a series is not of bytes")
    if len(ticks) != len(values) or len(ticks) % 8:
        raise StoreContentError("a series has other ticks than values")
    return np.frombuffer(ticks, "<i8"), np.frombuffer(values, "<f8")


ORDERED = (
    "JOIN (SELECT cell AS c, min(place) AS place FROM plan GROUP BY cell) ON c = run.cell "
    "ORDER BY place, seed"
)
"""Runs of the plan, each once: cell by cell in its order, then by seed."""


@dataclass(frozen=True)
class StoreReader:
    """A store as it stands; what is asked for once is of one moment."""

    folder: Path
    limit: float = LONGEST
    """Seconds that one question may take."""

    @property
    def path(self) -> Path:
        """The file."""
        return self.folder / FILE

    @contextmanager
    def _checked(self) -> Iterator[None]:
        """What the store holds that it cannot is an InputError that names the file."""
        try:
            with naming_file(self.path, "read"):
                yield
        except StoreContentError as error:
            raise InputError(f"{str(self.path)!r} cannot be read: {error}") from None

    def _rows(self, statement: str) -> list[tuple]:
        with closing(open_for_reading(self.path)) as connection, self._checked():
            QueryTimeLimit(connection, self.limit)
            return connection.execute(statement).fetchall()

    @property
    def counts(self) -> dict[str, int]:
        """Runs of the plan by how they ended."""
        counts = dict(
            self._rows(
                "SELECT status, count(*) FROM run WHERE cell IN (SELECT cell FROM plan) "
                "GROUP BY status"
            )
        )
        with self._checked():
            if not set(counts) <= set(STATUSES):
                raise StoreContentError("a run has an unknown status")
        return {status: counts.get(status, 0) for status in STATUSES}

    @property
    def others(self) -> int:
        """Runs of cells that are no longer in the plan, which are kept."""
        statement = "SELECT count(*) FROM run WHERE cell NOT IN (SELECT cell FROM plan)"
        return int(self._rows(statement)[0][0])

    @property
    def state(self) -> dict[str, Any]:
        """What the process that writes has left word of."""
        rows = self._rows("SELECT key, value FROM state")
        with self._checked():
            demand_kinds("state", rows, ({str}, {str, bytes}))
            return demand_state({key: json_value(text) for key, text in rows})

    @cached_property
    def columns(self) -> list[str]:
        """What is measured of a run."""
        names = [row[1] for row in self._rows("PRAGMA table_info(run)")]
        return [name for name in names if name not in FIXED]

    @cached_property
    def cells(self) -> dict[int, dict[str, Any]]:
        """The cells of the plan by their number in the store, each once, in order."""
        rows = self._rows(
            "SELECT c, json FROM (SELECT cell AS c, min(place) AS place FROM plan GROUP BY cell) "
            "LEFT JOIN cell ON cell.id = c ORDER BY place"
        )
        with self._checked():
            demand_kinds("cell", rows, ({int}, {str}))
            if len(dict(rows)) < len(rows):
                raise StoreContentError("two cells have one number")
            return {number: demand_cell(json_value(text)) for number, text in rows}

    @cached_property
    def plan(self) -> list[int]:
        """The number of the cell at each place of the plan, where one may stand twice."""
        rows = self._rows("SELECT cell FROM plan ORDER BY place")
        with self._checked():
            return [row[0] for row in demand_kinds("plan", rows, ({int},))]

    def runs(self, columns: list[str] | None = None) -> list[tuple]:
        """The runs of the plan in its order: the FIXED columns, then what was measured."""
        measured = self.columns if columns is None else columns
        chosen = ", ".join(f"run.{quote_column(name)}" for name in (*FIXED, *measured))
        rows = self._rows(f"SELECT {chosen} FROM run {ORDERED}")
        with self._checked():
            return demand_runs(rows, len(measured))

    def series(self) -> Iterator[tuple[int, int, str, np.ndarray, np.ndarray]]:
        """Cell, seed, observable, ticks and values of all series, in the order of the plan."""
        with closing(open_for_reading(self.path)) as connection, self._checked():
            limit = QueryTimeLimit(connection, self.limit)
            cursor = connection.execute(
                'SELECT run.cell, run.seed, observable, run.ticks, "values" FROM series AS run '
                + ORDERED
                + ", observable"
            )
            for row in cursor:
                demand_kinds("series", [row], ({int}, {int}, {str}, {bytes}, {bytes}))
                cell, seed, name, *blobs = row
                yield cell, seed, name, *series_of(*blobs)
                limit.restart()  # who takes the series has all the time


def readable(folder: Path) -> bool:
    """Whether a folder holds a store that can be read."""
    try:
        connection = open_for_reading(folder / FILE)
    except (ValueError, sqlite3.Error):
        return False
    connection.close()
    return True
