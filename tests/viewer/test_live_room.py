"""The room behind the page of real cars: what is opened and closed when, and what stops it."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import pytest

from app.live.operating.choices import laboratory
from tests.viewer.live_rooms import EMULATED, armed, told
from tests.viewer.stub_desk import driver
from tests.viewer.waiting import until
from worlds.refusal import Refusal


def test_it_opens_the_file_s_own_room_and_shows_it(enter, desks):
    room = enter()
    state = room.state
    assert (state.status, state.trouble, state.run) == ("open", "", 1)
    assert (state.source, state.rule) == (next(iter(room.chosen.sources)), "squashing")
    assert state.model.rule.name == "squashing"
    assert state.values["beta"] == 2.0
    assert (len(desks.made), desks.last.recording, state.recording) == (1, None, "")
    assert room.frame.live.names == ("red", "blue")
    assert room.frame.run == 1
    assert [event.kind for event in room.events] == ["room", "room"]


def test_an_unknown_source_is_refused_at_once():
    with pytest.raises(Refusal, match="unknown source 'emulatd': did you mean 'emulated cars'"):
        laboratory(source="emulatd")


def test_it_arms_disarms_and_resets_and_keeps_all_events(enter):
    room = enter()
    armed(room)
    room.ask("disarm", "browser 2")
    room.emergency("browser 2")
    room.ask("reset", "browser 1")
    until(lambda: len(room.events) == 6)
    assert [(event.kind, event.cause) for event in room.events[2:]] == [
        ("arm", "browser 1"),
        ("disarm", "browser 2"),
        ("emergency", "browser 2"),
        ("reset", "browser 1"),
    ]
    told(room, "emergency (browser 2)")


@pytest.mark.parametrize("wish", ["tune", "hold", "fly", None, 7, ["arm"]])
def test_other_wishes_become_notices(enter, desks, wish):
    room = enter()
    room.ask(wish, "browser 1")
    told(room, "unknown request")
    assert desks.last.asked == []


def test_while_it_opens_only_an_emergency_stop_is_taken_and_goes_first(enter, desks):
    desks.gate.clear()
    room = enter(ready=False)
    until(lambda: desks.begun)
    room.ask("arm", "browser 1")
    told(room, "the room is not open (opening)")
    began = time.monotonic()
    room.emergency("browser 1")
    room.place(0.0, 0.0)
    assert time.monotonic() - began < 1.0
    assert room.state.latched
    desks.gate.set()
    until(lambda: room.look is not None and room.look.arm == "emergency")
    assert desks.last.wishes() == ["emergency"]
    room.ask("reset", "browser 1")
    until(lambda: not room.state.latched)


def test_an_emergency_stop_lasts_into_the_next_opening(enter, desks):
    room = enter()
    room.emergency("browser 1")
    until(lambda: room.look.arm == "emergency")
    room.choose(source=EMULATED)
    until(lambda: room.state.run == 2 and room.look is not None)
    assert (room.look.arm, desks.last.wishes()) == ("emergency", ["emergency"])
    room.ask("reset", "browser 1")
    until(lambda: room.look.arm == "safe")
    room.choose(rule=room.chosen.rules[1])
    until(lambda: room.state.run == 3 and room.look is not None)
    assert (room.look.arm, desks.last.wishes()) == ("safe", [])


def test_another_room_is_opened_only_while_the_cars_are_not_armed(enter, desks):
    room = enter()
    armed(room)
    room.choose(source=EMULATED, cause="browser 1")
    told(room, "no other room is opened while the cars are armed: disarm them first")
    assert (room.state.run, desks.last.closed) == (1, 0)
    room.ask("disarm", "browser 1")
    until(lambda: room.look.arm == "safe")
    room.choose(source=EMULATED, cause="browser 1")
    until(lambda: room.state.run == 2 and room.state.status == "open")
    assert (desks.made[0].closed, desks.last.lab.source) == (1, "simulated")
    assert desks.last.lab.link == "simulated"
    assert (room.state.source, room.events[-1].cause) == (EMULATED, "browser 1")


def test_of_several_choices_while_it_opens_only_the_last_is_opened(enter, desks):
    desks.gate.clear()
    room = enter(ready=False)
    until(lambda: desks.begun)
    room.choose(source=EMULATED)
    room.choose(link="dry run")
    room.choose(rule=room.chosen.rules[1])
    desks.gate.set()
    until(lambda: room.look is not None)
    assert room.state.rule == room.chosen.rules[1]
    assert room.state.source == EMULATED  # what is not given stays as it was chosen last
    first, last = desks.made
    assert (first.closed, first.asked, last.closed) == (1, [], 0)
    assert last.lab.rule == room.chosen.rules[1]


def test_a_room_that_is_about_to_be_closed_cannot_be_armed(enter, desks):
    waits = threading.Event()

    def slow(lab, tell):
        if desks.made:
            assert waits.wait(10)
        return driver(lab, tell)

    room = enter(driver=slow)
    room.choose(source=EMULATED)
    until(lambda: room.state.run == 2)
    room.ask("arm", "browser 1")
    told(room, "the room is not open (opening)")
    room.choose(link="dry run")
    room.ask("arm", "browser 1")
    told(room, "another room is about to be opened")
    waits.set()
    until(lambda: room.look is not None)
    assert all("arm" not in desk.wishes() for desk in desks.made)


def test_words_that_are_not_offered_are_refused_and_what_is_open_stays(enter, desks):
    room = enter()
    for given in ({"source": "udp:1.2.3.4:5"}, {"link": "serial:/dev/x"}, {"rule": "vicsek!"}):
        room.choose(**given)
        told(room, f"unknown {next(iter(given))}")
    time.sleep(0.1)
    assert (room.state.run, len(desks.made)) == (1, 1)


def test_what_cannot_be_opened_is_told_and_reopened(enter, desks):
    desks.refuses = "there is no such port"
    room = enter(ready=False)
    until(lambda: room.state.status == "failed")
    assert room.state.trouble == "there is no such port"
    told(room, "there is no such port")
    room.ask("arm", "browser 1")
    told(room, "the room is not open (failed)")
    room.emergency("browser 1")
    told(room, "the next room begins with it")
    desks.refuses = ""
    room.reopen("browser 1")
    until(lambda: room.look is not None)
    assert (room.state.status, room.state.trouble, room.look.arm) == ("open", "", "emergency")


def test_a_driver_that_cannot_be_made_does_not_end_the_room(enter, capsys):
    def broken(lab, tell):
        if lab.rule == "squashing":
            raise ZeroDivisionError("by zero")
        return driver(lab, tell)

    room = enter(ready=False, driver=broken)
    until(lambda: room.state.status == "failed")
    assert room.state.trouble == "by zero"
    assert "ZeroDivisionError" in capsys.readouterr().err
    room.choose(rule=room.chosen.rules[1])
    until(lambda: room.look is not None)


def test_a_loop_that_dies_is_told_and_leaves_nobody_believing_in_it(enter, desks):
    room = enter()
    armed(room)
    desks.last.trouble = "the control loop is gone: the cars stop themselves"
    until(lambda: room.state.status == "failed")
    assert room.look is None
    assert room.state.trouble == desks.last.trouble
    assert (set(room.frame.live.states), room.frame.live.arm) == ({"lost"}, "safe")
    told(room, "the control loop is gone")
    room.reopen("browser 1")
    until(lambda: room.look is not None)
    assert (room.look.arm, room.state.run) == ("safe", 2)


def test_a_process_that_ends_without_a_word_is_found_out(enter, desks):
    room = enter()
    desks.last.alive = False
    until(lambda: room.state.status == "failed")
    assert room.state.trouble == "the control loop has ended: the cars stop themselves"


def test_a_loop_that_falls_silent_is_said_to(enter, desks):
    room = enter()
    desks.last.mute = True
    until(lambda: room.state.trouble == "the control loop does not answer: what is shown is old")
    told(room, "the control loop does not answer")
    desks.last.mute = False
    until(lambda: room.state.trouble == "")
    assert room.state.status == "open"


def test_what_goes_wrong_in_a_look_is_told_once_and_the_stop_still_works(enter, desks, capsys):
    room = enter()
    whole = desks.last.look
    desks.last.look = lambda: replace(whole(), cars=(None,))
    told(room, "AttributeError")
    room.emergency("browser 1")
    assert desks.last.wishes() == ["emergency"]
    time.sleep(0.2)
    assert capsys.readouterr().err.count("Traceback") == 1
    desks.last.look = whole
    until(lambda: room.look.arm == "emergency" and room.state.trouble == "")


def test_from_a_room_that_cannot_be_looked_at_there_is_a_way_on(enter, desks):
    room = enter()
    desks.last.look = lambda: 1 / 0
    until(lambda: room.state.trouble == "division by zero")
    room.choose(source=EMULATED)
    until(lambda: room.state.run == 2 and room.look is not None)
    assert room.state.trouble == ""


def test_a_desk_that_is_slow_to_close_holds_no_stop_up(enter, desks):
    room = enter()
    waits = threading.Event()
    desks.last.close = lambda: waits.wait(10)
    room.reopen("browser 1")
    until(lambda: room.opened is None)
    began = time.monotonic()
    room.emergency("browser 2")
    room.place(0.0, 0.0)
    assert time.monotonic() - began < 1.0
    desks.made.pop()
    waits.set()
    until(lambda: room.look is not None and room.look.arm == "emergency")
    assert [request.cause for request in desks.last.asked] == ["browser 2"]


def test_each_opening_is_recorded_in_a_folder_of_its_own(enter, desks, tmp_path):
    room = enter(recording=tmp_path)
    first = desks.last.recording
    first.mkdir()
    assert (first.parent, room.state.recording) == (tmp_path, str(first))
    room.reopen("browser 1")
    until(lambda: room.state.run == 2 and room.state.status == "open")
    assert desks.last.recording.parent == tmp_path
    assert desks.last.recording != first


def test_closing_stops_the_cars_and_may_be_done_twice(enter, desks):
    room = enter()
    armed(room)
    room.close()
    room.close()
    assert (desks.last.closed, room.state.status) == (1, "closed")
    room.ask("arm", "browser 1")
    told(room, "the room is not open (closed)")
    room.reopen("browser 1")
    told(room, "the room is closed")
    room.emergency("browser 1")
    assert len(desks.made) == 1


def test_closed_while_it_opens_it_lets_go_of_what_comes(enter, desks, monkeypatch):
    monkeypatch.setattr("app.viewer.live.room.FAREWELL", 0.05)
    desks.gate.clear()
    room = enter(ready=False)
    until(lambda: desks.begun)
    began = time.monotonic()
    room.close()
    assert time.monotonic() - began < 1.0
    assert room.state.status == "closed"
    desks.gate.set()
    until(lambda: desks.made and desks.last.closed)
    assert room.state.status == "closed"
    assert desks.last.asked == []
