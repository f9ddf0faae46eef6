"""Recordings hold all that a replay needs: it gives the same commands to the bit."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from agents.recordings import parquet_table
from app.live.control.arm import OperatorRequest
from app.live.control.car_control import CarControl
from app.live.control.control_loop import Loop
from app.live.control.injected_target import InjectedTarget
from app.live.control.pose import MocapFrame, Pose, Sighting
from app.live.links.link import EMERGENCY, RUN, STOP
from app.live.links.link_catalogue import open_link
from app.live.recording.recording_replay import bits, read, replay
from app.live.recording.recording_writer import TABLES, RecordingWriter
from app.live.recording.recovery import recover
from live.rooms import LAB, Steady, lab
from worlds.input_error import InputError

ROOT = Path(__file__).parents[2]
ARM = OperatorRequest("arm", "test")


class Nervous:
    """A driver with a memory, a seed and a parameter: nothing of it can be told from one tick."""

    def __init__(self):
        self.rng = np.random.default_rng(7)
        self.memory = 0.1
        self.gain = 0.3

    def drive(self, now, sightings, injected, _running):
        told = {}
        for sighting in sightings:
            pose = sighting.pose
            far = math.hypot(injected.x - pose.x, injected.y - pose.y)
            self.memory = math.sin(self.memory + pose.yaw + now) + self.rng.normal(scale=1e-3)
            told[sighting.name] = (self.gain * self.memory, min(1.0, 0.2 + far / 3.0))
        return told

    def tune(self, values):
        if set(values) != {"gain"}:
            raise InputError(f"unknown parameter {next(iter(values))!r}")
        self.gain = values["gain"]


class Wild:
    """A feed of cars that go where they are told, with every fault that tracking can have."""

    trouble = ""

    def __init__(self, clock, radio, seed):
        self.clock = clock
        self.radio = radio
        self.rng = np.random.default_rng(seed)
        self.number = 0
        self.at = {1: np.array([-1.0, 0.0, 0.3]), 2: np.array([-1.0, 1.0, 0.0])}
        self.speed = {1: 0.0, 2: 0.0}

    def since(self, _number):
        frames = []
        for _ in range(self.rng.choice([0, 1, 1, 1, 1, 2])):
            self.number += 1
            bodies = [
                Sighting(name, Pose(*(at + self.rng.normal(scale=0.0005, size=3))), True)
                for name, at in (("red", self.at[1]), ("blue body", self.at[2]))
            ]
            fault = self.rng.integers(40)
            if fault == 0:
                bodies = []
            elif fault == 1:
                bodies[0] = Sighting("red", None, False)
            elif fault == 2:
                bodies[1] = Sighting("blue body", Pose(math.nan, 0.0, -0.0), True)
            elif fault == 3:
                bodies.append(bodies[0])
            elif fault == 4:
                bodies[0] = Sighting("red", Pose(9.0, 9.0, 0.0), True)
            elif fault == 5:
                bodies.append(Sighting("a chair", Pose(0.0, 0.0, 0.0), True))
            sent = None if fault == 6 else self.number / 100.0
            frames.append(MocapFrame(self.number, self.clock() - 0.004, tuple(bodies), sent))
        self.drive()
        return frames

    def drive(self):
        if self.radio.last is None:
            return
        for address, at in self.at.items():
            _, throttle = self.radio.last.commands[address]
            self.speed[address] += (throttle - self.speed[address]) * 0.065
            at[0] += 0.01 * self.speed[address]


class Ticking:
    """A clock that goes on by 10 ms, about, when it is waited for."""

    def __init__(self, seed):
        self.now = 1234.5
        self.rng = np.random.default_rng(seed)

    def __call__(self):
        return self.now

    def wait(self, seconds):
        self.now += seconds + self.rng.exponential(0.0005)


def make(_lab):
    return Nervous()


def record(folder, ticks=600, seed=1, requests=None, text=LAB, make=make):
    """Record a run with faults; the loop."""
    requests = {5: ARM, 150: ARM, 300: ARM} if requests is None else requests
    one = lab(text)
    clock, radio = Ticking(seed), open_link("dry")
    with RecordingWriter(folder, text) as journal:
        loop = Loop(
            CarControl(one.safety(), make(one)),
            Wild(clock, radio, seed),
            radio,
            one.addresses,
            InjectedTarget(one.injected, one.area),
            journal,
            one.rate,
            clock,
            clock.wait,
        )
        for k in range(ticks):
            if k in requests:
                loop.ask(requests[k])
            loop.tick()
            clock.wait(0.01)
    return loop


@pytest.mark.parametrize("seed", range(4))
def test_a_replay_is_the_same_to_the_bit(tmp_path, seed):
    record(tmp_path / "run", seed=seed)
    replayed = replay(tmp_path / "run", make)
    assert replayed.differs == ""
    assert (replayed.ticks, replayed.commands) == (600, 1200)
    recorded = read(tmp_path / "run")
    assert {tick.mode for tick in recorded.ticks()} == {STOP, RUN}
    assert len({bits(tick.sent["red"]) for tick in recorded.ticks()}) > 100


def test_what_was_asked_is_replayed(tmp_path):
    asked = {
        5: ARM,
        100: OperatorRequest("tune", "browser 1", json.dumps({"gain": 0.1 + 0.2})),
        120: OperatorRequest("tune", "browser 1", json.dumps({"grain": 1})),
        130: OperatorRequest("tune", "browser 1", "no JSON"),
        131: OperatorRequest("tune", "browser 1", "[1]"),
        132: OperatorRequest("tune", "browser 1", "[" * 100_000),
        150: OperatorRequest("emergency", "terminal", "a foot"),
        170: ARM,
        180: OperatorRequest("reset", "terminal"),
        190: ARM,
        250: OperatorRequest("disarm", "terminal"),
    }
    loop = record(tmp_path / "run", 300, seed=16, requests=asked)
    assert replay(tmp_path / "run", make).differs == ""
    recorded = read(tmp_path / "run")
    assert {tick.mode for tick in recorded.ticks()} == {STOP, RUN, EMERGENCY}
    assert loop.control.driver.gain == 0.1 + 0.2
    told = [(e["tick"], e["kind"], e["cause"]) for e in recorded.events() if e["asked"]]
    assert told == [
        (5, "arm", "test"),
        (100, "tune", "browser 1"),
        (120, "refused", "browser 1"),
        (130, "refused", "browser 1"),
        (131, "refused", "browser 1"),
        (132, "refused", "browser 1"),
        (150, "emergency", "terminal"),
        (170, "refused", "test"),
        (180, "reset", "terminal"),
        (190, "arm", "test"),
        (250, "disarm", "terminal"),
    ]


def test_a_replay_says_where_it_differs(tmp_path):
    record(tmp_path / "run", 100)

    def other(_lab):
        driver = Nervous()
        driver.gain = math.nextafter(driver.gain, 1.0)
        return driver

    differs = replay(tmp_path / "run", other).differs
    assert differs.startswith("tick ")
    assert "wanted for" in differs


def test_a_changed_pose_is_found(tmp_path):
    record(tmp_path / "run", 100)
    path = tmp_path / "run" / "poses.parquet"
    table = pq.read_table(path)
    yaw = table["yaw"].to_numpy().copy()
    yaw[50:60] += 1e-9
    column = table.column_names.index("yaw")
    pq.write_table(table.set_column(column, "yaw", pa.array(yaw)), path)
    assert replay(tmp_path / "run", make).differs != ""


def test_the_tables_are_those_of_the_docstring(tmp_path):
    record(tmp_path / "run", 20)
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == sorted(
        f"{name}.parquet" for name in TABLES
    )
    for name, columns in TABLES.items():
        table = pq.read_table(tmp_path / "run" / f"{name}.parquet")
        assert table.column_names == list(columns)
        meta = json.loads(table.schema.metadata[b"flockscope"])
        assert meta["laboratory"] == LAB
        assert abs(meta["began"] - time.time()) < 600.0
    ticks = pq.read_table(tmp_path / "run" / "ticks.parquet")
    assert ticks["tick"].to_pylist() == list(range(20))


def test_gaps_are_recorded_as_gaps(tmp_path):
    record(tmp_path / "run", 400)
    frames = [frame for tick in read(tmp_path / "run").ticks() for frame in tick.frames]
    assert [frame.number for frame in frames] == list(range(1, len(frames) + 1))
    assert any(not frame.sightings for frame in frames)
    assert any(sighting.pose is None for frame in frames for sighting in frame.sightings)
    assert any(frame.sent is None for frame in frames)
    minus_zero = [
        s.pose
        for frame in frames
        for s in frame.sightings
        if s.pose is not None and math.isnan(s.pose.x)
    ]
    assert minus_zero
    assert all(math.copysign(1.0, pose.yaw) == -1.0 for pose in minus_zero)


KILLED = """
import os, signal, sys, time
sys.path[:0] = {path!r}
from live.test_live_record import record
import live.test_live_record as here

wait = here.Ticking.wait
def slow(self, seconds):
    wait(self, seconds)
    time.sleep(0.002)
here.Ticking.wait = slow
record({folder!r}, 100_000)
"""


def test_a_killed_recording_is_recovered_and_replays(tmp_path):
    folder = tmp_path / "run"
    path = [str(ROOT), str(ROOT / "tests")]
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED.format(path=path, folder=str(folder))], cwd=ROOT
    )
    part = folder / "ticks.parquet.part"
    ends = time.monotonic() + 60.0
    while not part.exists() or part.stat().st_size < 60_000:
        assert time.monotonic() < ends
        time.sleep(0.05)
    process.kill()
    process.wait()
    with pytest.raises(InputError, match="was killed: recover it first"):
        read(folder)
    with open(part, "r+b") as file:  # as if the kill had come in the middle of a write
        file.truncate(os.path.getsize(part) - 7)
    rows = recover(folder)
    assert set(rows) == set(TABLES)
    assert rows["ticks"] > 100
    replayed = replay(folder, make)
    assert replayed.differs == ""
    assert replayed.ticks > 100
    with pytest.raises(InputError, match="holds nothing to recover"):
        recover(folder)


def test_a_kill_at_once_leaves_tables_without_rows(tmp_path):
    folder = tmp_path / "run"
    journal = RecordingWriter(folder, LAB)
    journal.__enter__()
    left = {part.name: part.read_bytes() for part in folder.iterdir()}  # as a kill would leave it
    journal.__exit__()
    for path in folder.iterdir():
        path.unlink()
    for name, content in left.items():
        (folder / name).write_bytes(content)
    assert recover(folder) == dict.fromkeys(TABLES, 0)
    assert list(read(folder).ticks()) == []


def test_a_recording_writes_over_nothing(tmp_path):
    record(tmp_path / "run", 3)
    with pytest.raises(InputError, match="exists already: name a new folder"):
        RecordingWriter(tmp_path / "run", LAB).__enter__()


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        RecordingWriter(tmp_path / "file" / "run", LAB).__enter__()


def test_a_full_disk_is_said_and_holds_nothing_up(tmp_path):
    class Full:
        def write(self, _rows):
            raise OSError(28, "No space left on device")

    one = lab()
    clock, radio = Ticking(1), open_link("dry")
    journal = RecordingWriter(tmp_path / "run", LAB)
    journal.__enter__()
    loop = Loop(
        CarControl(one.safety(), Steady()),
        Wild(clock, radio, 1),
        radio,
        one.addresses,
        InjectedTarget(one.injected, one.area),
        journal,
        one.rate,
        clock,
        clock.wait,
    )
    loop.tick()
    full = Full()
    full.close = journal.streams["ticks"].close
    journal.streams["ticks"] = full
    ends = time.monotonic() + 30.0
    while not journal.trouble:
        assert time.monotonic() < ends
        time.sleep(0.02)
    loop.tick()
    kinds = [(event.kind, event.words) for event in loop.events.since(0)[1]]
    assert ("recording", journal.trouble) in kinds
    assert "No space left on device" in journal.trouble
    assert journal.waiting.qsize() <= 1


def test_a_table_of_a_recording_that_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    record(tmp_path / "run", 30)
    monkeypatch.setattr(parquet_table, "MOST_NUMBERS", 10)
    found = read(tmp_path / "run")
    for look in (lambda: found.table("commands"), lambda: list(found.ticks()), found.events):
        with pytest.raises(InputError, match="at most 10 numbers are read at once"):
            look()


def test_what_is_no_recording_is_refused(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read(tmp_path)
    record(tmp_path / "run", 3)
    pq.write_table(pa.table({"tick": [1]}), tmp_path / "run" / "ticks.parquet")
    with pytest.raises(InputError, match="is not a table of a laboratory's recording"):
        read(tmp_path / "run")
