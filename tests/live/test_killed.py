"""Killed while armed: what the recording says is what the cars' own log says."""

from __future__ import annotations

import json
import os
import signal
from contextlib import contextmanager

import pytest
from cli.calling import call

from app.live.control.control_loop import PARTING
from app.live.links.firmware import WATCHDOG
from app.live.links.link import RUN, STOP
from app.live.recording.recording_replay import read, replay
from app.live.recording.recording_writer import EVERY
from live.logged_cars import LoggedRoom
from live.rooms import ROUND, Steady
from live.served_room import descendants, is_there
from tests.live.waiting import until

APART = 0.5
"""Metres between the middles of two cars that have come nowhere near each other."""
GONE = 60.0
"""Seconds within which processes have ended."""


@pytest.fixture
def room(tmp_path):
    with LoggedRoom(tmp_path) as one:
        yield one


@contextmanager
def ended(room):
    """What is done within leaves no process of the room."""
    others = [room.loop, *descendants(room.loop)]
    yield
    room.process.wait()
    until(lambda: not any(map(is_there, others)), GONE)


def again(_lab):
    return Steady(ROUND)


def test_the_operator_is_killed_and_the_recording_says_that_the_cars_were_told_to_stop(room):
    with ended(room):
        room.process.kill()
    modes = room.silence()
    room.stand()
    assert modes[-PARTING:] == [STOP] * PARTING
    recorded = read(room.recording)  # finished: nothing is left to recover
    ticks = list(recorded.ticks())
    assert [tick.mode for tick in ticks[-PARTING:]] == [STOP] * PARTING
    assert [tick.mode for tick in ticks].count(STOP) == modes.count(STOP)
    assert len(ticks) == len(room.heard)  # every frame that the cars heard is there
    for tick, heard in zip(ticks[-200:], room.heard[-200:], strict=True):
        assert tick.mode == heard.mode
        assert tick.sent["red"] == pytest.approx(heard.commands[1], abs=0.01)
    # On a busy machine a frame of poses may be late, and a car unseen for a moment.
    events = [event for event in recorded.events() if event["kind"] != "unseen"]
    assert [event["kind"] for event in events[-3:]] == ["hold", "stop", "end"]
    assert events[-3]["words"] == "held: the operator is gone"
    assert events[-1]["words"] == (
        "the control loop ends (the operator is gone): 5 frames told the cars to stop"
    )
    assert replay(room.recording, again).differs == ""
    assert room.closest() > APART


def heard_last(room, ending):
    """The frame that the recording has as the last one, as the cars heard it."""
    (found,) = [one for one in room.heard if one.seq == ending["tick"] + 1]
    return found


@pytest.mark.parametrize("who", ["the loop", "operator and loop"])
def test_the_loop_is_killed_and_recover_says_what_was_sent_last(room, who):
    with ended(room):
        if who == "the loop":
            os.kill(room.loop, signal.SIGKILL)
        else:
            os.killpg(room.process.pid, signal.SIGKILL)
    assert room.silence()[-1] == RUN
    room.stand()
    assert room.states() == {"lost"}
    last = room.heard[-1].time
    for address in (1, 2):
        now, state = room.firmware.changes[address][-1]
        assert state == "lost"
        assert now - last >= WATCHDOG
    made = call("live", "recover", room.recording, "--json")
    assert made.exit_code == 0, made.stderr
    ending = json.loads(made.stdout)["ending"]
    assert (ending["mode"], ending["told_to_stop"], ending["end"]) == (RUN, False, "")
    heard = heard_last(room, ending)
    assert heard.mode == RUN
    for name, address in (("red", 1), ("blue", 2)):
        assert heard.commands[address] == pytest.approx(ending["commands"][name], abs=0.01)
        assert f"{name} steer 0.367 throttle 0.900" in ending["words"]
    lost = room.heard[-1].seq - heard.seq
    assert 0 <= lost <= 100 * 20 * EVERY  # a tenth of a second; a machine may be very busy
    assert "no stop was sent after it" in ending["words"]
    assert "watchdogs had to stop them, 250 ms after the last command" in ending["words"]
    assert replay(room.recording, again).differs == ""
    assert len(list(read(room.recording).ticks())) == ending["tick"] + 1
    assert room.closest() > APART
