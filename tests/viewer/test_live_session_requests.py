"""What may be asked of a room while it is open: parameters, simulated cars, the hand, holding."""

from __future__ import annotations

import time

import pytest

from app.viewer.live import loop_connection
from app.viewer.live.loop_connection import GONE
from tests.viewer.live_sessions import armed, told
from tests.viewer.waiting import until
from worlds.input_error import InputError


def test_a_parameter_takes_the_value_that_the_loop_took(enter, operators):
    session = enter()
    assert session.set_parameter("beta", 2.5, "browser 1").result(60) == 2.5
    assert session.state.values["beta"] == 2.5
    assert operators.last.tuned() == [{"beta": 2.5}]
    operators.last.happens("tune", "C = 0.3", "terminal", "tune", '{"C": 0.3}')
    until(lambda: session.state.values["C"] == 0.3)


def test_what_the_loop_refuses_stays_as_it_was(enter, operators):
    session = enter()
    operators.last.refuses = "beta is not to be touched"
    with pytest.raises(InputError, match="beta is not to be touched"):
        session.set_parameter("beta", 2.5, "browser 1").result(60)
    assert session.state.values["beta"] == 2.0
    assert told(session, "beta is not").count("beta is not to be touched") == 1


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("beta", 1e9, "is outside"),
        ("beta", float("nan"), "must be finite"),
        ("beta", 10**400, "must be finite"),
        ("beta", "2", "must be a number"),
        ("beta", True, "must be a number"),
        ("beta", None, "must be a number"),
        ("bta", 1.0, "did you mean 'beta'"),
        ("dt", 0.01, "unknown parameter 'dt'"),
        ("loss", 0.5, "unknown parameter 'loss'"),
        (None, 1.0, "unknown parameter None"),
        (["beta"], 1.0, "unknown parameter"),
    ],
)
def test_a_value_that_is_not_allowed_does_not_reach_the_loop(enter, operators, name, value, words):
    session = enter()
    with pytest.raises(InputError, match=words):
        session.set_parameter(name, value, "browser 1").result(0)
    told(session, words)
    assert operators.last.asked == []


def test_a_change_without_an_answer_is_given_up(enter, operators, monkeypatch):
    monkeypatch.setattr(loop_connection, "TIMEOUT", 0.1)
    session = enter()
    operators.last.mute = True
    with pytest.raises(InputError, match=r"beta = 2.5 has no answer from the control loop"):
        session.set_parameter("beta", 2.5, "browser 1").result(60)


def test_a_change_that_waits_when_the_room_closes_is_answered(enter, operators):
    session = enter()
    operators.last.mute = True
    answer = session.set_parameter("beta", 2.5, "browser 1")
    session.close()
    with pytest.raises(InputError, match="the room was closed"):
        answer.result(0)


def test_simulated_cars_are_whole_numbers_up_to_the_most(enter, operators):
    session = enter()
    for count in (0, 3, 8.0):
        session.set_companions(count, "browser 1")
    assert [request.words for request in operators.last.asked] == ["0", "3", "8"]
    for count in (-1, 9, 1.5, float("inf"), None, "3", True, 10**400):
        session.set_companions(count, "browser 1")
        told(session, "simulated cars")
    assert len(operators.last.asked) == 3


def test_the_hand_goes_only_where_numbers_go(enter, operators):
    session = enter()
    session.place(1, -0.5)
    for x, y in ((float("nan"), 0.0), (0.0, "1"), (None, None), (10**400, 0.0)):
        session.place(x, y)
    assert operators.last.placed == [(1.0, -0.5)]
    told(session, "y = '1' is not allowed")


def test_without_browsers_the_cars_stop_if_a_browser_has_armed_them(enter, operators):
    session = enter()
    armed(session, "browser 3")
    session.browsers(1)
    assert "hold" not in operators.last.actions()
    for _ in range(3):
        session.browsers(0)
    until(lambda: session.status.arm == "safe")
    holds = [request for request in operators.last.asked if request.action == "hold"]
    assert [request.cause for request in holds] == [GONE]
    armed(session, "browser 4")
    session.browsers(0)
    until(lambda: session.status.arm == "safe")


def test_without_browsers_the_cars_go_on_if_the_terminal_has_armed_them(enter, operators):
    session = enter()
    armed(session, "terminal")
    operators.last.happens("arm", "armed: nothing changed", "browser 1", "arm")
    time.sleep(0.1)
    session.browsers(0)
    time.sleep(0.1)
    assert session.status.arm == "armed"


def test_cars_that_are_not_seen_are_told_only_while_they_drive(enter, operators):
    session = enter()
    operators.last.happens("unseen", "red was never seen", car="red")
    armed(session)
    operators.last.happens("unseen", "blue was last seen 0.11 s ago", car="blue")
    notices = told(session, "blue is not seen: the cars stop")
    assert not any("red" in notice for notice in notices)
