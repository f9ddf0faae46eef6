"""A room with all that is behind it: the loop in its process, tracking, link and emulated cars."""

from __future__ import annotations

import math
import time
from pathlib import Path

import pytest

from app.live.example import example
from app.live.operating.squashing_driver import FlockDriver
from app.live.recording.replay import replay
from app.viewer.live.room import Room
from tests.viewer.waiting import until

PATIENCE = 120.0
"""Seconds for what may have to be compiled first, on a machine that is busy."""
AGAIN = 0.5
"""Seconds between two attempts to arm."""


@pytest.fixture
def room(tmp_path):
    one = Room(example(), "emulated cars", tmp_path)
    yield one
    one.close()


def until_driven(room, condition):
    """Wait for something of cars that drive; arm, and again where a busy machine had them held."""
    asked = -math.inf

    def happens():
        nonlocal asked
        assert room.state.status in ("opening", "open"), room.state.trouble
        look = room.look
        if look is None:
            return False
        if look.arm == "safe" and not look.reasons and time.monotonic() - asked > AGAIN:
            asked = time.monotonic()
            room.ask("arm", "browser 1")
        return look.arm == "armed" and condition()

    until(happens, PATIENCE, str([event.words for event in room.events[-5:]]))


def gone(pid):
    """Whether a process has ended."""
    stat = Path(f"/proc/{pid}/stat")
    return not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] == "Z"


def children(pid):
    return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def test_it_opens_drives_stops_and_leaves_nothing_behind(room):
    until_driven(room, lambda: room.frame.speed.min() > 0.3)
    assert room.frame.live.names == ("red", "blue")
    began = room.frame.position[0]
    until_driven(room, lambda: math.dist(room.frame.position[0], began) > 0.3)
    assert room.tune("beta", 2.5, "browser 1").result(10) == 2.5
    assert room.state.values["beta"] == 2.5
    room.accompany(2, "browser 1")
    until_driven(room, lambda: room.frame.live.names[2:] == ("sim 1", "sim 2"))
    until_driven(room, lambda: room.frame.speed[2:].min() > 0.2)
    until_driven(room, lambda: set(room.readings.lags) >= {"red", "blue", "sim 1"})
    assert 0.1 < room.readings.least.newest < 6.0
    assert 8.0 < room.readings.loop.newest < 30.0

    stopped = room.look.time
    room.emergency("browser 2")
    until(lambda: room.look.arm == "emergency")
    until(lambda: room.frame.speed.max() < 0.05)
    assert room.look.time - stopped < 2.0
    here = room.frame.position
    until(lambda: room.look.time > stopped + 3.0)
    assert room.frame.position == pytest.approx(here, abs=0.02)
    asked = [event.kind for event in room.events if event.cause.startswith("browser")]
    assert [kind for kind in asked if kind != "arm"] == ["tune", "accompany", "emergency"]

    process = room.opened.desk.process.pid
    family = [process, *children(process)]
    recording = room.state.recording
    room.close()
    assert all(gone(pid) for pid in family)
    assert not room.thread.is_alive()
    replayed = replay(recording, FlockDriver)
    assert (replayed.differs, replayed.ticks > 300) == ("", True)
