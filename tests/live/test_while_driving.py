"""Processes that are stopped, a full disk and a clock that jumps, while emulated cars drive.

In each the cars stop or go on as docs/live-safety.md says, nothing collides, and the recording can
be read and replays to the bit up to its end. The log of the cars themselves tells.
"""

from __future__ import annotations

import ast
import os
import signal
import time
from itertools import pairwise
from pathlib import Path

import pytest
from cli.calling import call

from app.live.links.link import STOP
from app.live.recording.recording_replay import read, replay
from app.live.recording.recording_writer import TABLES
from live.logged_cars import LoggedRoom
from live.rooms import ROUND, Steady
from live.served_room import is_there
from live.told_poses import HOUR, MOST_BYTES

ROOT = Path(__file__).parents[2]
APART = 0.5
"""Metres between the middles of two cars that have come nowhere near each other."""


@pytest.fixture
def room(tmp_path):
    with LoggedRoom(tmp_path) as one:
        yield one


def again(_lab):
    return Steady(ROUND)


def replays(room):
    """The operator is killed, the loop finishes its recording, which replays; its events."""
    room.process.kill()
    room.process.wait()
    room.silence()
    room.until(lambda: not list(room.recording.rglob("*.part")))
    assert replay(room.recording, again).differs == ""
    assert room.closest() > APART
    return read(room.recording).events()


def test_the_page_is_stopped_and_goes_on(room):
    before = len(room.heard)
    os.kill(room.process.pid, signal.SIGSTOP)
    room.until(lambda: room.heard[-1].mode == STOP)
    room.stand()
    assert room.states() == {"stopped"}
    stopped = len(room.heard)
    os.kill(room.process.pid, signal.SIGCONT)
    room.until(lambda: len(room.heard) > stopped + 100)
    assert {one.mode for one in room.heard[stopped:]} == {STOP}  # not let go by itself
    numbers = [one.seq for one in room.heard[before:]]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))  # the loop went on
    events = replays(room)
    held = max(k for k, event in enumerate(events) if event["kind"] == "hold")
    assert events[held]["words"] == "held: the operator has been silent for 2 s"
    assert "arm" not in [event["kind"] for event in events[held:]]


def test_the_loop_is_stopped_and_goes_on(room):
    os.kill(room.loop, signal.SIGSTOP)
    try:
        room.silence()
        assert room.states() == {"lost"}  # nobody but the cars themselves has stopped them
        room.stand()
        time.sleep(1.0)
        before = len(room.heard)
    finally:
        os.kill(room.loop, signal.SIGCONT)
    room.until(lambda: len(room.heard) > before + 100)
    modes = [one.mode for one in room.heard[before:]]
    # a frame that was about to be sent when the loop was stopped may come first
    assert set(modes[1:]) == {STOP}
    room.stand()
    events = replays(room)
    held = [event["words"] for event in events if event["kind"] == "hold"]
    assert "the loop stood still for" in held[-1]


def test_the_disk_is_full(tmp_path):
    with LoggedRoom(tmp_path, "crowded", once=False) as room:
        parts = [room.recording / f"{name}.parquet.part" for name in TABLES]
        room.until(lambda: max(part.stat().st_size for part in parts) >= MOST_BYTES)
        before = len(room.heard)
        room.until(lambda: len(room.heard) > before + 150)
        room.until(room.drive)  # the cars drive on
        numbers = [one.seq for one in room.heard[before:]]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
        room.process.kill()
        room.process.wait()
        assert room.silence()[-1] == STOP
        room.stand()
        room.until(lambda: not is_there(room.loop))
        made = call("live", "recover", room.recording)
        assert made.exit_code == 0, made.stderr
        assert "sent last at" in made.stdout
        replayed = replay(room.recording, again)
        assert replayed.differs == ""
        assert replayed.ticks > 100
        assert room.closest() > APART


def test_the_time_of_day_jumps(tmp_path):
    with LoggedRoom(tmp_path, "jumping", once=False) as room:
        before = len(room.heard)
        room.until(lambda: len(room.heard) > before + 150)
        room.until(room.drive)
        replays(room)
        ticks = [tick.now for tick in read(room.recording).ticks()]
        assert all(0.0 < after - before < HOUR / 60 for before, after in pairwise(ticks))


ALLOWED = {
    ("app/live/recording/recording_writer.py", "time.time"),
    ("app/viewer/live/session.py", "datetime.now"),
    ("app/viewer/live/session_requests.py", "datetime.now"),
    ("app/viewer/live/panels/log_panel.py", "datetime.now"),
    ("app/viewer/live/panels/log_panel.py", "time.time"),
}
"""Who asks for the time of day: names of files and folders, what is shown, nothing that decides."""


def test_nothing_that_drives_asks_for_the_time_of_day():
    found = set()
    places = [*(ROOT / "app/live").rglob("*.py"), *(ROOT / "app/viewer/live").rglob("*.py")]
    for path in [*places, *(ROOT / "app/cli").glob("live*.py")]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                name = f"{node.value.id}.{node.attr}"
                if name in ("time.time", "time.time_ns", "datetime.now", "datetime.today"):
                    found.add((str(path.relative_to(ROOT)), name))
    assert found == ALLOWED
