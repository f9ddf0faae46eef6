"""Recordings of a laboratory: a folder of Parquet tables that holds all that a replay needs.

========== ========================================================================================
frames     tick that took it, number, received (s), sent; one row a frame, also of an empty one
poses      tick, number, received, name, x, y (m), yaw (rad), valid; one row a body; gaps are null
commands   tick, now, name, what the rule wanted, what was sent; one row a car and tick
companions tick, name, x, y (m), yaw (rad), steer; one row a simulated car and tick, as it is after
events     tick, time, kind, words, car, cause, asked, note
ticks      tick, now (s), mode, arm, the injected car, latency (s); one row a tick
========== ========================================================================================

While it lasts each is a `.part` stream, as in `agents.recordings.recorder`, which holds all but the
last tenth of a second even if the process is killed; `app.live.recording.recovery` makes the tables
of what is left. What has become long goes on in another part: see
`app.live.laboratory.recording_parts`.
"""

from __future__ import annotations

import json
import os
import queue
import threading
import time
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from itertools import batched
from pathlib import Path
from typing import Any

from agents.recordings.part_stream import PartStream
from agents.recordings.recorder import KEY, refused
from agents.spec import versions
from app.live.control.car_control import TickRecord
from app.live.laboratory.lab_file import Lab, lab_from_toml
from app.live.laboratory.recording_parts import (
    MB,
    RESERVE,
    RecordingLimits,
    RecordingPart,
    part_of,
    parts_of,
)
from worlds.input_error import InputError
from worlds.plug_ins import demand_parquet

# The columns of the tables of a laboratory's recording: what each holds, and in which unit.

OF_TICK = ("1", "tick at which it was")
WHERE = {
    "x": ("m", "position along x"),
    "y": ("m", "position along y"),
    "yaw": ("rad", "heading, from +x anticlockwise"),
}
COLUMNS: dict[str, dict[str, tuple[str, str]]] = {
    "frames": {
        "tick": ("1", "tick that took the frame"),
        "number": ("1", "the frame's number"),
        "received": ("s", "when it came, on the loop's clock"),
        "sent": ("s", "when it was sent, on the source's own clock, where it tells"),
    },
    "poses": {
        "tick": ("1", "tick that took the frame"),
        "number": ("1", "the frame's number"),
        "received": ("s", "when the frame came, on the loop's clock"),
        "name": ("1", "the body's name"),
        **WHERE,
        "valid": ("1", "whether the tracking saw it"),
    },
    "commands": {
        "tick": OF_TICK,
        "now": ("s", "when the tick began, on the loop's clock"),
        "name": ("1", "the car's name"),
        "wanted_steer": ("1", "steering that the rule wanted, in [-1, 1], left is positive"),
        "wanted_throttle": ("1", "throttle that the rule wanted, in [-1, 1], forwards is positive"),
        "steer": ("1", "steering that was sent, in [-1, 1], left is positive"),
        "throttle": ("1", "throttle that was sent, in [-1, 1], forwards is positive"),
    },
    "companions": {
        "tick": OF_TICK,
        "name": ("1", "the simulated car's name"),
        **WHERE,
        "steer": ("1", "steering, in [-1, 1], left is positive"),
    },
    "events": {
        "tick": OF_TICK,
        "time": ("s", "when it was, on the loop's clock"),
        "kind": ("1", "what kind of event it is"),
        "words": ("1", "what happened"),
        "car": ("1", "the car that it is about"),
        "cause": ("1", "who or what caused it"),
        "asked": ("1", "the request that it answers"),
        "note": ("1", "what more the request said"),
    },
    "ticks": {
        "tick": ("1", "number of the tick"),
        "now": ("s", "when it began, on the loop's clock"),
        "mode": ("1", "what the cars were told: 0 stop, 1 run, 2 emergency stop"),
        "arm": ("1", "what the laboratory might do: safe, armed, emergency"),
        "injected_x": ("m", "the injected car's position along x"),
        "injected_y": ("m", "the injected car's position along y"),
        "injected_yaw": ("rad", "its heading, from +x anticlockwise"),
        "latency": ("s", "from when the newest frame came until its command was sent"),
    },
}
"""The columns of each table: unit, 1 for what has none, and meaning."""


def columns_of(table: str) -> dict[str, dict[str, str]]:
    """Units and meanings of a table's columns, as recordings of simulations have them."""
    return {
        name: {"unit": unit, "meaning": description}
        for name, (unit, description) in COLUMNS[table].items()
    }


def units_of(table: str) -> dict[str, str]:
    """Units of a table's columns, of those that have any."""
    return {name: unit for name, (unit, _) in COLUMNS[table].items() if unit != "1"}


def lab_metadata(lab: Lab) -> dict[str, Any]:
    """What a table's metadata says of the room beside the text of its laboratory."""
    area = lab.area
    return {
        "time_per_tick": 1.0 / lab.rate,
        "time_unit": "s",
        "length_unit": "m",
        "world_name": "laboratory",
        "world": {
            "title": lab.title,
            "edges": ["open", "open"],
            "dim": 2,
            "low": list(area.low),
            "size": [high - low for low, high in zip(area.low, area.high, strict=True)],
        },
    }


# A table on its way to the disk: an Arrow stream that a kill leaves readable, then Parquet.

LONGEST = 2**20
"""Bytes of a text in a table: events keep what was asked, whatever a browser sent."""
GROUP = 100_000
"""Rows of a row group of the Parquet file; the stream has some hundreds in a batch."""


class RecordingStream:
    """Rows of one table, with metadata, in a `.part` beside where its Parquet file will be.

    `columns` are names and Arrow types. Raises OSError if it cannot be written, or InputError.
    """

    def __init__(self, path: Path, columns: Mapping[str, str], meta: Mapping[str, Any]):
        demand_parquet("a recording of the laboratory")
        import pyarrow as pa

        self.path = path
        self.part = path.with_name(path.name + ".part")
        fields = [pa.field(name, arrow_type(kind)) for name, kind in columns.items()]
        self.schema = pa.schema(fields, {KEY: json.dumps(meta).encode()})
        self.file = self.part.open("wb")
        self.stream = pa.ipc.new_stream(self.file, self.schema)
        # the schema comes before the first batch, and a table without rows is to be readable too
        self.put([() for _ in fields])

    def write(self, rows: list[tuple]) -> None:
        """Append rows. Raises OSError."""
        if rows:
            self.put(list(zip(*rows, strict=True)))

    def put(self, columns: list[tuple]) -> None:
        """Append a batch of columns, and bring it to the disk. Raises OSError."""
        import pyarrow as pa

        arrays = [
            pa.array(column, field.type, from_pandas=False)
            for column, field in zip(columns, self.schema, strict=True)
        ]
        self.stream.write_batch(pa.RecordBatch.from_arrays(arrays, schema=self.schema))
        self.file.flush()

    @property
    def size(self) -> int:
        """Bytes written."""
        return self.file.tell()

    def close(self) -> None:
        """End the stream. Raises OSError."""
        self.stream.close()
        self.file.close()


def arrow_type(kind: str) -> Any:
    """An Arrow type by its name."""
    import pyarrow as pa

    return pa.bool_() if kind == "bool" else getattr(pa, kind)()


def finish(part: Path, path: Path) -> int:
    """Make the Parquet file `path` of all whole batches of a `.part`, which is removed; its rows.

    Raises OSError, or InputError if it is no stream of ours.
    """
    import pyarrow.parquet as pq

    temporary = path.with_name(path.name + ".tmp")
    rows = 0
    try:
        with open(part, "rb") as source:
            stream = PartStream(part, source, LONGEST)
            with pq.ParquetWriter(temporary, stream.schema, compression="zstd") as writer:
                for batch in stream.batches(GROUP):
                    writer.write_batch(batch)
                    rows += batch.num_rows
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
    part.unlink()
    return rows


FORMAT = 4
"""1 had no simulated cars, 2 no parts, 3 neither units nor the time of a tick."""
EVERY = 0.1
"""Seconds between which the tables are brought to the disk."""
AT_ONCE = 100
"""Ticks that are written at once at most."""
MOST_WAITING = 6000
"""Ticks, a minute of them, that wait for a disk that takes nothing before it is given up."""
TABLES = {
    "frames": {"tick": "int64", "number": "int64", "received": "float64", "sent": "float64"},
    "poses": {
        "tick": "int64",
        "number": "int64",
        "received": "float64",
        "name": "string",
        "x": "float64",
        "y": "float64",
        "yaw": "float64",
        "valid": "bool",
    },
    "commands": {
        "tick": "int64",
        "now": "float64",
        "name": "string",
        "wanted_steer": "float64",
        "wanted_throttle": "float64",
        "steer": "float64",
        "throttle": "float64",
    },
    "companions": {
        "tick": "int64",
        "name": "string",
        "x": "float64",
        "y": "float64",
        "yaw": "float64",
        "steer": "float64",
    },
    "events": {
        "tick": "int64",
        "time": "float64",
        "kind": "string",
        "words": "string",
        "car": "string",
        "cause": "string",
        "asked": "string",
        "note": "string",
    },
    "ticks": {
        "tick": "int64",
        "now": "float64",
        "mode": "int8",
        "arm": "string",
        "injected_x": "float64",
        "injected_y": "float64",
        "injected_yaw": "float64",
        "latency": "float64",
    },
}
"""The columns of each table and their types, in the order of writing: all that belongs to a tick
which is in `ticks` is on the disk already, however the process ends."""
NOWHERE = (None, None, None)


class RecordingWriter:
    """Writes a recording in a thread of its own, so that the loop never waits for the disk.

    A context manager; `laboratory` is its TOML, `limits` how much of it stays on the disk. Entering
    raises InputError if the folder has something in it or cannot be written.
    """

    def __init__(self, folder: str | Path, laboratory: str, limits: RecordingLimits | None = None):
        self.folder = Path(folder)
        self.laboratory = laboratory
        self.kept = limits or RecordingLimits()
        self.trouble = ""
        """Why it cannot write, in one line; empty while all is well."""
        self.waiting: queue.SimpleQueue[TickRecord] = queue.SimpleQueue()
        self.told: queue.SimpleQueue[str] = queue.SimpleQueue()
        """News of it that `new_lines` has not given yet."""
        self.ending = threading.Event()
        self.part = part_of(self.folder, 1)
        """The one that is being written."""
        self.streams: dict[str, RecordingStream] = {}
        """Its tables."""
        self.filing: list[Future[None]] = []
        """Parts before it of which tables are being made."""
        self.filer = ThreadPoolExecutor(1, "filing")

    def __enter__(self) -> RecordingWriter:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            if any(self.folder.iterdir()):
                raise InputError(
                    f"recording {str(self.folder)!r} exists already: name a new folder"
                )
            self.meta: dict[str, Any] = {
                "format": FORMAT,
                "laboratory": self.laboratory,
                "began": time.time(),
                "began_on_the_clock": time.monotonic(),
                "versions": versions(),
                **lab_metadata(lab_from_toml(self.laboratory, "laboratory")),
            }
            self.begin(self.part)
        except OSError as error:
            raise refused(self.folder, error) from None
        self.thread = threading.Thread(target=self.write_until_end, name="recording", daemon=True)
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Finish the tables, however the loop ended. Raises InputError if they cannot be
        written."""
        self.ending.set()
        self.thread.join()
        self.filer.shutdown()
        try:
            for stream in self.streams.values():
                stream.close()
            for part in parts_of(self.folder):  # also an earlier one that could not be made then
                self.file(part)
        except OSError as error:
            raise InputError(
                f"{refused(self.folder, error)}; what was written is in its .part files"
            ) from None
        if self.trouble:
            raise InputError(f"{self.trouble}; the recording ends there")

    def write(self, moment: TickRecord) -> None:
        """Take down a tick; it is written within EVERY seconds."""
        if self.trouble:
            return
        if self.waiting.qsize() >= MOST_WAITING:
            self.trouble = (
                f"recording {str(self.folder)!r} cannot be written: the disk has taken nothing for "
                f"{MOST_WAITING} ticks"
            )
            return
        self.waiting.put(moment)

    def new_lines(self) -> list[str]:
        """What is new of it, each in one line: parts that begin, and those that are removed."""
        messages = []
        with suppress(queue.Empty):
            while True:
                messages.append(self.told.get_nowait())
        return messages

    def write_until_end(self) -> None:
        """Write what waits, until the end."""
        ended = False
        while not ended:
            ended = self.ending.wait(EVERY)
            moments = []
            with suppress(queue.Empty):
                while True:
                    moments.append(self.waiting.get_nowait())
            try:
                for some in batched(moments, AT_ONCE):
                    for name, stream in self.streams.items():
                        stream.write(list(rows(name, some)))
                    if sum(stream.size for stream in self.streams.values()) >= MB * self.kept.part:
                        self.begin_next_part()
            except OSError as error:
                self.trouble = str(refused(self.folder, error))
                return

    def begin(self, part: RecordingPart) -> None:
        """Open the streams of a part. Raises OSError, and leaves nothing of a later part."""
        meta = self.meta | {"part": part.number}
        try:
            part.folder.mkdir(exist_ok=True)
            self.streams = {
                name: RecordingStream(part.table(name), columns, meta | {"units": units_of(name)})
                for name, columns in TABLES.items()
            }
        except OSError:
            if part.number > 1:
                part.remove()
            raise

    def begin_next_part(self) -> None:
        """Begin the next part; the tables of this one are made meanwhile. Raises OSError."""
        for stream in self.streams.values():
            stream.close()
        before, self.part = self.part, part_of(self.folder, self.part.number + 1)
        self.free_space()
        self.begin(self.part)
        self.told.put(f"the recording goes on in part {self.part.number}")
        self.filing.append(self.filer.submit(self.file, before))

    def free_space(self) -> None:
        """Remove the oldest parts for which there is no space any more. Raises OSError."""
        for filed in self.filing:  # what is still being made cannot be removed
            with suppress(OSError):  # said at the end
                filed.result()
        parts = parts_of(self.folder)
        sizes = {part.number: part.size() for part in parts}
        left = MB * (self.kept.most - RESERVE * self.kept.part)
        for part in parts[:-1]:
            if sum(sizes.values()) - sizes[parts[-1].number] <= left:
                return
            part.remove()
            del sizes[part.number]
            self.told.put(
                f"part {part.number} of the recording was removed: it keeps {self.kept.most:g} MB"
            )

    def file(self, part: RecordingPart) -> None:
        """Make the tables of a part that is closed. Raises OSError."""
        for name in TABLES:
            if part.stream(name).exists():
                finish(part.stream(name), part.table(name))


def rows(table: str, moments: Iterable[TickRecord]) -> Iterator[tuple]:
    """The rows of ticks in one table."""
    for moment in moments:
        match table:
            case "ticks":
                yield tick_row(moment)
            case "frames":
                for f in moment.frames:
                    yield (moment.tick, f.number, f.received, f.sent)
            case "poses":
                yield from pose_rows(moment)
            case "commands":
                yield from command_rows(moment)
            case "companions":
                for c in moment.step.companions:
                    yield (moment.tick, c.name, c.pose.x, c.pose.y, c.pose.yaw, c.steer)
            case "events":
                for e in moment.events:
                    yield (e.tick, e.time, e.kind, e.words, e.car, e.cause, e.asked, e.note)


def tick_row(moment: TickRecord) -> tuple:
    """The row of a tick."""
    target = moment.injected
    where = (target.x, target.y, target.yaw) if target is not None else NOWHERE
    mode = moment.step.verdict.mode
    return (moment.tick, moment.now, mode, moment.arm, *where, moment.latency)


def pose_rows(moment: TickRecord) -> Iterator[tuple]:
    """The rows of a tick's bodies."""
    for frame in moment.frames:
        for sighting in frame.sightings:
            pose = sighting.pose
            where = (pose.x, pose.y, pose.yaw) if pose is not None else NOWHERE
            yield (
                moment.tick,
                frame.number,
                frame.received,
                sighting.name,
                *where,
                sighting.valid,
            )


def command_rows(moment: TickRecord) -> Iterator[tuple]:
    """The rows of a tick's commands."""
    for name, sent in moment.step.verdict.commands.items():
        command = moment.step.wanted.get(name, (None, None))
        yield (moment.tick, moment.now, name, *command, *sent)
