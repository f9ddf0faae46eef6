"""Cars that move though they are told to stand, and cars that go against their nose."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from app.live.control.arm import OperatorRequest
from app.live.control.pose import seen
from app.live.control.travel import STRAY
from app.live.links.link import EMERGENCY, RUN, STOP
from live.rooms import LAB, TICK, Room, Steady
from worlds.input_error import InputError

REAL = LAB.replace('link = "dry"', 'link = "udp:127.0.0.1:5005"')
"""A room whose link reaches the cars."""
EMERGENCY_STOP = OperatorRequest("emergency", "test")
DISARM = OperatorRequest("disarm", "test")


class Haunted(Room):
    """A room in which somebody else sends to the cars of `driven`, and they obey."""

    def __post_init__(self):
        super().__post_init__()
        self.driven = {}
        """Speed (m/s) by car."""

    def move(self):
        super().move()
        for name, speed in self.driven.items():
            self.at[name][0] += speed * TICK


def standing(room, how):
    """Bring the room to stand in one of its modes, for a while."""
    if how != "safe":
        room.arm()
        room.ticks(0.5)
    if how == "disarmed":
        room.tick(DISARM)
    elif how == "emergency":
        room.tick(EMERGENCY_STOP)
    elif how == "armed, standing":
        room.driver.command = (0.0, 0.0)
    elif how == "armed, one unseen":
        room.hidden = {"blue"}
        room.control.safety.limits = room.lab.limits.model_copy(update={"long_gap": 10.0})
    room.ticks(1.5)
    assert "moves" not in room.kinds()


@pytest.mark.parametrize(
    "how", ["safe", "disarmed", "emergency", "armed, standing", "armed, one unseen"]
)
@pytest.mark.parametrize("speed", [0.05, 0.3, 1.0])
def test_a_car_that_moves_though_told_to_stand_is_an_event_in_every_mode(how, speed):
    room = Haunted(text=REAL)
    standing(room, how)
    state = room.control.safety.arm.state
    begun = room.at["red"][0]
    room.driven = {"red": speed}
    while "moves" not in room.kinds():
        room.tick()
        assert room.at["red"][0] - begun < STRAY + 0.04, "it is not noticed"
    (reason,) = [one for one in room.step.verdict.reasons if one.kind == "moves"]
    assert reason.car == "red"
    assert "red moves though it is told to stand" in reason.words
    assert room.step.verdict.mode == (EMERGENCY if how == "emergency" else STOP)
    assert room.control.safety.arm.state == ("emergency" if state == "emergency" else "safe")
    room.driven = {}
    room.ticks(1.5)
    assert room.kinds().count("moves") == 1
    assert "cleared" in room.kinds()
    assert not any(one.kind == "moves" for one in room.step.verdict.reasons)


def test_it_cannot_be_armed_while_a_car_moves():
    room = Haunted(text=REAL)
    room.ticks(1.5)
    room.driven = {"blue": 0.2}
    room.ticks(0.5)
    with pytest.raises(InputError, match="blue moves though it is told to stand"):
        room.control.safety.ask(room.now, OperatorRequest("arm", "test"))


@pytest.mark.parametrize("speed", [0.3, 1.0])
@pytest.mark.parametrize("request_", [DISARM, EMERGENCY_STOP])
def test_a_car_that_obeys_rolls_out_without_an_event_and_one_that_does_not_is_noticed(
    speed, request_
):
    obeys = Haunted(text=REAL, driver=Steady((0.0, speed)))
    obeys.arm()
    obeys.ticks(1.0)
    obeys.tick(request_)
    obeys.ticks(3.0)
    assert "moves" not in obeys.kinds()
    deaf = Haunted(text=REAL, driver=Steady((0.0, speed)))
    deaf.arm()
    deaf.ticks(1.0)
    deaf.tick(request_)
    begun = deaf.at["red"][0]
    deaf.cut_at = math.inf  # it goes on with what it heard last, and no watchdog stops it
    deaf.told = replace(deaf.step.verdict, mode=RUN, commands=dict.fromkeys(deaf.at, (0.0, speed)))
    while "moves" not in deaf.kinds():
        deaf.tick()
        assert deaf.at["red"][0] - begun < 0.6
    assert deaf.at["red"][0] - begun < 0.75 * speed + STRAY + 0.03


def test_cars_whose_link_is_cut_and_that_their_watchdogs_stop_are_no_such_event():
    room = Room(text=REAL)
    room.arm()
    room.ticks(1.0)
    room.cut_at = room.now
    room.ticks(3.0)
    assert "moves" not in room.kinds()


def test_with_a_dry_link_nobody_is_told_to_stand():
    room = Haunted(text=LAB)
    room.driven = {"red": 0.5}
    room.ticks(1.0)
    assert "moves" not in room.kinds()


def test_a_car_that_was_unseen_for_long_may_have_been_carried():
    room = Room(text=REAL)
    room.ticks(1.5)
    room.hidden = {"red"}
    room.ticks(1.5)
    room.at["red"][0] += 1.0
    room.hidden = set()
    room.ticks(0.5)
    assert "moves" not in room.kinds()


class Turned(Room):
    """A room whose tracking has the yaw of `turned` by so many radians."""

    def __post_init__(self):
        super().__post_init__()
        self.turned = {}

    def frame(self):
        frame = super().frame()
        name = {"blue body": "blue"}
        return replace(
            frame,
            sightings=tuple(
                seen(
                    one.name,
                    replace(one.pose, yaw=self.turned.get(name.get(one.name, one.name), 0.0)),
                )
                for one in frame.sightings
            ),
        )


@pytest.mark.parametrize("speed", [0.2, 0.5, 1.0])
@pytest.mark.parametrize("turned", [math.pi, -2.5, 1.6])
def test_a_yaw_that_flips_stops_the_cars(speed, turned):
    room = Turned(driver=Steady((0.0, speed)))
    room.arm()
    room.ticks(1.0)
    room.turned = {"red": turned}
    assert room.until(STOP, 0.2) == pytest.approx(0.1, abs=2 * TICK)
    assert room.control.safety.arm.state == "safe"
    assert ("leap", "red") in {(one.kind, one.car) for one in room.step.verdict.reasons}
    assert "is seen turned by" in " ".join(one.words for one in room.step.verdict.reasons)


def test_a_yaw_that_slips_for_a_frame_passes():
    room = Turned()
    room.arm()
    room.ticks(0.5)
    room.turned = {"red": math.pi}
    room.tick()
    room.turned = {}
    assert room.ticks(1.0).verdict.mode == RUN


@pytest.mark.parametrize("speed", [0.15, 0.5, 1.0])
@pytest.mark.parametrize("turned", [math.pi, 2.4])
def test_a_body_that_is_the_wrong_way_round_is_found_as_soon_as_it_drives(speed, turned):
    room = Turned(driver=Steady((0.0, speed)))
    room.turned = {"blue": turned}
    room.arm()
    begun = room.at["blue"][0]
    room.until(STOP, 2.0)
    assert [(one.kind, one.car) for one in room.step.verdict.reasons] == [("yaw", "blue")]
    assert "yaw" in room.kinds()
    assert "hold" in room.kinds()
    room.ticks(1.5)
    assert room.at["blue"][0] - begun < LONGEST[speed]


LONGEST = {0.15: 0.12, 0.5: 0.2, 1.0: 0.4}
"""Metres that it comes meanwhile, from standing."""


def test_a_car_that_reverses_as_told_goes_not_against_its_nose():
    text = LAB.replace("address", "reverse = 1.0\naddress")
    room = Turned(driver=Steady((0.0, -0.6)), text=text)
    for at in room.at.values():
        at[0] = 2.0
    room.arm()
    assert room.ticks(3.0).verdict.mode == RUN
    room.turned = dict.fromkeys(room.at, math.pi)
    room.tick(DISARM)
    room.ticks(0.5)
    room.tick(OperatorRequest("arm", "test"))
    room.until(STOP, 1.0)
    assert {one.kind for one in room.step.verdict.reasons} == {"yaw"}


def test_going_forth_and_back_is_not_going_against_the_nose():
    text = LAB.replace("address", "reverse = 1.0\naddress")
    room = Turned(driver=Steady((0.0, 0.8)), text=text)
    room.arm()
    for k in range(12):
        room.driver.command = (0.0, -0.8 if k % 2 else 0.8)
        assert room.ticks(0.5).verdict.mode == RUN, room.step.verdict.reasons
