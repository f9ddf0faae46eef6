"""Reading a store, at any time, from any process: counts, and runs in the order of its plan."""

from __future__ import annotations

import json
import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from app.experiments.runs.database import FILE, FIXED, guarded, looked_into, quoted
from app.experiments.runs.outcome import STATUSES
from worlds.refusal import Refusal

LONGEST = 30.0
"""Seconds that one question to a store may take; then it is interrupted."""
STEPS = 100_000
"""Instructions of SQLite between two looks at the clock."""

ORDERED = (
    "JOIN (SELECT cell AS c, min(place) AS place FROM plan GROUP BY cell) ON c = run.cell "
    "ORDER BY place, seed"
)
"""Runs of the plan, each once: cell by cell in its order, then by seed."""


@dataclass(frozen=True)
class Kept:
    """A store as it stands; what is asked for once is of one moment."""

    folder: Path

    @property
    def path(self) -> Path:
        """The file."""
        return self.folder / FILE

    def _rows(self, statement: str) -> list[tuple]:
        with closing(looked_into(self.path)) as connection, guarded(self.path):
            end = time.monotonic() + LONGEST
            connection.set_progress_handler(lambda: time.monotonic() > end, STEPS)
            return connection.execute(statement).fetchall()

    def _value(self, text: Any) -> Any:
        """A value from its JSON. Raises Refusal for what is none."""
        try:
            return json.loads(text)
        except (ValueError, TypeError, RecursionError):
            raise Refusal(f"{str(self.path)!r} cannot be read: it holds broken JSON") from None

    @property
    def counts(self) -> dict[str, int]:
        """Runs of the plan by how they ended."""
        found = self._rows(
            "SELECT status, count(*) FROM run WHERE cell IN (SELECT cell FROM plan) GROUP BY status"
        )
        return {status: dict(found).get(status, 0) for status in STATUSES}

    @property
    def others(self) -> int:
        """Runs of cells that are no longer in the plan, which are kept."""
        statement = "SELECT count(*) FROM run WHERE cell NOT IN (SELECT cell FROM plan)"
        return int(self._rows(statement)[0][0])

    @property
    def state(self) -> dict[str, Any]:
        """What the process that writes has left word of."""
        return {key: self._value(value) for key, value in self._rows("SELECT * FROM state")}

    @cached_property
    def columns(self) -> list[str]:
        """What is measured of a run."""
        found = [row[1] for row in self._rows("PRAGMA table_info(run)")]
        return [name for name in found if name not in FIXED]

    @cached_property
    def cells(self) -> dict[int, dict[str, Any]]:
        """The cells of the plan by their number in the store, each once, in order."""
        found = self._rows(
            "SELECT cell.id, json FROM plan JOIN cell ON cell.id = plan.cell ORDER BY place"
        )
        return {number: self._value(text) for number, text in dict(found).items()}

    @cached_property
    def plan(self) -> list[int]:
        """The number of the cell at each place of the plan, where one may stand twice."""
        return [row[0] for row in self._rows("SELECT cell FROM plan ORDER BY place")]

    def runs(self, columns: list[str] | None = None) -> list[tuple]:
        """The runs of the plan in its order: the FIXED columns, then what was measured."""
        names = [*FIXED, *(self.columns if columns is None else columns)]
        chosen = ", ".join(f"run.{quoted(name)}" for name in names)
        return self._rows(f"SELECT {chosen} FROM run {ORDERED}")

    def series(self) -> Iterator[tuple[int, int, str, np.ndarray, np.ndarray]]:
        """Cell, seed, observable, ticks and values of all series, in the order of the plan."""
        with closing(looked_into(self.path)) as connection, guarded(self.path):
            found = connection.execute(
                'SELECT run.cell, run.seed, observable, run.ticks, "values" FROM series AS run '
                + ORDERED
                + ", observable"
            )
            for cell, seed, name, ticks, values in found:
                yield cell, seed, name, np.frombuffer(ticks, "<i8"), np.frombuffer(values, "<f8")


def readable(folder: Path) -> bool:
    """Whether a folder holds a store that can be read."""
    try:
        connection = looked_into(folder / FILE)
    except (ValueError, sqlite3.Error):
        return False
    connection.close()
    return True
