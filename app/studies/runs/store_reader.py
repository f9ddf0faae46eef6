"""Reading a store, at any time, from any process: counts, and runs in the order of its plan."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from app.studies.runs.database import (
    FILE,
    FIXED,
    LONGEST,
    QueryTimeLimit,
    guarded,
    looked_into,
    quoted,
)
from app.studies.runs.run_outcome import STATUSES
from app.studies.runs.store_contents import (
    StoreContentError,
    demand_cell,
    demand_kinds,
    demand_runs,
    demand_state,
    json_value,
    series_of,
)
from worlds.input_error import InputError

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
            with guarded(self.path, "read"):
                yield
        except StoreContentError as error:
            raise InputError(f"{str(self.path)!r} cannot be read: {error}") from None

    def _rows(self, statement: str) -> list[tuple]:
        with closing(looked_into(self.path)) as connection, self._checked():
            QueryTimeLimit(connection, self.limit)
            return connection.execute(statement).fetchall()

    @property
    def counts(self) -> dict[str, int]:
        """Runs of the plan by how they ended."""
        found = dict(
            self._rows(
                "SELECT status, count(*) FROM run WHERE cell IN (SELECT cell FROM plan) "
                "GROUP BY status"
            )
        )
        with self._checked():
            if not set(found) <= set(STATUSES):
                raise StoreContentError("a run has an unknown status")
        return {status: found.get(status, 0) for status in STATUSES}

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
        found = [row[1] for row in self._rows("PRAGMA table_info(run)")]
        return [name for name in found if name not in FIXED]

    @cached_property
    def cells(self) -> dict[int, dict[str, Any]]:
        """The cells of the plan by their number in the store, each once, in order."""
        found = self._rows(
            "SELECT c, json FROM (SELECT cell AS c, min(place) AS place FROM plan GROUP BY cell) "
            "LEFT JOIN cell ON cell.id = c ORDER BY place"
        )
        with self._checked():
            demand_kinds("cell", found, ({int}, {str}))
            if len(dict(found)) < len(found):
                raise StoreContentError("two cells have one number")
            return {number: demand_cell(json_value(text)) for number, text in found}

    @cached_property
    def plan(self) -> list[int]:
        """The number of the cell at each place of the plan, where one may stand twice."""
        found = self._rows("SELECT cell FROM plan ORDER BY place")
        with self._checked():
            return [row[0] for row in demand_kinds("plan", found, ({int},))]

    def runs(self, columns: list[str] | None = None) -> list[tuple]:
        """The runs of the plan in its order: the FIXED columns, then what was measured."""
        measured = self.columns if columns is None else columns
        chosen = ", ".join(f"run.{quoted(name)}" for name in (*FIXED, *measured))
        found = self._rows(f"SELECT {chosen} FROM run {ORDERED}")
        with self._checked():
            return demand_runs(found, len(measured))

    def series(self) -> Iterator[tuple[int, int, str, np.ndarray, np.ndarray]]:
        """Cell, seed, observable, ticks and values of all series, in the order of the plan."""
        with closing(looked_into(self.path)) as connection, self._checked():
            limit = QueryTimeLimit(connection, self.limit)
            found = connection.execute(
                'SELECT run.cell, run.seed, observable, run.ticks, "values" FROM series AS run '
                + ORDERED
                + ", observable"
            )
            for row in found:
                demand_kinds("series", [row], ({int}, {int}, {str}, {bytes}, {bytes}))
                cell, seed, name, *blobs = row
                yield cell, seed, name, *series_of(*blobs)
                limit.restart()  # who takes the series has all the time


def readable(folder: Path) -> bool:
    """Whether a folder holds a store that can be read."""
    try:
        connection = looked_into(folder / FILE)
    except (ValueError, sqlite3.Error):
        return False
    connection.close()
    return True
