"""A recording of real cars that is looked at: no loop is open, and nothing is sent to anybody."""

from __future__ import annotations

import math
from collections import deque
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from agents.catalogue import cars_for_rule, obedient_car_models
from app.live.control.arm import State
from app.live.control.loop_status import (
    DURATIONS_KEPT,
    CarStatus,
    DurationSummary,
    Status,
    tracking,
)
from app.live.control.pose import Companion, Pose
from app.live.laboratory.recording_parts import RecordingPart, parts_of
from app.live.links.link import RUN
from app.live.recording.recording_replay import StoredRecording, open_table, read
from app.viewer.live.loop_connection import KEPT as PAST
from app.viewer.live.room_frame import RoomReadings, Setting, frame_of
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError, unknown

# The folder of recordings: which are in it, and how large they are.

MOST = 200
"""Recordings that are listed, the newest by name."""


def recording_names(shelf: Path | None) -> tuple[str, ...]:
    """The names of finished recordings in a folder, the newest first."""
    if shelf is None:
        return ()
    try:
        names = sorted((path.name for path in shelf.iterdir() if path.is_dir()), reverse=True)
    except OSError:
        return ()
    return tuple(name for name in names[: 5 * MOST] if is_finished(shelf / name))[:MOST]


def is_finished(folder: Path) -> bool:
    """Whether a folder holds a recording of which nothing is being written."""
    try:
        parts = parts_of(folder)
        return bool(parts) and not any(part.stream("ticks").exists() for part in parts)
    except OSError:
        return False


def find_recording(shelf: Path | None, name: str) -> Path:
    """The recording of a name that is listed, and of no other. Raises InputError."""
    names = recording_names(shelf)
    if shelf is None or name not in names:
        raise (
            unknown("recording", name[:80], names) if names else InputError("there is no recording")
        )
    return shelf / name


def size(folder: Path) -> int:
    """Bytes of a recording so far."""
    try:
        return sum(part.size() for part in parts_of(folder))
    except OSError:
        return 0


STILL = (0.0, 0.0)
ARMS: tuple[State, ...] = ("safe", "armed", "emergency")


class RoomReplay:
    """Plays a recording; used by the session's thread. Raises InputError for what is none.

    `at` is the tick that is shown, `first` and `last` are those that are there.
    """

    def __init__(self, folder: Path, run: int):
        self.name = folder.name
        self.recorded: StoredRecording = read(folder)
        lab = self.recorded.lab
        try:
            model = cars_for_rule(lab.rule)
            self.values = model.parameters(**lab.parameters).model_dump()
        except (InputError, ValueError):  # a rule that is not at hand is not needed to look on
            model, self.values = cars_for_rule(next(iter(obedient_car_models()))), {}
        self.setting = Setting.of(run, lab, model)
        self.tables = lru_cache(2)(self.load)
        self.spans = [span(part) for part in self.recorded.parts]
        if any(before[1] >= after[0] for before, after in pairwise(self.spans)):
            raise InputError(f"the parts of {str(folder)!r} are not in order")
        self.first, self.last = self.spans[0][0], self.spans[-1][1]
        self.at = float(self.first)
        self.plays = True
        self.speed = 1.0
        self.readings = RoomReadings(lab.injected)
        self.past: deque[Status] = deque(maxlen=PAST)
        self.known: float | None = None
        """When it was last played on, s."""

    @property
    def seconds(self) -> float:
        """How long it lasts, s."""
        return (self.last - self.first) / self.setting.lab.rate

    @property
    def time(self) -> float:
        """How far it has been played, s."""
        return (self.at - self.first) / self.setting.lab.rate

    def load(self, place: int) -> RecordingTables:
        """The tables of a part."""
        return RecordingTables(self.recorded.parts[place], self.setting)

    def toggle(self) -> None:
        """Pause, or play on; at the end, from the beginning."""
        self.plays = not self.plays
        if self.plays and self.at >= self.last:
            self.seek(0.0)

    def seek(self, time: float) -> None:
        """Go to a time, s."""
        tick = self.first + time * self.setting.lab.rate
        tick = min(max(tick, self.first), self.last)
        if tick < self.at:
            self.readings = RoomReadings(self.setting.lab.injected)
        self.past.clear()
        self.at = float(tick)

    def play(self, now: float) -> tuple[Status, Frame]:
        """Play on to `now` (s, by any clock); what is to be shown then."""
        if self.plays and self.known is not None:
            self.at += (now - self.known) * self.speed * self.setting.lab.rate
            if self.at >= self.last:
                self.at, self.plays = float(self.last), False
        self.known = now
        status = self.status(int(self.at))
        frame = frame_of(self.setting, status, self.values, tuple(self.past))
        if not self.past or self.past[-1].time < status.time:
            self.readings.note(status)
            self.past.append(status)
        return status, frame

    def status(self, tick: int) -> Status:
        """The room at a tick, or at the last one before it."""
        place = max(0, sum(first <= tick for first, _ in self.spans) - 1)
        return self.tables(place).status(tick)


def span(part: RecordingPart) -> tuple[int, int]:
    """The first and the last tick of a part. Raises InputError if it has none."""
    ticks = open_table(part.table("ticks")).read(["tick"])["tick"].to_numpy()
    if not len(ticks) or (np.diff(ticks) <= 0).any():
        raise InputError(f"{str(part.folder)!r} holds no ticks in their order")
    return int(ticks[0]), int(ticks[-1])


class RecordingTables:
    """The tables of one part, by what is looked up in them."""

    def __init__(self, part: RecordingPart, setting: Setting):
        lab = setting.lab
        self.lab = lab
        ticks = columns(part, "ticks")
        self.tick, self.now, self.mode = ticks["tick"], ticks["now"], ticks["mode"]
        self.arm, self.latency = ticks["arm"], ticks["latency"]
        self.injected = np.column_stack([ticks[f"injected_{axis}"] for axis in ("x", "y", "yaw")])
        self.poses = pose_rows(columns(part, "poses"), {car.body: n for n, car in lab.cars.items()})
        commands = columns(part, "commands")
        self.sent = {
            name: select_rows(commands, commands["name"] == name, ("tick", "steer", "throttle"))
            for name in lab.cars
        }
        simulated: dict[str, Any] = {}
        if part.table("companions").exists():
            simulated = columns(part, "companions")
        self.companions = {
            name: select_rows(
                simulated, simulated["name"] == name, ("tick", "x", "y", "yaw", "steer")
            )
            for name in dict.fromkeys(simulated.get("name", ()))
        }

    def status(self, tick: int) -> Status:
        """The room at a tick, or at the last one before it."""
        row = max(0, int(np.searchsorted(self.tick, tick, side="right")) - 1)
        tick, now, mode = int(self.tick[row]), float(self.now[row]), int(self.mode[row])
        since = max(0, row - DURATIONS_KEPT)
        arm: State = next((state for state in ARMS if state == self.arm[row]), "safe")
        spent = (now - self.now[0]) * self.lab.rate
        return Status(
            tick,
            now,
            arm,
            mode,
            (),
            tuple(self.car(name, tick, now, mode) for name in self.lab.cars),
            pose(self.injected[row]),
            tuple(self.simulated(tick)),
            DurationSummary.of(np.diff(self.now[since : row + 1])),
            DurationSummary.of(self.latency[since : row + 1]),
            max(0, round(spent) - row),
            0,
            {},
            0,
        )

    def car(self, name: str, tick: int, now: float, mode: int) -> CarStatus:
        """One car at a tick: where it was last seen, and what it was told."""
        pose_row, command_row = (
            last_row(self.poses.get(name), tick),
            last_row(self.sent[name], tick),
        )
        car_pose = None if pose_row is None else pose(pose_row[2:5])
        age = (
            math.inf if pose_row is None or car_pose is None else max(0.0, now - float(pose_row[1]))
        )
        sent = STILL if command_row is None else (float(command_row[1]), float(command_row[2]))
        return CarStatus(
            name, car_pose, age, tracking(age, self.lab.limits.stale), mode == RUN, sent
        )

    def simulated(self, tick: int) -> list[Companion]:
        """The simulated cars of a tick."""
        rows = ((name, last_row(rows, tick)) for name, rows in self.companions.items())
        placed = ((name, row, pose(row[1:4])) for name, row in rows if row is not None)
        return [
            Companion(name, at, float(row[4]))
            for name, row, at in placed
            if at is not None and int(row[0]) == tick
        ]


def columns(part: RecordingPart, table: str) -> dict[str, np.ndarray]:
    """The columns of a table; what is missing is NaN, and words are objects."""
    arrays = open_table(part.table(table)).read()
    return {name: arrays[name].to_numpy() for name in arrays.column_names}


def select_rows(
    table: dict[str, np.ndarray], chosen: np.ndarray, names: tuple[str, ...]
) -> np.ndarray:
    """Chosen rows of some columns, (M, K), by tick; only those that are finite numbers."""
    rows = np.column_stack([table[name][chosen].astype(float) for name in names])
    return rows[np.isfinite(rows).all(axis=1)]


def pose_rows(table: dict[str, np.ndarray], bodies: dict[str, str]) -> dict[str, np.ndarray]:
    """Where each car was seen: by its name rows of tick, received (s), x, y (m), yaw (rad)."""
    valid = table["valid"].astype(bool)
    names = ("tick", "received", "x", "y", "yaw")
    return {
        car: select_rows(table, valid & (table["name"] == body), names)
        for body, car in bodies.items()
    }


def last_row(rows: np.ndarray | None, tick: int) -> np.ndarray | None:
    """The last row up to a tick; None if there is none."""
    if rows is None:
        return None
    place = int(np.searchsorted(rows[:, 0], tick, side="right")) - 1
    return None if place < 0 else rows[place]


def pose(numbers: np.ndarray) -> Pose | None:
    """A pose of x, y and yaw; None where one is missing."""
    return Pose(*map(float, numbers)) if np.isfinite(numbers).all() else None
