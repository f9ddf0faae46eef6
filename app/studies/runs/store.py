"""The store of runs: one writer, a commit every quarter of a second, nothing lost by any kill.

A commit is whole or not there. What was finished since the last one is made again, with the same
numbers, because a run is a value: so a store that was killed and went on holds what one that was
never stopped does.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any

import numpy as np
from filelock import FileLock, Timeout

from app.studies.runs.database import (
    BROKEN,
    FILE,
    FIXED,
    LONGEST,
    Outcome,
    QueryTimeLimit,
    naming_file,
    open_database,
    quote_column,
)
from app.studies.runs.store_reader import StoreContentError, demand_cell, json_value
from worlds.input_error import InputError

EVERY = 0.25
"""Seconds between two commits."""
LOCK = ".lock"
TIMEOUT = 0.2
"""Seconds to wait for the lock: who looks whether it is taken has it for a moment."""


class Store:
    """A context manager over `runs.sqlite` in a folder, for the one process that writes to it.

    `columns` are what is measured of a run; a store that lacks some gets them. Raises InputError if
    another process has the folder, if the file is of anything else, or if it cannot be written.
    """

    def __init__(self, folder: Path, columns: Sequence[str], every: float = EVERY):
        self.folder = folder
        self.path = folder / FILE
        self.columns = tuple(columns)
        self.every = every
        self.rows: list[tuple] = []
        self.series: list[tuple] = []
        self.told: dict[str, str] = {}
        self.kept_at = time.monotonic()

    def __enter__(self) -> Store:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{str(self.folder)!r} cannot be made: {error.strerror or error}"
            ) from None
        self.lock = lock_folder(self.folder)
        try:
            self.connection = open_database(self.path)
            with naming_file(self.path):
                self._widen()
        except BaseException:
            self.lock.release()
            raise
        names = [*FIXED, *self.columns]
        self._insert = (
            f"INSERT OR REPLACE INTO run ({', '.join(map(quote_column, names))}) "
            f"VALUES ({', '.join('?' * len(names))})"
        )
        return self

    def __exit__(self, kind: Any, *_: object) -> None:
        try:
            with nullcontext() if kind is None else suppress(InputError):
                self.commit()
        finally:
            with naming_file(self.path):
                self.connection.close()
            self.lock.release()

    def _widen(self) -> None:
        """Add the columns that the store does not have."""
        columns = {row[1].lower() for row in self.connection.execute("PRAGMA table_info(run)")}
        for name in self.columns:
            if name.lower() not in columns:
                self.connection.execute(f"ALTER TABLE run ADD COLUMN {quote_column(name)}")

    def store_plan(self, cells: Sequence[tuple[str, str]]) -> list[int]:
        """Take a plan: the hash and the JSON of each of its cells, in order; their numbers here.

        What runs of other cells there are stays.
        """
        with naming_file(self.path):
            run = self.connection.execute
            run("BEGIN IMMEDIATE")
            self.connection.executemany(
                "INSERT OR IGNORE INTO cell (hash, json) VALUES (?, ?)", cells
            )
            ids = dict(run("SELECT hash, id FROM cell").fetchall())
            numbers = [ids[cell] for cell, _ in cells]
            run("DELETE FROM plan")
            self.connection.executemany(
                "INSERT INTO plan (place, cell) VALUES (?, ?)", list(enumerate(numbers, 1))
            )
            run("COMMIT")
        return numbers

    def forget_broken(self) -> int:
        """Forget the runs that failed or were killed, so that they are made again; how many."""
        with naming_file(self.path):
            marks = ", ".join("?" * len(BROKEN))
            cursor = self.connection.execute(f"DELETE FROM run WHERE status IN ({marks})", BROKEN)
            return cursor.rowcount

    @contextmanager
    def _limit_query(self) -> Iterator[None]:
        """What is read of the store within takes LONGEST at most. Raises InputError."""
        with naming_file(self.path, "gone on with"):
            QueryTimeLimit(self.connection, LONGEST)
            try:
                yield
            finally:
                self.connection.set_progress_handler(None, 0)  # what is written is not interrupted

    def outcomes(self, columns: Sequence[str]) -> dict[tuple[int, int], Outcome]:
        """All runs by cell and seed, with these of their columns and without their series."""
        names = ", ".join(map(quote_column, [*FIXED, *columns]))
        outcomes: dict[tuple[int, int], Outcome] = {}
        with self._limit_query():
            for row in self.connection.execute(f"SELECT {names} FROM run"):
                cell, seed, status, reason, seconds, ticks, astray, *values = row
                measured = dict(zip(columns, values, strict=True))
                outcomes[cell, seed] = Outcome(
                    status, measured, reason or "", seconds, ticks, astray or ""
                )
        return outcomes

    def others(self, cells: Iterable[int]) -> list[tuple[dict, dict, int]]:
        """Identity, basis and number of runs of the cells that are not among these."""
        mine = set(cells)
        with self._limit_query():
            rows = self.connection.execute(
                "SELECT id, json, runs FROM cell "
                "JOIN (SELECT cell AS c, count(*) AS runs FROM run GROUP BY cell) ON c = id"
            ).fetchall()
        try:
            other_cells = [
                (demand_cell(json_value(text)), runs) for row, text, runs in rows if row not in mine
            ]
        except StoreContentError as error:
            raise InputError(f"{str(self.path)!r} cannot be gone on with: {error}") from None
        return [
            (cell.get("identity", {}), cell.get("basis", {}), runs) for cell, runs in other_cells
        ]

    def add(self, cell: int, seed: int, outcome: Outcome) -> None:
        """Take a run; it is on the disk after the next commit."""
        values = [number(outcome.values.get(name)) for name in self.columns]
        self.rows.append(
            (
                *(cell, seed, outcome.status, outcome.reason or None, outcome.seconds),
                *(outcome.ticks, outcome.astray or None, *values),
            )
        )
        for name, (ticks, entries) in outcome.series.items():
            blobs = np.asarray(ticks, "<i8").tobytes(), np.asarray(entries, "<f8").tobytes()
            self.series.append((cell, seed, name, *blobs))

    def tell(self, **state: Any) -> None:
        """Leave word for who reads the store, with the next commit."""
        self.told |= {key: json.dumps(value) for key, value in state.items()}

    def commit_if_due(self) -> None:
        """Commit if it is time to."""
        if time.monotonic() - self.kept_at >= self.every:
            self.commit()

    def commit(self) -> None:
        """Commit. Raises InputError if the disk takes no more; what was committed before stays."""
        self.kept_at = time.monotonic()
        if not (self.rows or self.series or self.told):
            return
        rows, series, told = self.rows, self.series, self.told
        self.rows, self.series, self.told = [], [], {}
        with naming_file(self.path):
            try:  # an interrupt may come as soon as the transaction has begun
                self.connection.execute("BEGIN IMMEDIATE")
                self.connection.executemany(self._insert, rows)
                self.connection.executemany(
                    "INSERT OR REPLACE INTO series VALUES (?, ?, ?, ?, ?)", series
                )
                self.connection.executemany(
                    "INSERT OR REPLACE INTO state VALUES (?, ?)", list(told.items())
                )
                self.connection.execute("COMMIT")
            except BaseException:
                if self.connection.in_transaction:
                    self.connection.execute("ROLLBACK")
                raise


def number(value: Any) -> Any:
    """A value as SQLite keeps it: what is not a number, nan, is NULL."""
    if value is None or value != value:
        return None
    return value.item() if isinstance(value, np.generic) else value


def lock_folder(folder: Path) -> FileLock:
    """The folder's lock, which a process that dies lets go. Raises InputError if another has it."""
    lock = FileLock(folder / LOCK)
    try:
        lock.acquire(timeout=TIMEOUT)
    except Timeout:
        raise InputError(
            f"{str(folder)!r} is being written by another process: wait for it, or stop it with "
            f"`flockscope sweep stop {folder}`"
        ) from None
    except OSError as error:
        raise InputError(f"{str(folder)!r} cannot be written: {error.strerror or error}") from None
    return lock


def is_locked(folder: Path) -> bool:
    """Whether a process writes to the store of a folder now."""
    if not (folder / LOCK).exists() or not os.access(folder / LOCK, os.W_OK):
        return False
    lock = FileLock(folder / LOCK)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        return True
    except OSError:
        return False
    lock.release()
    return False


def canonical(value: Mapping[str, Any]) -> str:
    """A value as JSON that is the same for the same value: sorted keys, floats that come back."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
