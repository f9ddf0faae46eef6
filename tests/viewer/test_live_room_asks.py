"""What may be asked of a room while it is open: parameters, simulated cars, the hand, holding."""

from __future__ import annotations

import time

import pytest

from app.viewer.live import tuning
from app.viewer.live.opened import GONE
from tests.viewer.live_rooms import armed, told
from tests.viewer.waiting import until
from worlds.refusal import Refusal


def test_a_parameter_takes_the_value_that_the_loop_took(enter, desks):
    room = enter()
    assert room.tune("beta", 2.5, "browser 1").result(5) == 2.5
    assert room.state.values["beta"] == 2.5
    assert desks.last.tuned() == [{"beta": 2.5}]
    desks.last.happens("tune", "C = 0.3", "terminal", "tune", '{"C": 0.3}')
    until(lambda: room.state.values["C"] == 0.3)


def test_what_the_loop_refuses_stays_as_it_was(enter, desks):
    room = enter()
    desks.last.refuses = "beta is not to be touched"
    with pytest.raises(Refusal, match="beta is not to be touched"):
        room.tune("beta", 2.5, "browser 1").result(5)
    assert room.state.values["beta"] == 2.0
    assert told(room, "beta is not").count("beta is not to be touched") == 1


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
def test_a_value_that_is_not_allowed_does_not_reach_the_loop(enter, desks, name, value, words):
    room = enter()
    with pytest.raises(Refusal, match=words):
        room.tune(name, value, "browser 1").result(0)
    told(room, words)
    assert desks.last.asked == []


def test_a_change_without_an_answer_is_given_up(enter, desks, monkeypatch):
    monkeypatch.setattr(tuning, "PATIENCE", 0.1)
    room = enter()
    desks.last.mute = True
    with pytest.raises(Refusal, match=r"beta = 2.5 has no answer from the control loop"):
        room.tune("beta", 2.5, "browser 1").result(5)


def test_a_change_that_waits_when_the_room_closes_is_answered(enter, desks):
    room = enter()
    desks.last.mute = True
    answer = room.tune("beta", 2.5, "browser 1")
    room.close()
    with pytest.raises(Refusal, match="the room was closed"):
        answer.result(0)


def test_simulated_cars_are_whole_numbers_up_to_the_most(enter, desks):
    room = enter()
    for count in (0, 3, 8.0):
        room.accompany(count, "browser 1")
    assert [request.words for request in desks.last.asked] == ["0", "3", "8"]
    for count in (-1, 9, 1.5, float("inf"), None, "3", True, 10**400):
        room.accompany(count, "browser 1")
        told(room, "simulated cars")
    assert len(desks.last.asked) == 3


def test_the_hand_goes_only_where_numbers_go(enter, desks):
    room = enter()
    room.place(1, -0.5)
    for x, y in ((float("nan"), 0.0), (0.0, "1"), (None, None), (10**400, 0.0)):
        room.place(x, y)
    assert desks.last.placed == [(1.0, -0.5)]
    told(room, "y = '1' is not allowed")


def test_without_browsers_the_cars_stop_if_a_browser_has_armed_them(enter, desks):
    room = enter()
    armed(room, "browser 3")
    room.browsers(1)
    assert "hold" not in desks.last.wishes()
    for _ in range(3):
        room.browsers(0)
    until(lambda: room.look.arm == "safe")
    holds = [request for request in desks.last.asked if request.wish == "hold"]
    assert [request.cause for request in holds] == [GONE]
    armed(room, "browser 4")
    room.browsers(0)
    until(lambda: room.look.arm == "safe")


def test_without_browsers_the_cars_go_on_if_the_terminal_has_armed_them(enter, desks):
    room = enter()
    armed(room, "terminal")
    desks.last.happens("arm", "armed: nothing changed", "browser 1", "arm")
    time.sleep(0.1)
    room.browsers(0)
    time.sleep(0.1)
    assert room.look.arm == "armed"


def test_cars_that_are_not_seen_are_told_only_while_they_drive(enter, desks):
    room = enter()
    desks.last.happens("unseen", "red was never seen", car="red")
    armed(room)
    desks.last.happens("unseen", "blue was last seen 0.11 s ago", car="blue")
    notices = told(room, "blue is not seen: the cars stop")
    assert not any("red" in notice for notice in notices)
