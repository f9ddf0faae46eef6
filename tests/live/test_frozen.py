"""Cars that do not go where they are told, and how far cars run on whatever fails."""

from __future__ import annotations

import math

import pytest

from app.live.control.arm import OperatorRequest
from app.live.control.safety_limits import CarLimits
from app.live.control.travel import DELAY, Travel
from app.live.links.link import RUN, STOP
from live.rooms import LAB, Room, Steady, lab

ARM = OperatorRequest("arm", "test")


def test_a_stream_that_freezes_at_full_speed_before_the_fence_leaves_room():
    room = Room()
    room.at["red"][0] = 0.0
    room.arm()
    while room.at["red"][0] < 2.48:
        room.tick()
    room.frozen = True
    room.until(STOP, 0.36)
    room.ticks(2.0)
    assert room.at["red"][0] < 3.0


FAULTS = {
    "the stream stops": lambda room: room.hidden.update(room.lab.cars),
    "one car is untracked": lambda room: room.hidden.add("blue"),
    "the stream freezes": lambda room: setattr(room, "frozen", True),
    "the link is cut": lambda room: setattr(room, "cut_at", room.now),
    "the rule fails": lambda room: setattr(room.driver, "command", (math.nan, 1.0)),
}
FURTHEST = {
    "the stream stops": 0.25,
    "one car is untracked": 0.25,
    "the stream freezes": 0.42,
    "the link is cut": 0.4,
    "the rule fails": 0.16,
}
"""Metres, as docs/live-safety.md has them."""


@pytest.mark.parametrize("fault", FAULTS)
def test_how_far_a_car_at_full_speed_runs_on(fault):
    room = Room(driver=Steady((0.0, 1.0)))
    room.arm()
    room.ticks(1.5)
    car = room.lab.cars["red"]
    assert room.at["red"][2] == pytest.approx(car.speed, rel=1e-3)
    begun = room.at["red"][0]
    FAULTS[fault](room)
    room.ticks(2.0)
    far = room.at["red"][0] - begun
    assert room.at["red"][2] < 1e-3
    assert far <= FURTHEST[fault]
    assert far == pytest.approx(FURTHEST[fault], abs=0.012)
    assert far <= car.runs_on(room.lab.limits)


@pytest.mark.parametrize("throttle", [0.3, 0.5, 1.0])
@pytest.mark.parametrize("driven", [0.0, 0.1, 0.2, 0.3, 0.5, 1.0])
def test_a_noisy_frozen_stream_is_found_in_time(throttle, driven):
    room = Room(driver=Steady((0.0, throttle)))
    room.arm()
    if driven:
        room.ticks(driven)
    room.frozen = True
    found = room.until(STOP, 0.5)
    assert found <= room.lab.limits.frozen + 1e-9
    assert "no car goes where it is told" in room.step.verdict.reasons[0].words
    assert room.control.safety.arm.state == "safe"


def test_a_stuck_car_is_named():
    room = Room()
    room.arm()
    room.ticks(0.5)
    room.stuck = {"blue"}
    room.until(STOP, 0.36)
    assert [(reason.kind, reason.car) for reason in room.step.verdict.reasons] == [
        ("frozen", "blue")
    ]


@pytest.mark.parametrize(("speed", "lag"), [(0.5, 0.15), (1.0, 0.3), (0.6, 0.25), (1.5, 0.05)])
def test_cars_that_are_not_quite_as_declared_are_not_taken_for_frozen(speed, lag):
    room = Room()
    room.lab = lab(
        LAB.replace("fence = 0.5", "fence = 1.0").replace("address", ROUGH % (speed, lag))
    )
    room.arm()
    assert room.ticks(2.0).verdict.mode == RUN


ROUGH = "speed = %g\nlag = %g\naddress"
"""Of real cars, in the place of their address."""


def test_cars_that_stand_on_purpose_or_crawl_are_not_judged():
    room = Room(driver=Steady((0.5, 0.0)))
    room.arm()
    assert room.ticks(3.0).verdict.mode == RUN
    room = Room(driver=Steady((0.0, 0.1)), stuck={"red", "blue"})
    room.arm()
    assert room.ticks(3.0).verdict.mode == RUN


def test_reversing_on_the_spot_is_driving():
    room = Room(text=LAB + "reverse = 1.0\n[cars.green]\naddress = 3\nreverse = 1.0\n")
    room.arm()
    for k in range(20):
        room.driver.command = (0.0, 1.0 if k % 2 else -1.0)
        assert room.ticks(0.1).verdict.mode == RUN


def test_the_expected_travel_is_the_answer_of_the_motor():
    car = CarLimits(speed=2.0, lag=0.5, rests=0.0)
    travel = Travel(car, 10.0)
    travel.forget(0.0)
    travel.drive(0.0, 0.5)
    for k in range(1, 301):
        travel.advance(0.01 * k)
    v, t = 1.0, 3.0
    assert travel.gone == pytest.approx(v * (t - 0.5 * (1.0 - math.exp(-t / 0.5))), rel=1e-12)
    assert travel.speed == pytest.approx(v * (1.0 - math.exp(-t / 0.5)), rel=1e-12)
    t -= DELAY
    assert travel.expected == pytest.approx(
        v * (t - 0.5 * (1.0 - math.exp(-t / 0.5))), abs=v * 0.011
    )


def test_arming_after_a_freeze_begins_anew():
    room = Room()
    room.arm()
    room.ticks(0.5)
    room.frozen = True
    room.until(STOP, 0.36)
    room.ticks(1.0)
    room.frozen = False
    room.tick()
    refused = [event for event in room.tick(ARM).events if event.kind == "refused"]
    assert "as no car can" in refused[0].words, "they are seen elsewhere at once"
    room.ticks(2.1)
    assert room.tick(ARM).verdict.mode == RUN
    assert room.ticks(1.0).verdict.mode == RUN


def test_on_the_box_a_car_whose_wheels_turn_in_the_air_is_not_taken_for_stuck():
    box = LAB.replace("address", "throttle = 0.5\nrests = 0.5\naddress")
    room = Room(text=box, stuck={"red", "blue"})
    room.arm()
    assert room.ticks(2.0).verdict.commands == {"red": (0.0, 0.5), "blue": (0.0, 0.5)}
    room = Room(text=box.replace("rests = 0.5", "rests = 0.1"), stuck={"red", "blue"})
    room.arm()
    assert 0.25 < room.until(STOP, 1.0) < 0.36
