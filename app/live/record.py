"""Recordings of a laboratory: a folder of Parquet tables that holds all that a replay needs.

========== ========================================================================================
frames     tick that took it, number, received (s), sent; one row a frame, also of an empty one
poses      tick, number, received, name, x, y (m), yaw (rad), valid; one row a body; gaps are null
commands   tick, now, name, what the rule wanted, what was sent; one row a car and tick
companions tick, name, x, y (m), yaw (rad), steer; one row a simulated car and tick, as it is after
events     tick, time, kind, words, car, cause, asked, note
ticks      tick, now (s), mode, arm, the injected car, latency (s); one row a tick
========== ========================================================================================

While it lasts each is a `.part` stream, as in `agents.record`, which holds all but the last half
second even if the process is killed; `recover` makes the tables of what is left.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from agents.record import refused
from agents.spec import versions
from app.live.moment import Moment
from app.live.stream import Stream, finish
from worlds.refusal import Refusal

FORMAT = 2
"""1 had no simulated cars."""
EVERY = 0.5
"""Seconds between which the tables are brought to the disk."""
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


class Recording:
    """Writes a recording in a thread of its own, so that the loop never waits for the disk.

    A context manager; `laboratory` is its TOML. Entering raises Refusal if the folder has something
    in it or cannot be written.
    """

    def __init__(self, folder: str | Path, laboratory: str):
        self.folder = Path(folder)
        self.laboratory = laboratory
        self.trouble = ""
        """Why it cannot write, in one line; empty while all is well."""
        self.waiting: queue.SimpleQueue[Moment] = queue.SimpleQueue()
        self.ending = threading.Event()
        self.streams: dict[str, Stream] = {}

    def __enter__(self) -> Recording:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            if any(self.folder.iterdir()):
                raise Refusal(f"recording {str(self.folder)!r} exists already: name a new folder")
            meta = {
                "format": FORMAT,
                "laboratory": self.laboratory,
                "began": time.time(),
                "began_on_the_clock": time.monotonic(),
                "versions": versions(),
            }
            for name in TABLES:
                self.streams[name] = Stream(self.folder / f"{name}.parquet", TABLES[name], meta)
        except OSError as error:
            raise refused(self.folder, error) from None
        self.thread = threading.Thread(target=self.keep_writing, name="recording", daemon=True)
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Finish the tables, however the loop ended. Raises Refusal if they cannot be written."""
        self.ending.set()
        self.thread.join()
        try:
            for stream in self.streams.values():
                stream.close()
            for stream in self.streams.values():
                finish(stream.part, stream.path)
        except OSError as error:
            raise Refusal(
                f"{refused(self.folder, error)}; what was written is in its .part files"
            ) from None
        if self.trouble:
            raise Refusal(f"{self.trouble}; the recording ends there")

    def write(self, moment: Moment) -> None:
        """Take down a tick; it is written within EVERY seconds."""
        if not self.trouble:
            self.waiting.put(moment)

    def keep_writing(self) -> None:
        """Write what waits, until the end."""
        ended = False
        while not ended:
            ended = self.ending.wait(EVERY)
            moments = []
            with suppress(queue.Empty):
                while True:
                    moments.append(self.waiting.get_nowait())
            try:
                for name, stream in self.streams.items():
                    stream.write(list(rows(name, moments)))
            except OSError as error:
                self.trouble = str(refused(self.folder, error))
                return


def rows(table: str, moments: Iterable[Moment]) -> Iterator[tuple]:
    """The rows of one table that ticks come to."""
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


def tick_row(moment: Moment) -> tuple:
    """The row of a tick."""
    target = moment.injected
    where = (target.x, target.y, target.yaw) if target is not None else NOWHERE
    mode = moment.step.verdict.mode
    return (moment.tick, moment.now, mode, moment.arm, *where, moment.latency)


def pose_rows(moment: Moment) -> Iterator[tuple]:
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


def command_rows(moment: Moment) -> Iterator[tuple]:
    """The rows of a tick's commands."""
    for name, sent in moment.step.verdict.commands.items():
        wanted = moment.step.wanted.get(name, (None, None))
        yield (moment.tick, moment.now, name, *wanted, *sent)


def recover(folder: str | Path) -> dict[str, int]:
    """Make the tables of a recording whose process was killed; rows by table.

    Raises Refusal if there is nothing to recover.
    """
    import pyarrow as pa

    folder = Path(folder)
    found = {}
    for name in TABLES:
        part = folder / f"{name}.parquet.part"
        if not part.exists():
            continue
        try:
            found[name] = finish(part, part.with_suffix(""))
        except (OSError, pa.ArrowInvalid) as error:
            raise Refusal(f"{str(part)!r} cannot be recovered: {error}") from None
    if not found:
        raise Refusal(f"{str(folder)!r} holds nothing to recover")
    return found
