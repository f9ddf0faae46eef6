"""The file of a store: SQLite in WAL, told apart from any other file, with one line for a fault."""

from __future__ import annotations

import os
import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Literal, NamedTuple, get_args

import numpy as np

from worlds.input_error import InputError

# How a run has ended, and what was measured of it.

Status = Literal["ok", "gave-up", "failed", "killed"]
STATUSES: tuple[Status, ...] = get_args(Status)
BROKEN: tuple[Status, ...] = ("failed", "killed")
"""What `--retry-failed` makes again, and what the exit code tells of."""
Number = int | float


class Outcome(NamedTuple):
    """A run that is over; cheap to send from a process to another.

    `ok`: it came to its end. `gave-up`: what it waited for did not come within its ticks.
    `failed`: it raised. `killed`: its process was killed, twice.
    """

    status: Status
    values: dict[str, Number | None] = {}  # noqa: RUF012 - never written to
    """By column of the store; None where the run has none."""
    reason: str = ""
    """Of a run that failed: class and message."""
    seconds: float = 0.0
    ticks: int = 0
    astray: str = ""
    """The first agent that was seen where it cannot be, in words."""
    series: dict[str, tuple[np.ndarray, np.ndarray]] = {}  # noqa: RUF012 - never written to
    """Observables along the run: ticks (K,) int and values (K,) float."""
    rest: tuple[Outcome, ...] = ()
    """Of a run that goes on from cell to cell: what it gave in those after the first."""


def failure(error: BaseException) -> Outcome:
    """The outcome of a run that raised."""
    words = " ".join(str(error).split())
    return Outcome("failed", reason=f"{type(error).__name__}: {words}"[:1000])


FILE = "runs.sqlite"
APPLICATION = 0x464C4B53
"""What SQLite keeps in the head of the file: FLKS."""
FORMAT = 1
TABLES = """
CREATE TABLE cell (id INTEGER PRIMARY KEY, hash TEXT NOT NULL UNIQUE, json TEXT NOT NULL);
CREATE TABLE plan (place INTEGER PRIMARY KEY, cell INTEGER NOT NULL);
CREATE TABLE run (
    cell INTEGER NOT NULL, seed INTEGER NOT NULL, status TEXT NOT NULL, reason TEXT,
    seconds REAL NOT NULL, ticks INTEGER NOT NULL, astray TEXT,
    PRIMARY KEY (cell, seed)
) WITHOUT ROWID;
CREATE TABLE series (
    cell INTEGER NOT NULL, seed INTEGER NOT NULL, observable TEXT NOT NULL,
    ticks BLOB NOT NULL, "values" BLOB NOT NULL,
    PRIMARY KEY (cell, seed, observable)
) WITHOUT ROWID;
CREATE TABLE state (key TEXT PRIMARY KEY, value TEXT NOT NULL);
"""
FIXED = ("cell", "seed", "status", "reason", "seconds", "ticks", "astray")
"""Columns of `run` that every store has; those of what is measured follow."""
COLUMNS = {
    "run": set(FIXED),
    "cell": {"id", "hash", "json"},
    "plan": {"place", "cell"},
    "series": {"cell", "seed", "observable", "ticks", "values"},
    "state": {"key", "value"},
}
"""What each table has at least."""
LARGEST = 64 * 2**20
"""Bytes of one text or blob."""
BUSY = 10.0
"""Seconds to wait for another process that looks into the file."""
LONGEST = 30.0
"""Seconds that one question to a store may take; then it is interrupted."""
STEPS = 100_000
"""Instructions of SQLite between two looks at the clock."""


@contextmanager
def naming_file(path: Path, kept: str = "kept") -> Iterator[None]:
    """Whatever SQLite raises within is an InputError that names the file, which cannot be
    `kept`."""
    try:
        yield
    except (sqlite3.Error, OverflowError) as error:
        why = "the disk is full" if "is full" in str(error) else str(error)
        if why == "interrupted":
            why = "the answer takes too long"
        raise InputError(f"store of runs {str(path)!r} cannot be {kept}: {why}") from None


class QueryTimeLimit:
    """It interrupts what a connection does that takes longer than a number of seconds."""

    def __init__(self, connection: sqlite3.Connection, seconds: float):
        self.seconds = seconds
        self.restart()
        connection.set_progress_handler(lambda: time.monotonic() > self.end, STEPS)

    def restart(self) -> None:
        """Give the next question the whole time."""
        self.end = time.monotonic() + self.seconds


def open_database(path: Path) -> sqlite3.Connection:
    """The file to write to, made if it is not there. Raises InputError, having changed nothing."""
    new = not path.exists() or path.stat().st_size == 0
    if not new:
        demand_ours(path)
    if not os.access(path.parent if new else path, os.W_OK):
        raise InputError(f"store of runs {str(path)!r} cannot be written: it may only be read")
    if not new:  # SQLite changes the file when WAL is set: whose it is must be known before
        with naming_file(path), closing(read_only(path)) as judged:
            has_tables(judged, path)
    with naming_file(path):
        connection = sqlite3.connect(path, timeout=BUSY, isolation_level=None)
        mode = connection.execute("PRAGMA journal_mode = WAL").fetchone()[0]
        if mode != "wal":
            connection.close()
            raise InputError(
                f"store of runs {str(path)!r} needs a local disk: this one cannot keep what is "
                f"written apart from what is read (journal mode {mode})"
            )
        connection.execute("PRAGMA synchronous = NORMAL")
        if new or not has_tables(connection, path):
            connection.execute(f"PRAGMA application_id = {APPLICATION}")
            connection.execute(f"PRAGMA user_version = {FORMAT}")
            connection.executescript(f"BEGIN; {TABLES} COMMIT;")
        return connection


def has_tables(connection: sqlite3.Connection, path: Path) -> bool:
    """Whether the tables are there: a kill while the file is made leaves one without.

    Raises InputError for views, triggers and tables of another kind: a view can be endless, and a
    trigger acts on whoever writes.
    """
    connection.execute("PRAGMA trusted_schema = OFF")
    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST)
    schema = connection.execute("SELECT type, name, rootpage FROM sqlite_master").fetchall()
    for kind, name, page in schema:
        if kind not in ("table", "index") or not page:  # a virtual table has no page of its own
            raise foreign_store_error(path, f"{str(name)[:80]!r} is no plain table")
    names = {name for kind, name, _ in schema if kind == "table"}
    if "run" not in names:
        return False
    for name, columns in COLUMNS.items():
        table_columns = connection.execute(f"PRAGMA table_xinfo({quote_column(name)})").fetchall()
        if not columns <= {row[1] for row in table_columns} or any(
            row[-1] for row in table_columns
        ):
            raise foreign_store_error(path, f"the table {name} has other columns")
    return True


def foreign_store_error(path: Path, why: str) -> InputError:
    """The refusal of a store that flockscope has not made so."""
    return InputError(f"{str(path)!r} is not a store of runs ({why}): move it away")


def open_for_reading(path: Path) -> sqlite3.Connection:
    """The file to read from, also while another process writes to it. Raises InputError."""
    if not path.is_file():
        raise InputError(f"{str(path)!r}: there is no store of runs")
    demand_ours(path)
    with naming_file(path, "read"):
        connection = read_only(path)
        try:
            is_store = has_tables(connection, path)
        except sqlite3.OperationalError:  # a folder that may only be read has no room for the WAL
            connection.close()
            connection = sqlite3.connect(f"{path.absolute().as_uri()}?immutable=1", uri=True)
            is_store = has_tables(connection, path)
        except BaseException:
            connection.close()
            raise
        if not is_store:
            connection.close()
            raise InputError(f"{str(path)!r}: there is no run in it yet")
        return connection


def read_only(path: Path) -> sqlite3.Connection:
    """A connection that changes nothing in the file."""
    return sqlite3.connect(
        f"{path.absolute().as_uri()}?mode=ro", uri=True, timeout=BUSY, isolation_level=None
    )


def demand_ours(path: Path) -> None:
    """Refuse what is no store of runs, or one of a newer flockscope, before it is changed."""
    try:
        with open(path, "rb") as file:
            head = file.read(100)
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read: {error.strerror}") from None
    if not head.startswith(b"SQLite format 3\0") or len(head) < 100:
        raise InputError(f"{str(path)!r} is not a store of runs: move it away")
    of, version = int.from_bytes(head[68:72], "big"), int.from_bytes(head[60:64], "big")
    if of not in (APPLICATION, 0) or (of == 0 and holds_tables(path)):
        raise InputError(f"{str(path)!r} is not a store of runs: move it away")
    if version > FORMAT:
        raise InputError(
            f"{str(path)!r} is of a newer flockscope (format {version}, here {FORMAT}): take that"
        )


def holds_tables(path: Path) -> bool:
    """Whether a file of SQLite that says nothing of whose it is holds anything: not ours then.

    One of ours says nothing yet where a kill came while it was made, or its head is in the WAL.
    """
    with naming_file(path, "read"), closing(read_only(path)) as connection:
        names = {row[0] for row in connection.execute("SELECT name FROM sqlite_master")}
        is_ours = connection.execute("PRAGMA application_id").fetchone()[0] == APPLICATION
        return bool(names) and not is_ours


def quote_column(column: str) -> str:
    """The name of a column as SQL has it."""
    return '"' + column.replace('"', '""') + '"'
