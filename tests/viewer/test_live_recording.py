"""Recording by a button, and earlier recordings in the place of the room."""

from __future__ import annotations

import math

import pytest

from app.live.control.car_control import ControlStep, TickRecord
from app.live.control.pose import Companion, MocapFrame, Pose, Sighting
from app.live.control.safety import SafetyDecision
from app.live.laboratory.lab_file import example
from app.live.links.link import RUN, STOP
from app.live.recording.recording_writer import RecordingWriter
from app.viewer.live.panels.recording_panel import describe_moment
from app.viewer.live.panels.room_monitors import contents
from app.viewer.live.panels.room_panel import facts
from app.viewer.live.panels.state_panel import banner_of
from app.viewer.live.room_replay import RoomReplay, find_recording, recording_names
from app.viewer.panels.monitors import CARDS
from tests.viewer.live_sessions import armed, told
from tests.viewer.waiting import until
from worlds.input_error import InputError

TICKS, FIRST, LOST = 400, 21, 300
"""Ticks, the number of the first, and how many have poses."""


def pose(tick: int) -> Pose:
    return Pose(0.01 * tick, -1.0, 0.001 * tick)


def moment(tick: int, cars) -> TickRecord:
    now = 50.0 + 0.01 * tick
    seen = tuple(Sighting(one.body, pose(tick), True) for one in cars.values())
    frames = (MocapFrame(tick, now - 0.002, seen, now - 0.01),) if tick < FIRST + LOST else ()
    mode = RUN if tick > 100 else STOP
    commands = dict.fromkeys(cars, (0.25, 0.5))
    beside = (Companion("sim 1", Pose(1.0, 2.0, 0.0), 0.1),)
    step = ControlStep(commands, SafetyDecision(mode, commands, ()), (), beside)
    arm = "armed" if mode == RUN else "safe"
    return TickRecord(tick, now, frames, pose(tick), step, arm, (), 0.003)


@pytest.fixture(scope="module")
def shelf(tmp_path_factory):
    """A folder with a recording, one that is not finished, and what is none."""
    folder = tmp_path_factory.mktemp("shelf")
    lab = example()
    for name in ("2026-11-22-101500", "2026-11-21-080000"):
        with RecordingWriter(folder / name, lab.to_toml()) as recording:
            for tick in range(FIRST, FIRST + TICKS):
                recording.write(moment(tick, lab.cars))
    (folder / "going-on").mkdir()
    (folder / "going-on" / "ticks.parquet.part").write_bytes(b"")
    (folder / "holiday").mkdir()
    (folder / "notes.txt").write_text("")
    return folder


@pytest.fixture
def room(enter, shelf):
    session = enter()
    session.shelf = shelf
    return session


def test_a_button_begins_and_ends_a_recording_in_a_new_folder(enter, operators, tmp_path):
    session = enter()
    session.record(True, "browser 1")
    told(session, "there is no folder for recordings")
    session.shelf = tmp_path
    session.record(True, "browser 1")
    until(lambda: session.state.recording)
    assert operators.last.recording.parent == tmp_path
    session.record(False, "browser 1")
    until(lambda: not session.state.recording)
    assert len(operators.made) == 1  # the loop has gone on


def test_finished_recordings_are_listed_and_nothing_else_can_be_named(shelf):
    assert recording_names(shelf) == ("2026-11-22-101500", "2026-11-21-080000")
    for name in ("going-on", "holiday", "..", "../shelf", "/etc", "", "2026"):
        with pytest.raises(InputError, match="recording"):
            find_recording(shelf, name)
    assert recording_names(None) == recording_names(shelf / "none") == ()


def test_a_recording_is_shown_in_the_place_of_the_room_and_nothing_is_sent(room, operators):
    operator = operators.last
    room.play("2026-11-22-101500", "browser 1")
    until(lambda: room.state.phase == "replay" and room.status is not None)
    assert (operator.closed, room.opening) == (1, None)
    assert banner_of(room.state, room.status).kind == "replay"
    place = facts(room.state, room.status, room.lab.injected)
    assert "In the recording" in place
    assert "it is at" not in place
    when = describe_moment(room.replaying)
    cards = contents(room.status, room.frame, room.readings, 2, None, when)[CARDS]
    assert "2026-11-22-101500, not as it is now" in cards
    assert "browsers" not in cards
    asked = list(operator.asked)
    room.ask("arm", "terminal")
    told(room, "the room is not open (replay)")
    room.record(True, "browser 1")
    told(room, "the room is not open (replay)")
    assert operator.asked == asked
    assert len(operators.made) == 1
    room.reopen("browser 1")
    until(lambda: room.state.phase == "open" and room.status is not None)
    assert room.replaying is None
    assert len(operators.made) == 2


def test_an_emergency_stop_during_a_replay_is_there_when_the_room_opens(room):
    room.play("2026-11-22-101500", "browser 1")
    until(lambda: room.state.phase == "replay")
    room.emergency("browser 2")
    assert room.state.latched
    room.reopen("browser 1")
    until(lambda: room.status is not None and room.status.arm == "emergency")


def test_no_recording_is_shown_while_the_cars_are_armed(room, operators):
    armed(room)
    room.play("2026-11-22-101500", "browser 1")
    told(room, "no recording is shown while the cars are armed")
    assert (room.state.phase, operators.last.closed) == ("open", 0)


def test_a_recording_that_is_damaged_is_a_notice(room, shelf, tmp_path):
    broken = tmp_path / "broken"
    broken.mkdir()
    for file in (shelf / "2026-11-22-101500").iterdir():
        (broken / file.name).write_bytes(file.read_bytes()[:-9])
    room.shelf = tmp_path
    room.play("broken", "browser 1")
    told(room, "is not a table")
    until(lambda: room.state.phase == "failed")


def test_it_is_played_sought_and_paused(shelf):
    shown = RoomReplay(shelf / "2026-11-22-101500", 3)
    assert (shown.first, shown.last, shown.seconds) == (FIRST, FIRST + TICKS - 1, 3.99)
    status, frame = shown.play(10.0)
    assert (status.tick, frame.run, frame.tick) == (FIRST, 3, FIRST)
    status, frame = shown.play(10.5)
    assert status.tick == FIRST + 50
    car = status.cars[0]
    assert (car.pose, car.sent, car.runs) == (pose(FIRST + 50), (0.25, 0.5), False)
    assert car.age == pytest.approx(0.002)
    assert [one.name for one in status.companions] == ["sim 1"]
    assert status.period.median == pytest.approx(0.01)
    shown.toggle()
    assert shown.play(12.0)[0].tick == FIRST + 50
    shown.seek(3.5)
    status, frame = shown.play(12.1)
    assert (status.tick, status.arm) == (FIRST + 350, "armed")
    assert {one.tracking for one in status.cars} == {"lost"}
    assert status.cars[0].pose == pose(FIRST + LOST - 1)
    shown.toggle()
    shown.speed = 10.0
    shown.play(12.2)
    assert shown.play(13.0)[0].tick == shown.last
    assert not shown.plays
    shown.toggle()
    assert shown.play(13.0)[0].tick == FIRST


@pytest.mark.parametrize("time", [math.nan, math.inf, "later", None])
def test_a_time_that_is_none_is_a_notice(room, time):
    room.play("2026-11-21-080000", "browser 1")
    until(lambda: room.state.phase == "replay")
    room.seek(time)
    told(room, "time")
