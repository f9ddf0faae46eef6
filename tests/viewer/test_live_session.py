"""The room behind the page of real cars: what is opened and closed when, and what stops it."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import pytest

from app.live.operating.lab_choices import laboratory
from tests.viewer.live_sessions import EMULATED, armed, told
from tests.viewer.stub_operator import driver
from tests.viewer.waiting import until
from worlds.input_error import InputError


def test_it_opens_the_file_s_own_room_and_shows_it(enter, operators):
    session = enter()
    state = session.state
    assert (state.phase, state.trouble, state.run) == ("open", "", 1)
    assert (state.source, state.rule) == (next(iter(session.chosen.sources)), "squashing")
    assert state.model.rule.name == "squashing"
    assert state.values["beta"] == 2.0
    assert (len(operators.made), operators.last.recording, state.recording) == (1, None, "")
    assert session.frame.live.names == ("red", "blue")
    assert session.frame.run == 1
    assert [event.kind for event in session.events] == ["room", "room"]


def test_an_unknown_source_is_refused_at_once():
    with pytest.raises(InputError, match="unknown source 'emulatd': did you mean 'emulated cars'"):
        laboratory(source="emulatd")


def test_it_arms_disarms_and_resets_and_keeps_all_events(enter):
    session = enter()
    armed(session)
    session.ask("disarm", "browser 2")
    session.emergency("browser 2")
    session.ask("reset", "browser 1")
    until(lambda: len(session.events) == 6)
    assert [(event.kind, event.cause) for event in session.events[2:]] == [
        ("arm", "browser 1"),
        ("disarm", "browser 2"),
        ("emergency", "browser 2"),
        ("reset", "browser 1"),
    ]
    told(session, "emergency (browser 2)")


def test_it_keeps_why_the_cars_were_disarmed_until_they_are_armed_again(enter, operators):
    session = enter()
    armed(session)
    operators.last.happens("hold", "stopped until armed again: blue is frozen", "safety")
    until(lambda: session.state.disarmed)
    assert session.state.disarmed == "stopped until armed again: blue is frozen (safety)"
    operators.last.happens("disarm", "disarmed: nothing changed", "browser 1")
    operators.last.happens("arm", "armed", "browser 1")
    until(lambda: not session.state.disarmed)
    operators.last.happens("emergency", "EMERGENCY STOP", "browser 1")
    until(lambda: session.state.disarmed == "EMERGENCY STOP (browser 1)")
    count = len(session.events)
    operators.last.happens("emergency", "EMERGENCY STOP: nothing changed", "browser 2")
    until(lambda: len(session.events) > count)
    assert session.state.disarmed == "EMERGENCY STOP (browser 1)"


@pytest.mark.parametrize("action", ["tune", "hold", "fly", None, 7, ["arm"]])
def test_other_wishes_become_notices(enter, operators, action):
    session = enter()
    session.ask(action, "browser 1")
    told(session, "unknown request")
    assert operators.last.asked == []


def test_while_it_opens_only_an_emergency_stop_is_taken_and_goes_first(enter, operators):
    operators.gate.clear()
    session = enter(ready=False)
    until(lambda: operators.begun)
    session.ask("arm", "browser 1")
    told(session, "the room is not open (opening)")
    session.emergency("browser 1")
    session.place(0.0, 0.0)
    assert session.state.latched
    assert not operators.made, "it waited until the room was open"
    operators.gate.set()
    until(lambda: session.status is not None and session.status.arm == "emergency")
    assert operators.last.actions() == ["emergency"]
    session.ask("reset", "browser 1")
    until(lambda: not session.state.latched)


def test_an_emergency_stop_lasts_into_the_next_opening(enter, operators):
    session = enter()
    session.emergency("browser 1")
    until(lambda: session.status.arm == "emergency")
    session.choose(source=EMULATED)
    until(lambda: session.state.run == 2 and session.status is not None)
    assert (session.status.arm, operators.last.actions()) == ("emergency", ["emergency"])
    session.ask("reset", "browser 1")
    until(lambda: session.status.arm == "safe")
    session.choose(rule=session.chosen.rules[1])
    until(lambda: session.state.run == 3 and session.status is not None)
    assert (session.status.arm, operators.last.actions()) == ("safe", [])


def test_another_room_is_opened_only_while_the_cars_are_not_armed(enter, operators):
    session = enter()
    armed(session)
    session.choose(source=EMULATED, cause="browser 1")
    told(session, "no other room is opened while the cars are armed: disarm them first")
    assert (session.state.run, operators.last.closed) == (1, 0)
    session.ask("disarm", "browser 1")
    until(lambda: session.status.arm == "safe")
    session.choose(source=EMULATED, cause="browser 1")
    until(lambda: session.state.run == 2 and session.state.phase == "open")
    assert (operators.made[0].closed, operators.last.lab.source) == (1, "simulated")
    assert operators.last.lab.link == "simulated"
    assert (session.state.source, session.events[-1].cause) == (EMULATED, "browser 1")


def test_of_several_choices_while_it_opens_only_the_last_is_opened(enter, operators):
    operators.gate.clear()
    session = enter(ready=False)
    until(lambda: operators.begun)
    session.choose(source=EMULATED)
    session.choose(link="dry run")
    session.choose(rule=session.chosen.rules[1])
    operators.gate.set()
    until(lambda: session.status is not None)
    assert session.state.rule == session.chosen.rules[1]
    assert session.state.source == EMULATED  # what is not given stays as it was chosen last
    first, last = operators.made
    assert (first.closed, first.asked, last.closed) == (1, [], 0)
    assert last.lab.rule == session.chosen.rules[1]


def test_a_room_that_is_about_to_be_closed_cannot_be_armed(enter, operators):
    waits = threading.Event()

    def slow(lab, tell):
        if operators.made:
            assert waits.wait(60)
        return driver(lab, tell)

    session = enter(driver=slow)
    session.choose(source=EMULATED)
    until(lambda: session.state.run == 2)
    session.ask("arm", "browser 1")
    told(session, "the room is not open (opening)")
    session.choose(link="dry run")
    session.ask("arm", "browser 1")
    told(session, "another room is about to be opened")
    waits.set()
    until(lambda: session.status is not None)
    assert all("arm" not in operator.actions() for operator in operators.made)


def test_words_that_are_not_offered_are_refused_and_what_is_open_stays(enter, operators):
    session = enter()
    for given in ({"source": "udp:1.2.3.4:5"}, {"link": "serial:/dev/x"}, {"rule": "vicsek!"}):
        session.choose(**given)
        told(session, f"unknown {next(iter(given))}")
    time.sleep(0.1)
    assert (session.state.run, len(operators.made)) == (1, 1)


def test_what_cannot_be_opened_is_told_and_reopened(enter, operators):
    operators.refuses = "there is no such port"
    session = enter(ready=False)
    until(lambda: session.state.phase == "failed")
    assert session.state.trouble == "there is no such port"
    told(session, "there is no such port")
    session.ask("arm", "browser 1")
    told(session, "the room is not open (failed)")
    session.emergency("browser 1")
    told(session, "the next room begins with it")
    operators.refuses = ""
    session.reopen("browser 1")
    until(lambda: session.status is not None)
    assert (session.state.phase, session.state.trouble, session.status.arm) == (
        "open",
        "",
        "emergency",
    )


def test_a_driver_that_cannot_be_made_does_not_end_the_room(enter, capsys):
    def broken(lab, tell):
        if lab.rule == "squashing":
            raise ZeroDivisionError("by zero")
        return driver(lab, tell)

    session = enter(ready=False, driver=broken)
    until(lambda: session.state.phase == "failed")
    assert session.state.trouble == "by zero"
    assert "ZeroDivisionError" in capsys.readouterr().err
    session.choose(rule=session.chosen.rules[1])
    until(lambda: session.status is not None)


def test_a_loop_that_dies_is_told_and_leaves_nobody_believing_in_it(enter, operators):
    session = enter()
    armed(session)
    operators.last.trouble = "the control loop is gone: the cars stop themselves"
    until(lambda: session.state.phase == "failed")
    assert session.status is None
    assert session.state.trouble == operators.last.trouble
    assert (set(session.frame.live.states), session.frame.live.arm) == ({"lost"}, "safe")
    told(session, "the control loop is gone")
    session.reopen("browser 1")
    until(lambda: session.status is not None)
    assert (session.status.arm, session.state.run) == ("safe", 2)


def test_a_process_that_ends_without_a_word_is_found_out(enter, operators):
    session = enter()
    operators.last.alive = False
    until(lambda: session.state.phase == "failed")
    assert session.state.trouble == "the control loop has ended: the cars stop themselves"


def test_a_loop_that_falls_silent_is_said_to(enter, operators):
    session = enter()
    operators.last.mute = True
    until(
        lambda: (
            session.state.trouble == "the control loop does not answer: the page shows old values"
        )
    )
    told(session, "the control loop does not answer")
    operators.last.mute = False
    until(lambda: session.state.trouble == "")
    assert session.state.phase == "open"


def test_what_goes_wrong_in_a_look_is_told_once_and_the_stop_still_works(enter, operators, capsys):
    session = enter()
    whole = operators.last.status
    operators.last.status = lambda: replace(whole(), cars=(None,))
    told(session, "AttributeError")
    session.emergency("browser 1")
    assert operators.last.actions() == ["emergency"]
    time.sleep(0.2)
    assert capsys.readouterr().err.count("Traceback") == 1
    operators.last.status = whole
    until(lambda: session.status.arm == "emergency" and session.state.trouble == "")


def test_from_a_room_that_cannot_be_looked_at_there_is_a_way_on(enter, operators):
    session = enter()
    operators.last.status = lambda: 1 / 0
    until(lambda: session.state.trouble == "division by zero")
    session.choose(source=EMULATED)
    until(lambda: session.state.run == 2 and session.status is not None)
    assert session.state.trouble == ""


def test_a_desk_that_is_slow_to_close_holds_no_stop_up(enter, operators):
    session = enter()
    waits, closed = threading.Event(), threading.Event()
    operators.last.close = lambda: (waits.wait(60), closed.set())
    session.reopen("browser 1")
    until(lambda: session.opening is None)
    session.emergency("browser 2")
    session.place(0.0, 0.0)
    assert not closed.is_set(), "it waited until the other room was closed"
    operators.made.pop()
    waits.set()
    until(lambda: session.status is not None and session.status.arm == "emergency")
    assert [request.cause for request in operators.last.asked] == ["browser 2"]


def test_each_opening_is_recorded_in_a_folder_of_its_own(enter, operators, tmp_path):
    session = enter(recording=tmp_path)
    first = operators.last.recording
    first.mkdir()
    assert (first.parent, session.state.recording) == (tmp_path, str(first))
    session.reopen("browser 1")
    until(lambda: session.state.run == 2 and session.state.phase == "open")
    assert operators.last.recording.parent == tmp_path
    assert operators.last.recording != first


def test_closing_stops_the_cars_and_may_be_done_twice(enter, operators):
    session = enter()
    armed(session)
    session.close()
    session.close()
    assert (operators.last.closed, session.state.phase) == (1, "closed")
    session.ask("arm", "browser 1")
    told(session, "the room is not open (closed)")
    session.reopen("browser 1")
    told(session, "the room is closed")
    session.emergency("browser 1")
    assert len(operators.made) == 1


def test_closed_while_it_opens_it_lets_go_of_what_comes(enter, operators, monkeypatch):
    monkeypatch.setattr("app.viewer.live.session.FAREWELL", 0.05)
    operators.gate.clear()
    session = enter(ready=False)
    until(lambda: operators.begun)
    session.close()
    assert not operators.made, "it waited until the room was open"
    assert session.state.phase == "closed"
    operators.gate.set()
    until(lambda: operators.made and operators.last.closed)
    assert session.state.phase == "closed"
    assert operators.last.asked == []
