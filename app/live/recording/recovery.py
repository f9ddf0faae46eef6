"""Recovers a recording whose process was killed, and reports the last commands to the cars."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.live.laboratory.recording_parts import RecordingPart, part_of, parts_of
from app.live.links.firmware import WATCHDOG
from app.live.links.link import EMERGENCY, RUN
from app.live.recording.recording_writer import EVERY, TABLES, finish
from worlds.input_error import InputError
from worlds.plug_ins import demand_parquet

END = "end"
"""The kind of the event that the loop writes when it has told the cars to stop and leaves."""


@dataclass(frozen=True)
class RecordingEnd:
    """How a recording ends."""

    tick: int
    """The last one."""
    seconds: float
    """When that was, from the beginning of the recording, s."""
    mode: int
    """What the cars were told: 0 stop, 1 run, 2 emergency stop."""
    commands: Mapping[str, tuple[float, float]]
    """(steer, throttle) by car."""
    end: str
    """What the loop wrote when it left; empty if it was killed."""

    @property
    def is_stop(self) -> bool:
        """Whether the last that is recorded is a stop."""
        return self.mode != RUN

    def describe(self) -> str:
        """What the cars were told last, and what stopped them."""
        if self.end:
            return self.end
        mode = {RUN: "run", EMERGENCY: "emergency stop"}.get(self.mode, "stop")
        commands = ", ".join(
            f"{name} steer {steer:.3f} throttle {throttle:.3f}"
            for name, (steer, throttle) in self.commands.items()
        )
        last = f"sent last at {self.seconds:.2f} s, tick {self.tick}: {mode}, {commands}"
        lost = f"what was sent in the {1000 * EVERY:g} ms after it may be missing"
        watchdog = f"{1000 * WATCHDOG:g} ms after the last command that they heard"
        if self.is_stop:
            return f"{last}; the cars had been told to stop ({lost})"
        return (
            f"{last}; no stop was sent after it, for the loop was killed ({lost}): the cars' own "
            f"watchdogs had to stop them, {watchdog}"
        )


def recover(folder: str | Path) -> dict[str, int]:
    """Make the tables of a recording whose process was killed; rows by table, of all its parts.

    Raises InputError if there is nothing to recover.
    """
    folder = Path(folder)
    for part in unbegun_parts(folder):
        part.remove()
    row_counts: dict[str, int] = {}
    for part in parts_of(folder):
        for name, rows in recover_part(part).items():
            row_counts[name] = row_counts.get(name, 0) + rows
    if not row_counts:
        raise InputError(f"{str(folder)!r} holds nothing to recover")
    return row_counts


def recover_part(part: RecordingPart) -> dict[str, int]:
    """The rows by table of what was left of a part, of which tables are made. Raises InputError."""
    demand_parquet("a recording of the laboratory")
    row_counts = {}
    for name in TABLES:
        stream = part.stream(name)
        if not stream.exists():
            continue
        try:
            row_counts[name] = finish(stream, part.table(name))
        except OSError as error:
            raise InputError(f"{str(stream)!r} cannot be recovered: {error}") from None
    return row_counts


def unbegun_parts(folder: Path) -> list[RecordingPart]:
    """Later parts that a kill has left before there was anything in them."""
    parts = parts_of(folder)
    if not parts:
        return []
    after = part_of(folder, parts[-1].number + 1)
    return [after] if after.folder.is_dir() else []


def read_end(folder: str | Path) -> RecordingEnd | None:
    """How a recording ends, of which there are tables; None if it has no tick. Raises
    InputError."""
    from app.live.recording.recording_replay import meta_of

    parts = [part for part in parts_of(Path(folder)) if part.table("ticks").exists()]
    for part in reversed(parts):
        for name in ("ticks", "commands", "events"):
            meta_of(part.table(name))
        ticks = last_rows(part, "ticks", 1)
        if not ticks:
            continue
        tick = ticks[0]
        commands = {
            row["name"]: (row["steer"], row["throttle"])
            for row in last_rows(part, "commands", None)
            if row["tick"] == tick["tick"]
        }
        ends = [row["words"] for row in last_rows(part, "events", None) if row["kind"] == END]
        began = start_clock(part)
        return RecordingEnd(
            tick["tick"], tick["now"] - began, tick["mode"], commands, ends[-1] if ends else ""
        )
    return None


def last_rows(part: RecordingPart, name: str, count: int | None) -> list[dict[str, Any]]:
    """The last rows of a table, at most those of its last group. Raises InputError."""
    from app.live.recording.recording_replay import demand_whole, open_table

    file = open_table(part.table(name))
    for group in reversed(range(len(file.offsets) - 1)):
        table = file.group(group)
        demand_whole(table, part.table(name))
        if table.num_rows:
            first = 0 if count is None else max(table.num_rows - count, 0)
            rows: list[dict[str, Any]] = table.slice(first).to_pylist()
            return rows
    return []


def start_clock(part: RecordingPart) -> float:
    """When the recording of a part began, by the clock of its ticks, s. Raises InputError."""
    from app.live.recording.recording_replay import meta_of

    return float(meta_of(part.table("ticks"))["began_on_the_clock"])
