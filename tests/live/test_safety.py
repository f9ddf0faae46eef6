"""Every rule of the safety at its threshold, and what holds whatever happens."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.live.control.arm import OperatorRequest
from app.live.control.pose import MocapFrame, Pose, Sighting, seen
from app.live.control.safety import Safety, limit_command
from app.live.control.safety_limits import CarLimits, SafetyLimits
from app.live.control.travel import DELAY, LEAST
from app.live.links.link import EMERGENCY, RUN, STOP
from live.rooms import TICK, Room, Steady, lab
from worlds.input_error import InputError

ARM = OperatorRequest("arm", "test")


def one_car(**limits) -> Safety:
    """The safety of one car that cannot go far, tracked under its own name."""
    return Safety(SafetyLimits(**limits), lab().area, {"red": CarLimits()})


def frame(number: int, received: float, x: float = 0.0, y: float = 0.0) -> MocapFrame:
    return MocapFrame(number, received, (seen("red", Pose(x, y, 0.0)),))


def run(safety: Safety, now: float) -> None:
    """Bring one car to run at `now`, where its newest frame was received."""
    safety.take_frames(now, (frame(0, now),))
    safety.ask(now, ARM)
    assert safety.judge(now, {"red": (0.0, 0.0)}).mode == RUN


def test_a_car_unseen_for_just_stale_still_runs_and_longer_stops_all():
    safety = one_car()
    run(safety, 0.0)
    stale = safety.limits.stale
    safety.take_frames(stale, ())
    assert safety.judge(stale, {}).mode == RUN
    later = math.nextafter(stale, 1.0)
    safety.take_frames(later, ())
    verdict = safety.judge(later, {"red": (0.0, 1.0)})
    assert verdict.mode == STOP
    assert verdict.commands == {"red": (0.0, 0.0)}
    assert [(reason.kind, reason.car) for reason in verdict.reasons] == [("unseen", "red")]


def test_a_short_gap_passes_by_itself():
    room = Room()
    room.arm()
    room.ticks(0.2)
    room.hidden = {"blue"}
    assert room.until(STOP, 0.2) == pytest.approx(0.1, abs=TICK)
    assert room.step.verdict.reasons[0].words.startswith("blue was last seen 0.1")
    room.hidden = set()
    assert room.until(RUN, 0.02) == pytest.approx(TICK)
    assert room.control.safety.arm.state == "armed"
    assert room.kinds() == ["arm", "run", "unseen", "stop", "cleared", "run"]


def test_a_long_gap_waits_to_be_armed_again():
    safety = one_car()
    run(safety, 0.0)
    longest = safety.limits.long_gap
    for now in (0.5, longest):
        assert not safety.judge(now, {}).held
    verdict = safety.judge(math.nextafter(longest, 2.0), {})
    assert verdict.held
    safety.take_frames(1.5, (frame(1, 1.5),))
    assert safety.judge(1.5, {}).mode == STOP
    run(safety, 2.0)


def test_a_loop_that_stood_still_waits_to_be_armed_again():
    safety = one_car()
    run(safety, 0.0)
    safety.take_frames(2.0, (frame(1, 2.0),))
    verdict = safety.judge(2.0, {})
    assert verdict.held
    assert [reason.words for reason in verdict.reasons] == ["the loop stood still for 2.00 s"]


def test_a_source_that_lives_in_the_future_is_not_believed_to_be_fresh():
    safety = one_car()
    safety.take_frames(0.0, (frame(0, 1e6),))
    assert safety.seen.age("red", 0.25) == 0.25


def test_a_repeated_frame_does_not_count():
    safety = one_car()
    same = frame(0, 0.0)
    for now in (0.0, 0.05, 0.1):
        safety.take_frames(now, (same,))
    assert safety.seen.age("red", 0.2) == 0.2


@pytest.mark.parametrize(
    "sighting",
    [
        Sighting("red", None, False),
        Sighting("red", Pose(0.0, 0.0, 0.0), False),
        Sighting("red", Pose(math.nan, 0.0, 0.0), True),
        Sighting("red", Pose(0.0, math.inf, 0.0), True),
        Sighting("red", Pose(0.0, 0.0, math.nan), True),
        Sighting("Red", Pose(0.0, 0.0, 0.0), True),
    ],
)
def test_what_is_no_sighting_does_not_count(sighting):
    safety = one_car()
    assert safety.take_frames(0.0, (MocapFrame(0, 0.0, (sighting,)),)) == ()
    assert math.isinf(safety.seen.age("red", 0.0))


def test_a_body_that_is_tracked_twice_is_not_seen():
    safety = one_car()
    twice = (seen("red", Pose(0.0, 0.0, 0.0)), seen("red", Pose(1.0, 0.0, 0.0)))
    assert safety.take_frames(0.0, (MocapFrame(0, 0.0, twice),)) == ()


@pytest.mark.parametrize(("x", "y"), [(2.5, 0.0), (-2.5, 0.0), (0.0, 2.5), (0.0, -2.5)])
def test_the_fence_stops_all_and_waits_to_be_armed_again(x, y):
    safety = one_car(leap=5.0)
    run(safety, 0.0)
    safety.take_frames(0.01, (frame(1, 0.01, 0.999 * x, 0.999 * y),))
    assert safety.judge(0.01, {}).mode == RUN
    safety.take_frames(0.02, (frame(2, 0.02, x, y),))
    verdict = safety.judge(0.02, {"red": (0.0, 1.0)})
    assert (verdict.mode, verdict.held) == (STOP, True)
    assert verdict.reasons[0].kind == "fence"
    with pytest.raises(InputError, match="red is at the fence"):
        safety.ask(0.02, ARM)


def test_a_car_at_full_speed_stops_between_fence_and_edge():
    room = Room()
    room.at["red"][0] = 0.0
    room.arm()
    room.until(STOP, 4.0)
    room.ticks(2.0)
    assert room.at["red"][2] < 0.001
    assert 2.5 < room.at["red"][0] < 2.5 + 0.17
    assert "fence" in room.kinds()


def test_a_leap_is_not_believed_and_a_slip_of_one_frame_passes():
    safety = one_car()
    run(safety, 0.0)
    safety.take_frames(0.01, (frame(1, 0.01, 0.0, 1.5),))
    assert safety.judge(0.01, {}).mode == RUN
    assert safety.seen.last["red"].pose.y == 0.0
    assert safety.take_frames(0.02, (frame(2, 0.02, 0.0, 0.0),))[0].pose.y == 0.0
    assert safety.seen.leaps == {}


def test_a_leap_that_stays_waits_to_be_armed_again():
    safety = one_car()
    run(safety, 0.0)
    for k in range(1, 12):
        safety.take_frames(0.01 * k, (frame(k, 0.01 * k, 0.0, 1.5),))
        verdict = safety.judge(0.01 * k, {})
        assert verdict.mode == (RUN if k <= 10 else STOP)
    assert {reason.kind for reason in verdict.reasons} == {"unseen", "leap"}
    assert verdict.held
    run(safety, 1.0)


def test_the_farthest_that_is_believed_is_leap_and_twice_the_speed():
    for far, believed in ((0.249, True), (0.25 + 0.0199, True), (0.25 + 0.0201, False)):
        safety = one_car()
        run(safety, 0.0)
        safety.take_frames(0.01, (frame(1, 0.01, 0.0, far),))
        assert (safety.seen.last["red"].pose.y == far) == believed


def test_unarmed_a_car_may_be_carried():
    safety = one_car()
    safety.take_frames(0.0, (frame(0, 0.0),))
    safety.take_frames(0.01, (frame(1, 0.01, 2.0, 2.0),))
    assert safety.seen.last["red"].pose == Pose(2.0, 2.0, 0.0)


class Broken:
    """Drives well, then not."""

    def __init__(self, answer):
        self.answer = answer
        self.good = True

    def drive(self, _now, sightings, _injected, _running):
        if self.good:
            return {sighting.name: (0.0, 1.0) for sighting in sightings}
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (ZeroDivisionError("division by zero"), "ZeroDivisionError: division by zero"),
        ({"red": (math.nan, 1.0)}, "steer = nan, throttle = 1.0 of red"),
        ({"red": (0.0, math.inf)}, "steer = 0.0, throttle = inf of red"),
        ({"red": None}, "TypeError"),
        ({"red": ("left", 1.0)}, "ValueError"),
        (None, "TypeError"),
    ],
)
def test_a_rule_that_fails_stops_the_cars(answer, says):
    room = Room(driver=Broken(answer))
    room.arm()
    assert room.ticks(0.2).verdict.mode == RUN
    room.driver.good = False
    room.tick()
    assert (room.step.verdict.mode, room.step.verdict.held) == (STOP, True)
    assert says in room.step.verdict.reasons[0].words
    assert all(throttle == 0.0 for _, throttle in room.step.verdict.commands.values())


def test_a_car_that_the_rule_forgets_gets_no_throttle():
    room = Room(driver=Broken({"red": (0.0, 1.0)}))
    room.arm()
    room.driver.good = False
    assert room.tick().verdict.commands == {"red": (0.0, 1.0), "blue": (0.0, 0.0)}


def test_steering_turns_no_faster_than_its_rate():
    room = Room(driver=Steady((1.0, 0.5)))
    room.arm()
    rate = room.lab.cars["red"].steering_rate
    assert room.step.verdict.commands["red"][0] == 0.0
    for k in range(1, 13):
        assert room.tick().verdict.commands["red"][0] == pytest.approx(rate * TICK * k)
    assert room.ticks(0.1).verdict.commands["red"][0] == 1.0


def test_wheels_stay_as_they_are_in_a_stop():
    room = Room(driver=Steady((0.6, 1.0)))
    room.arm()
    room.ticks(0.3)
    room.tick(OperatorRequest("disarm", "test"))
    assert room.step.verdict.commands["red"] == (0.6, 0.0)


def test_limits_of_a_car():
    car = CarLimits(steer=0.5, throttle=0.75, reverse=0.25, steering_rate=10.0)
    assert limit_command(car, (9.0, 9.0), 0.45, 0.01) == (0.5, 0.75)
    assert limit_command(car, (-9.0, -9.0), 0.45, 0.01) == (pytest.approx(0.35), -0.25)
    assert limit_command(CarLimits(), (0.0, -1.0), 0.0, 0.01) == (0.0, 0.0)


def test_the_way_to_stop_is_the_worst_fault_and_the_motor():
    assert CarLimits().runs_on(SafetyLimits()) == pytest.approx(1.0 * (0.35 + 0.15))
    assert CarLimits(throttle=0.5, lag=0.1).runs_on(SafetyLimits(frozen=0.2)) == pytest.approx(
        0.5 * (0.25 + 0.1)
    )


NUMBERS = st.floats(allow_nan=True, allow_infinity=True)
WILD = st.one_of(NUMBERS, st.floats(-2.0, 2.0))
MOMENT = st.tuples(
    st.floats(0.0, 0.3),  # time since the last tick
    st.lists(
        st.sampled_from(["arm", "arm", "arm", "disarm", "emergency", "reset", "hold"]), max_size=2
    ),
    st.one_of(st.none(), st.tuples(WILD, WILD, st.booleans())),
    st.one_of(st.none(), st.tuples(WILD, WILD)),
)


@settings(max_examples=200, deadline=None)
@given(st.lists(MOMENT, max_size=40), st.floats(0.1, 1.0), st.floats(0.0, 1.0))
def test_whatever_happens_nothing_exceeds_the_limits(moments, throttle, reverse):
    car = CarLimits(throttle=throttle, reverse=reverse, steer=0.8)
    safety = Safety(SafetyLimits(), lab().area, {"red": car})
    now, steered, number = 0.0, 0.0, 0
    emergency = False
    for step, actions, where, wanted in moments:
        now += step
        if where is not None:
            number += 1
            sighting = Sighting("red", Pose(*where[:2], 0.0), where[2])
            safety.take_frames(now, (MocapFrame(number, now, (sighting,)),))
        for action in actions:
            try:
                safety.ask(now, OperatorRequest(action, "test"))
            except InputError:
                assert action == "arm"
            emergency = action == "emergency" or (emergency and action != "reset")
        armed = safety.arm.state == "armed"
        verdict = safety.judge(now, {} if wanted is None else {"red": wanted})
        steer, drive = verdict.commands["red"]
        assert (verdict.mode == EMERGENCY) == emergency
        if verdict.mode == RUN:
            assert armed
            assert not verdict.reasons
            assert safety.seen.age("red", now) <= 0.1
            assert safety.area.distance_inside(*position(safety)) > 0.0
        else:
            assert drive == 0.0
        assert -reverse <= drive <= throttle
        assert abs(steer) <= 0.8
        assert abs(steer - steered) <= car.steering_rate * min(step, 0.05) + 1e-12
        steered = steer


def position(safety: Safety) -> tuple[float, float]:
    pose = safety.seen.last["red"].pose
    return pose.x, pose.y


def test_constants_are_those_of_the_reading():
    assert (SafetyLimits().stale, SafetyLimits().frozen, lab().area.fence) == (0.1, 0.35, 0.5)
    assert LEAST < 0.3 * (0.35 - DELAY)
