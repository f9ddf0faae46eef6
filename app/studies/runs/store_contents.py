"""What the tables of a store may hold: who sends one chooses every value and every kind of value.

SQLite keeps any kind of value in any column, and JSON any kind under any key. What is read is
checked here once, so that whoever asks a store gets what flockscope writes, or one InputError.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
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

from app.studies.runs.run_outcome import STATUSES
from worlds.input_error import demand_line

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
    while level := [one for one in level if isinstance(one, dict | list)]:
        level = [one for held in level for one in (held.values() if type(held) is dict else held)]
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
