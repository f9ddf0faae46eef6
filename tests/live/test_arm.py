"""Arming, disarming and the emergency stop."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.live.control.arm import Arm, OperatorRequest
from app.live.control.pose import MocapFrame
from app.live.links.link import EMERGENCY, RUN, STOP
from app.live.sources.axes import Axes
from live.rooms import Room, lab
from worlds.input_error import InputError

ARM = OperatorRequest("arm", "test")


def test_nothing_runs_before_it_is_armed():
    room = Room()
    assert room.ticks(1.0).verdict.mode == STOP
    assert room.step.verdict.commands == {"red": (0.0, 0.0), "blue": (0.0, 0.0)}
    assert room.step.wanted == {"red": (0.0, 1.0), "blue": (0.0, 1.0)}
    assert room.arm().verdict.mode == RUN
    assert room.step.verdict.commands["red"] == (0.0, 1.0)


def test_arming_is_refused_with_what_is_wrong():
    room = Room(hidden={"red"})
    room.arm()
    assert room.step.verdict.mode == STOP
    assert room.events[-1].kind == "refused"
    assert room.events[-1].words == "cannot be armed: red was never seen"


def test_what_lies_is_not_armed_and_the_refusal_says_so():
    room = Room()
    axes = Axes()
    lying = axes.sighting("red", (0.0, 0.0, 0.05), (1.0, 0.0, 0.0, 0.0))  # yaw 0, w first
    blue = axes.sighting("blue body", (1.0, 0.0, 0.05), (0.0, 0.0, 0.0, 1.0))
    room.control.begin_tick(1.0, (), (MocapFrame(1, 1.0, (lying, blue)),))
    room.control.end_tick(1.0, None)
    room.control.begin_tick(1.01, (ARM,), (MocapFrame(2, 1.01, (lying, blue)),))
    events = room.control.end_tick(1.01, None).events
    assert [event.words for event in events if event.kind == "refused"] == [
        "cannot be armed: red was never seen: its axis z, which should point up, is rolled 180 "
        "degrees about its nose"
    ]


def test_cars_that_jump_are_armed_only_after_two_quiet_seconds():
    room = Room()
    room.ticks(0.1)
    room.at["red"], room.at["blue"] = room.at["blue"], room.at["red"]
    assert room.arm().verdict.mode == STOP
    assert room.events[-1].words == (
        "cannot be armed: red jumped 0.70 m 0.0 s ago, as no car can; "
        "blue jumped 0.70 m 0.0 s ago, as no car can"
    )
    room.ticks(1.9)
    assert room.tick(ARM).verdict.mode == STOP
    room.ticks(0.1)
    assert room.tick(ARM).verdict.mode == RUN


def test_a_car_that_is_carried_to_its_place_does_not_jump():
    room = Room()
    room.ticks(0.1)
    for _ in range(50):
        room.at["red"][1] += 0.03  # 3 m/s
        room.tick()
    assert room.tick(ARM).verdict.mode == RUN


def test_the_emergency_stop_latches_and_is_armed_again_by_hand():
    room = Room()
    room.arm()
    room.ticks(0.2)
    assert room.tick(OperatorRequest("emergency", "browser 2")).verdict.mode == EMERGENCY
    assert room.ticks(5.0).verdict.mode == EMERGENCY
    room.tick(ARM)
    assert room.events[-1].words == (
        "cannot be armed: the emergency stop is latched, reset it first"
    )
    assert room.step.verdict.mode == EMERGENCY
    assert room.tick(OperatorRequest("disarm", "test")).verdict.mode == EMERGENCY
    assert room.tick(OperatorRequest("reset", "test")).verdict.mode == STOP
    assert room.tick(ARM).verdict.mode == RUN
    causes = [event.cause for event in room.events if event.kind == "emergency"]
    assert causes == ["browser 2"]


def test_the_emergency_stop_works_unarmed_and_without_tracking():
    safety = lab().safety()
    safety.ask(0.0, OperatorRequest("emergency", "test"))
    safety.take_frames(0.0, ())
    assert safety.judge(0.0, {}).mode == EMERGENCY


@pytest.mark.parametrize("action", ["disarm", "hold"])
def test_disarming_stops_at_once(action):
    room = Room()
    room.arm()
    assert room.tick(OperatorRequest(action, "test")).verdict.mode == STOP
    assert room.ticks(1.0).verdict.mode == STOP


STATES = {
    ("safe", "arm"): "armed",
    ("armed", "disarm"): "safe",
    ("armed", "hold"): "safe",
    ("safe", "emergency"): "emergency",
    ("armed", "emergency"): "emergency",
    ("emergency", "reset"): "safe",
}


@given(st.lists(st.sampled_from(["arm", "disarm", "hold", "emergency", "reset", "tune"])))
def test_the_arming_is_its_table(actions):
    arm = Arm()
    for action in actions:
        before = arm.state
        if (before, action) == ("emergency", "arm"):
            with pytest.raises(InputError):
                arm.carry_out(OperatorRequest(action, "test"))
        else:
            changed = arm.carry_out(OperatorRequest(action, "test"))
            assert changed == (arm.state != before)
        assert arm.state == STATES.get((before, action), before)


def test_a_request_that_there_is_none_of_is_refused():
    with pytest.raises(InputError, match="unknown request 'armed': did you mean 'arm'"):
        OperatorRequest("armed", "test")
