"""A room with all that is behind it: the loop in its process, tracking, link and emulated cars."""

from __future__ import annotations

import math
import time
from pathlib import Path

import pytest

from app.live.operating.flock_driver import FlockDriver
from app.live.operating.lab_choices import laboratory
from app.live.recording.recording_replay import replay
from app.viewer.live.session import Session
from tests.viewer.waiting import until

TIMEOUT = 120.0
"""Seconds for what may have to be compiled first, on a machine that is busy."""
AGAIN = 0.5
"""Seconds between two attempts to arm."""


@pytest.fixture
def session(tmp_path):
    one = Session(laboratory(source="emulated cars"), tmp_path)
    yield one
    one.close()


def until_driven(session, condition):
    """Wait for something of cars that drive; arm, and again where a busy machine had them held."""
    asked = -math.inf

    def happens():
        nonlocal asked
        assert session.state.phase in ("opening", "open"), session.state.trouble
        status = session.status
        if status is None:
            return False
        if status.arm == "safe" and not status.reasons and time.monotonic() - asked > AGAIN:
            asked = time.monotonic()
            session.ask("arm", "browser 1")
        return status.arm == "armed" and condition()

    until(happens, TIMEOUT, str([event.words for event in session.events[-5:]]))


def gone(pid):
    """Whether a process has ended."""
    stat = Path(f"/proc/{pid}/stat")
    return not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] == "Z"


def children(pid):
    return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def test_it_opens_drives_stops_and_leaves_nothing_behind(session):
    until_driven(session, lambda: session.frame.speed.min() > 0.3)
    assert session.frame.live.names == ("red", "blue")
    began = session.frame.position[0]
    until_driven(session, lambda: math.dist(session.frame.position[0], began) > 0.3)
    assert session.set_parameter("beta", 2.5, "browser 1").result(60) == 2.5
    assert session.state.values["beta"] == 2.5
    session.set_companions(2, "browser 1")
    until_driven(session, lambda: session.frame.live.names[2:] == ("sim 1", "sim 2"))
    until_driven(session, lambda: session.frame.speed[2:].min() > 0.2)
    until_driven(session, lambda: set(session.readings.lags) >= {"red", "blue", "sim 1"})
    assert 0.1 < session.readings.least.newest < 6.0
    assert 8.0 < session.readings.loop.newest < 30.0

    stopped = session.status.time
    session.emergency("browser 2")
    until(lambda: session.status.arm == "emergency")
    until(lambda: session.frame.speed.max() < 0.05)
    assert session.status.time - stopped < 2.0
    here = session.frame.position
    until(lambda: session.status.time > stopped + 3.0)
    assert session.frame.position == pytest.approx(here, abs=0.02)
    asked = [event.kind for event in session.events if event.cause.startswith("browser")]
    assert [kind for kind in asked if kind != "arm"] == ["tune", "accompany", "emergency"]

    process = session.opening.operator.process.pid
    family = [process, *children(process)]
    recording = session.state.recording
    session.close()
    assert all(gone(pid) for pid in family)
    assert not session.thread.is_alive()
    replayed = replay(recording, FlockDriver)
    assert (replayed.differs, replayed.ticks > 300) == ("", True)
