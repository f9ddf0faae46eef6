"""Replays a recording: the same rule behind the same safety, given its frames and requests.

What comes out must be what was sent, to the bit; where it is not, a replay says so.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from agents.recordings.parquet_table import ParquetTable
from agents.recordings.recorder import KEY, SHEET, table_writer
from app.live.control.arm import Action, OperatorRequest
from app.live.control.car_control import CarControl, ControlStep
from app.live.control.pose import Companion, Driver, MocapFrame, Pose, Sighting
from app.live.laboratory.lab_file import Lab, lab_from_toml
from app.live.laboratory.recording_parts import RecordingPart, parts_of
from app.live.recording.recording_writer import (
    LONGEST,
    TABLES,
    arrow_type,
    columns_of,
    lab_metadata,
)
from worlds.file_writer import writing
from worlds.input_error import InputError, shorten, unknown

if TYPE_CHECKING:
    import pandas as pd

METADATA: dict[str, Any] = {
    "format": int,
    "laboratory": str,
    "began": int | float,
    "began_on_the_clock": int | float,
}
"""What is read of the metadata of every table."""
NEVER_NULL = frozenset(
    ("tick", "number", "received", "now", "mode", "name", "steer", "throttle", "kind", "words")
)
"""Columns in which every row of every table has a value."""
BATCH = 10_000
"""Rows that are read at once."""
Row = dict[str, Any]


@dataclass(frozen=True)
class Tick:
    """One recorded tick."""

    number: int
    now: float
    mode: int
    requests: tuple[OperatorRequest, ...]
    frames: tuple[MocapFrame, ...]
    injected: Pose | None
    wanted: dict[str, tuple[float, float]]
    sent: dict[str, tuple[float, float]]
    companions: tuple[Companion, ...]
    """The simulated cars as they were after it."""


@dataclass(frozen=True)
class StoredRecording:
    """A recording; its ticks are read from the disk as they are asked for."""

    folder: Path
    lab: Lab
    began: float
    """Seconds since 1970."""
    began_on_the_clock: float
    """The same moment on the clock of `now`, s."""
    tables: tuple[str, ...]
    """Those that recordings of its format have."""
    parts: tuple[RecordingPart, ...]
    """Those that are there, the oldest first."""

    @property
    def removed(self) -> str:
        """Which of its parts are no longer there, in words; empty if it is whole."""
        first = self.parts[0].number
        if first == 1:
            return ""
        return "part 1" if first == 2 else f"parts 1 to {first - 1}"

    def ticks(self) -> Iterator[Tick]:
        """The ticks in their order."""
        for part in self.parts:
            tables = {name: Cursor(part.table(name)) for name in self.tables}
            for row in rows(part.table("ticks")):
                tick_rows = {name: cursor.take(row["tick"]) for name, cursor in tables.items()}
                yield tick_of(row, {"companions": [], **tick_rows})

    def events(self) -> list[Row]:
        """All that happened."""
        return [row for part in self.parts for row in rows(part.table("events"))]

    def demand_table(self, name: str) -> None:
        """Refuse the name of a table that it does not have. Raises InputError."""
        if name not in self.tables:
            raise unknown("table", name, self.tables, str(self.folder))

    def rows(self, name: str) -> int:
        """How many rows a table has in all parts."""
        return sum(open_table(part.table(name)).rows for part in self.parts)

    def table(self, name: str) -> Any:
        """A table with the rows of all parts, as a pyarrow Table. Raises InputError."""
        import pyarrow as pa

        self.demand_table(name)
        return pa.concat_tables(open_table(part.table(name)).read() for part in self.parts)

    def to_dataframe(self, name: str) -> pd.DataFrame:
        """A table as a data frame of pandas; `attrs` has units, meanings, the time of a tick, the
        capture area as a world's layout, and the laboratory as TOML. Raises InputError.
        """
        frame = self.table(name).to_pandas(ignore_metadata=True)
        columns = columns_of(name)
        frame.attrs.update(
            lab_metadata(self.lab),
            table=name,
            units={column_name: column["unit"] for column_name, column in columns.items()},
            meanings={column_name: column["meaning"] for column_name, column in columns.items()},
            began=self.began,
            laboratory=self.lab.to_toml(),
        )
        return frame

    def to_csv(self, name: str, path: str | Path, overwrite: bool = False) -> int:
        """Write a table as CSV; returns the rows. Raises InputError."""
        table = self.table(name)
        with (
            writing("--csv", path, overwrite, (SHEET,)) as out,
            table_writer(Path(path), out, table.schema) as writer,
        ):
            writer.write_table(table)
        return int(table.num_rows)


@dataclass(frozen=True)
class ReplayResult:
    """The result of a replay."""

    ticks: int
    """Ticks replayed."""
    commands: int
    """Commands compared."""
    differs: str
    """The first thing that came out differently, in words; empty: all is the same to the bit."""


def read(folder: str | Path) -> StoredRecording:
    """Open a recording. Raises InputError if it is none, or if it was killed and not yet
    recovered."""
    folder = Path(folder)
    demand_recording(folder)
    parts = tuple(parts_of(folder))
    meta = meta_of(parts[0].table("ticks"))
    tables = tuple(name for name in TABLES if meta["format"] > 1 or name != "companions")
    for place, part in enumerate(parts):
        if part.number != parts[0].number + place:
            raise InputError(
                f"{str(folder)!r} has no part {part.number - 1}, but part {part.number}"
            )
        for name in tables:
            if meta_of(part.table(name))["began"] != meta["began"]:
                raise InputError(f"{str(part.table(name))!r} is of another recording")
    lab = lab_from_toml(meta["laboratory"], str(folder))
    return StoredRecording(folder, lab, meta["began"], meta["began_on_the_clock"], tables, parts)


def demand_recording(folder: Path) -> None:
    """Refuse what is no folder of a recording. Raises InputError."""
    named = f"recording {str(folder)!r}"
    if not os.path.exists(folder):
        raise InputError(f"{named} cannot be read: there is no such folder")
    if not folder.is_dir():
        raise InputError(f"{named} cannot be read: it is no folder; `live run --record` makes one")
    if not parts_of(folder):
        raise InputError(
            f"{named} cannot be read: the folder has no ticks.parquet, as recordings do"
        )


def meta_of(path: Path) -> dict[str, Any]:
    """The metadata of a table. Raises InputError if it is none of a recording."""
    if path.with_name(path.name + ".part").exists():
        raise InputError(f"{str(path.parent)!r} was killed: recover it first")
    table = open_table(path)
    meta = table.metadata(KEY)
    missing = [name for name in TABLES[path.stem] if name not in table.names]
    if missing:
        raise InputError(f"{str(path)!r} has no column {missing[0]!r}")
    for name, kind in TABLES[path.stem].items():
        field_type = table.schema.field(name).type
        if field_type != arrow_type(kind):
            raise InputError(
                f"{str(path)!r}: its column {name!r} is {field_type}, {kind} is needed"
            )
    for key, of in METADATA.items():
        if not isinstance(meta.get(key), of):
            raise InputError(
                f"the metadata of {str(path)!r} is damaged: {key} is {shorten(meta.get(key))}"
            )
    return meta


def rows(path: Path) -> Iterator[Row]:
    """The rows of a table, read as they are asked for. Raises InputError."""
    for batch in open_table(path).batches(rows=BATCH):
        demand_whole(batch, path)
        yield from batch.to_pylist()


def demand_whole(table: Any, path: Path) -> None:
    """Refuse rows without what every row has. Raises InputError."""
    for name in NEVER_NULL & set(table.schema.names):
        if table[name].null_count:
            raise InputError(
                f"{str(path)!r} is damaged: its column {name!r} has rows without a value"
            )


def open_table(path: Path) -> ParquetTable:
    """A table of a recording, whoever made it; and what is read of it is bounded."""
    return ParquetTable(path, None, "a table of a laboratory's recording", LONGEST)


class Cursor:
    """The rows of a table tick by tick, in the order of ticks."""

    def __init__(self, path: Path):
        self.rows = rows(path)
        self.row = next(self.rows, None)

    def take(self, tick: int) -> list[Row]:
        """The rows of a tick; each tick can be taken once, and in order."""
        taken_rows = []
        while self.row is not None and self.row["tick"] <= tick:
            if self.row["tick"] == tick:
                taken_rows.append(self.row)
            self.row = next(self.rows, None)
        return taken_rows


def tick_of(row: Row, belongs: dict[str, list[Row]]) -> Tick:
    """A tick of its row and of those that belong to it."""
    return Tick(
        row["tick"],
        row["now"],
        row["mode"],
        tuple(requests(belongs["events"])),
        tuple(frames(belongs["frames"], belongs["poses"])),
        pose(row["injected_x"], row["injected_y"], row["injected_yaw"]),
        {
            record["name"]: (record["wanted_steer"], record["wanted_throttle"])
            for record in belongs["commands"]
            if record["wanted_steer"] is not None
        },
        {record["name"]: (record["steer"], record["throttle"]) for record in belongs["commands"]},
        tuple(
            Companion(
                record["name"], Pose(record["x"], record["y"], record["yaw"]), record["steer"]
            )
            for record in belongs["companions"]
        ),
    )


def requests(events: list[Row]) -> Iterator[OperatorRequest]:
    """The requests of a tick."""
    for event in events:
        if event["asked"]:
            yield OperatorRequest(cast("Action", event["asked"]), event["cause"], event["note"])


def frames(rows: list[Row], poses: list[Row]) -> Iterator[MocapFrame]:
    """The frames that a tick took."""
    for row in rows:
        yield MocapFrame(
            row["number"],
            row["received"],
            tuple(
                Sighting(
                    record["name"], pose(record["x"], record["y"], record["yaw"]), record["valid"]
                )
                for record in poses
                if record["number"] == row["number"]
            ),
            row["sent"],
        )


def pose(x: float | None, y: float | None, yaw: float | None) -> Pose | None:
    """A pose of three columns; None where they are null."""
    return None if x is None or y is None or yaw is None else Pose(x, y, yaw)


def steps(recorded: StoredRecording, driver: Driver) -> Iterator[tuple[Tick, ControlStep]]:
    """What the driver behind the safety of the recording's laboratory makes of every tick.

    Raises InputError if its beginning is no longer there: all that follows depends on it.
    """
    if recorded.removed:
        raise InputError(
            f"{str(recorded.folder)!r} cannot be replayed: {recorded.removed} of it were removed "
            f"([recording] keeps {recorded.lab.recording.most:g} MB), and a replay needs it from "
            "its beginning"
        )
    control = CarControl(recorded.lab.safety(), driver)
    begins = control.tick + 1
    for tick in recorded.ticks():
        if control.tick < begins < tick.number:
            raise InputError(
                f"{str(recorded.folder)!r} cannot be replayed: it was begun at tick "
                f"{tick.number} of its loop, and a replay needs it from its beginning; "
                "`flockscope live lab` shows it"
            )
        control.begin_tick(tick.now, tick.requests, tick.frames)
        yield tick, control.end_tick(tick.now, tick.injected)


def replay(folder: str | Path, make: Callable[[Lab], Driver]) -> ReplayResult:
    """Replay a recording with the driver that `make` makes of its laboratory. Raises InputError."""
    recorded = read(folder)
    count = compared = 0
    for tick, step in steps(recorded, make(recorded.lab)):
        count += 1
        compared += len(tick.sent)
        different = difference(tick, step)
        if different:
            return ReplayResult(count, compared, f"tick {tick.number}: {different}")
    return ReplayResult(count, compared, "")


def difference(tick: Tick, step: ControlStep) -> str:
    """How a replayed tick differs from the recorded one, in words; empty if in no bit."""
    if step.verdict.mode != tick.mode:
        return f"mode {step.verdict.mode} instead of {tick.mode}"
    for what, then, now in (
        ("wanted", tick.wanted, step.wanted),
        ("sent", tick.sent, step.verdict.commands),
    ):
        if then.keys() != now.keys():
            return f"{what} for {', '.join(now) or 'no car'}, not {', '.join(then) or 'no car'}"
        for name in then:
            if bits(then[name]) != bits(now[name]):
                return f"{what} for {name}: {now[name]} instead of {then[name]}"
    if len(tick.companions) != len(step.companions):
        return f"{len(step.companions)} simulated cars instead of {len(tick.companions)}"
    for before, companion in zip(tick.companions, step.companions, strict=True):
        if before.name != companion.name or bits(numbers(before)) != bits(numbers(companion)):
            return f"{companion} instead of {before}"
    return ""


def numbers(companion: Companion) -> tuple[float, ...]:
    """x, y, yaw and steering of a simulated car."""
    return companion.pose.x, companion.pose.y, companion.pose.yaw, companion.steer


def bits(values: Sequence[float]) -> bytes:
    """Numbers to the bit, so that 0 and -0 differ and NaN equals itself."""
    return struct.pack(f"<{len(values)}d", *values)
