"""What counts as fresh: a pose that comes again does not, for a car that was told to drive."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

import pytest

from app.live.control.arm import OperatorRequest
from app.live.control.pose import MocapFrame, Pose, seen
from app.live.control.pose_tracker import REMEMBERED
from app.live.links.link import RUN, STOP
from live.rooms import LAB, TICK, Room, Steady

SLOW = LAB.replace("address", "speed = 0.16\naddress")
"""Cars of 0.16 m/s, which come less than 5 cm in 0.35 s."""


class Replayed(Room):
    """A room whose tracking dies; `again(frame)` makes what comes instead of the newest frame.

    The frames that come are numbered on and have just arrived, as the library's are.
    """

    again = None

    def __post_init__(self):
        super().__post_init__()
        self.kept = deque(maxlen=400)

    def frame(self):
        if self.again is None:
            self.kept.append(super().frame())
            return self.kept[-1]
        self.number += 1
        return self.again(self.number)

    def handed_out(self, number, old):
        """An old frame as if it had just come."""
        return replace(old, number=number, received=self.now - 0.005)


def the_last(room):
    """An empty datagram: the library hands out its last buffer, and so does a replay of it."""
    return lambda number: room.handed_out(number, room.kept[-1])


def the_one_before(room):
    """A datagram of the last moment is sent again and again."""
    return lambda number: room.handed_out(number, room.kept[-6])


def the_last_moments(room):
    """The datagrams of the last 0.2 s are sent over and over."""
    kept = list(room.kept)[-20:]
    return lambda number: room.handed_out(number, kept[number % 20])


@pytest.mark.parametrize("text", [LAB, SLOW], ids=["fast", "slow"])
@pytest.mark.parametrize("stranger", [the_last, the_one_before, the_last_moments])
def test_old_poses_that_come_again_stop_the_cars_as_soon_as_none_would(text, stranger):
    quiet = Replayed(text=text)
    quiet.arm()
    quiet.ticks(1.5)
    quiet.hidden = set(quiet.lab.cars)
    room = Replayed(text=text)
    room.arm()
    room.ticks(1.5)
    room.again = stranger(room)
    assert room.until(STOP, 0.2) == pytest.approx(quiet.until(STOP, 0.2), abs=1.5 * TICK)
    assert "old poses of it come again" in room.step.verdict.reasons[0].words
    kinds = len(room.kinds())
    room.ticks(1.2)
    assert RUN not in room.kinds()[kinds:]
    assert "run" not in room.kinds()[kinds:]
    assert room.control.safety.arm.state == "safe"  # after a second they wait to be armed again
    assert max(abs(at[2]) for at in room.at.values()) < 1e-3


def test_once_old_poses_came_again_a_person_arms_whatever_comes_next():
    room = Replayed()
    room.arm()
    room.ticks(0.5)
    room.again = the_last(room)
    room.until(STOP, 0.2)
    room.again = None
    assert room.ticks(1.0).verdict.mode == STOP
    assert room.control.safety.arm.state == "safe"
    assert room.tick(OperatorRequest("arm", "test")).verdict.mode == RUN


def test_poses_that_no_tick_has_steered_by_are_known_again():
    """A tick that comes late passes over frames, which a stranger on the network has heard."""
    room = Replayed()
    room.arm()
    room.ticks(0.5)
    passed = room.frame()
    room.move()
    room.now += TICK
    newest = room.frame()
    room.control.begin_tick(room.now, (), (passed, newest))
    assert room.control.end_tick(room.now, None).verdict.mode == RUN
    room.again = lambda number: room.handed_out(number, passed)
    room.until(STOP, 0.2)
    assert "old poses of it come again" in room.step.verdict.reasons[0].words


def test_a_software_source_that_is_faster_than_its_cars_may_tell_a_pose_twice_in_a_tick():
    room = Room(noise=0.0)
    room.arm()
    for _ in range(100):
        room.now += TICK
        room.control.begin_tick(room.now, (), (room.frame(), room.frame()))
        room.step = room.control.end_tick(room.now, None)
        assert room.step.verdict.mode == RUN
        room.move()


def test_armed_again_on_a_dead_stream_no_car_gets_far():
    room = Replayed()
    room.arm()
    room.ticks(0.5)
    room.again = the_last(room)
    room.ticks(2.5)
    before = room.at["red"][0]
    assert room.tick(OperatorRequest("arm", "test")).verdict.mode == RUN  # it may only stand there
    room.until(STOP, 0.15)
    room.ticks(2.0)
    assert room.at["red"][0] - before < 0.11
    assert room.control.safety.arm.state == "safe"


def test_a_car_that_is_told_to_stand_may_be_seen_where_it_was_to_the_bit():
    room = Room(driver=Steady((0.5, 0.0)), noise=0.0)
    room.arm()
    assert room.ticks(3.0).verdict.mode == RUN
    room.driver.command = (0.0, 1.0)  # and then it drives off, without noise
    assert room.ticks(1.0).verdict.mode == RUN
    room.driver.command = (0.0, 0.0)
    assert room.ticks(2.0).verdict.mode == RUN


def test_cars_without_noise_drive_in_a_room_that_is_looked_at_by_hand():
    room = Room(noise=0.0)
    room.arm()
    assert room.ticks(1.5).verdict.mode == RUN


class Told(Replayed):
    """As a source that tells a time of its own."""

    def frame(self):
        frame = super().frame()
        return frame if frame.sent is not None else replace(frame, sent=frame.number * TICK)


@pytest.mark.parametrize("older", [0, 1, 20])
def test_a_frame_with_a_repeated_or_an_older_time_of_the_source_does_not_count(older):
    room = Told()
    room.arm()
    room.ticks(1.0)
    stood = room.kept[-1].number * TICK

    def forged(number):
        """Poses that are new, under an old time."""
        room.again, again = None, room.again
        frame = replace(Room.frame(room), number=number, sent=stood - older * TICK)
        room.again = again
        return frame

    room.again = forged
    room.until(STOP, 0.15)
    room.ticks(1.2)
    assert room.control.safety.arm.state == "safe"


@pytest.mark.parametrize("older", [0, 1, 20])
def test_a_frame_with_a_repeated_or_an_older_number_does_not_count(older):
    room = Replayed()
    room.arm()
    room.ticks(1.0)
    number = room.number - older

    def forged(_number):
        return replace(Room.frame(room), number=number)

    room.again = forged
    room.until(STOP, 0.15)


def test_a_source_that_was_opened_again_counts_from_nought_while_unarmed():
    room = Room()
    safety = room.control.safety
    before = MocapFrame(500, 1.0, (seen("red", Pose(0.0, 0.0, 0.0)),), 9.0)
    safety.take_frames(1.0, (before,))
    safety.take_frames(2.0, (MocapFrame(0, 2.0, (seen("red", Pose(0.0, 0.1, 0.0)),), 0.0),))
    assert safety.seen.age("red", 2.0) == 0.0


def test_no_more_poses_are_kept_than_can_be_known_again():
    room = Room()
    known = room.control.safety.seen
    for number in range(REMEMBERED + 100):
        known.remember(MocapFrame(number, 0.0, (seen("red", Pose(0.001 * number, 0.0, 0.0)),)))
    assert len(known.past["red"]) == REMEMBERED
    assert Pose(0.001 * 99, 0.0, 0.0) not in known.past["red"]
    assert Pose(0.001 * 100, 0.0, 0.0) in known.past["red"]


@pytest.mark.parametrize("speed", [0.16, 0.08, 0.04])
def test_a_frozen_stream_with_noise_is_found_for_slow_cars_too(speed):
    room = Room(text=LAB.replace("address", f"speed = {speed}\naddress"))
    room.arm()
    room.ticks(2.0)
    begun = room.at["red"][0]
    room.frozen = True
    room.until(STOP, 3.5)
    assert [reason.kind for reason in room.step.verdict.reasons] == ["frozen"]
    assert room.control.safety.arm.state == "safe"
    room.ticks(2.0)
    assert room.at["red"][0] - begun < 0.075


@pytest.mark.parametrize("speed", [0.16, 0.04])
def test_slow_cars_that_go_half_as_fast_as_declared_are_not_taken_for_frozen(speed):
    room = Room()
    room.control.safety.travels.update(
        Room(text=LAB.replace("address", f"speed = {2.0 * speed}\naddress")).control.safety.travels
    )
    for at in room.lab.cars.values():
        object.__setattr__(at, "speed", speed)
    room.arm()
    assert room.ticks(6.0).verdict.mode == RUN
    assert math.isclose(room.at["red"][2], speed, rel_tol=0.01)
