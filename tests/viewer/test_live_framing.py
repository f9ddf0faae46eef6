"""Looks at a control loop as frames."""

from __future__ import annotations

import math
from datetime import datetime

import numpy as np
import pytest

from agents.catalogue import cars_for_rule
from app.live.control.pose import Pose
from app.live.laboratory.lab_file import example
from app.viewer.live.room_frame import Setting, frame_of, frame_without_loop
from app.viewer.live.session import new_folder
from tests.viewer.stub_operator import car_status, companion, status_at

LAB = example()
MODEL = cars_for_rule("squashing")
VALUES = MODEL.parameters().model_dump()
SETTING = Setting.of(3, LAB, MODEL)


def framed(status, past=(), setting=SETTING):
    return frame_of(setting, status, VALUES, past)


def test_a_frame_has_the_real_cars_first_then_the_simulated_ones():
    cars = [
        car_status("red", Pose(1.0, 2.0, 0.5 * math.pi), sent=(-0.5, 1.0)),
        car_status("blue", Pose(-1.0, 0.0, 0.0), runs=False),
    ]
    sims = [companion(1, 0.5, 0.5, 1.0), companion(2, -0.5, 0.5)]
    frame = framed(status_at(42, 9.0, "armed", cars, Pose(2.0, 0.0, 0.0), sims))
    assert frame.ids.tolist() == [0, 1, 1000, 1001]
    assert frame.live.names == ("red", "blue", "sim 1", "sim 2")
    assert frame.live.states == ("tracked", "stopped", "simulated", "simulated")
    assert frame.live.ages == pytest.approx([0.005, 0.005, 0.0, 0.0])
    assert (frame.live.fence, frame.live.arm) == (0.5, "armed")
    assert frame.position[0] == pytest.approx([1.0, 2.0])
    assert frame.heading[0] == pytest.approx([0.0, 1.0])
    assert frame.cars.steering == pytest.approx(np.radians([-22.5, 22.5, 45.0, 0.0]))
    assert not frame.cars.stuck.any()
    assert not frame.cars.predator.any()
    assert frame.progress.goal == pytest.approx([2.0, 0.0])
    assert (frame.run, frame.tick, frame.dt, frame.unit) == (3, 42, 0.01, "s")


def test_the_world_is_the_area_and_stays_one_object():
    one, other = (framed(status_at(k, 0.1 * k, "safe", [car_status("red")])) for k in (1, 2))
    assert one.world is other.world
    assert one.low == pytest.approx(LAB.area.low)
    assert one.low + one.size == pytest.approx(LAB.area.high)
    assert set(one.world.edges) == {"open"}


def test_a_lost_car_stays_where_it_was_seen_and_one_never_seen_is_left_out():
    lost = car_status("blue", Pose(1.0, 1.0, 0.0), age=3.0, tracking="lost")
    frame = framed(status_at(1, 1.0, "safe", [car_status("red", None), lost]))
    assert (frame.ids.tolist(), frame.live.states) == ([1], ("lost",))
    assert frame.position.tolist() == [[1.0, 1.0]]


def test_before_anybody_was_seen_a_frame_is_empty():
    frame = framed(status_at(1, 1.0, "safe", [car_status("red", None), car_status("blue", None)]))
    assert frame.position.shape == frame.heading.shape == (0, 2)
    assert frame.progress.goal is None
    assert frame.live.names == ()


def test_speeds_are_those_of_the_last_tenth_of_a_second():
    def looked(time):
        x = 0.8 * time if time > 0.85 else 3.0 * time
        red = car_status("red", Pose(x, 0.0, 0.0), age=0.0)
        return status_at(0, time, "armed", [red], None, [companion(1, 0.0, 0.5 * time)])

    times = [0.7 + 0.03 * k for k in range(11)]
    statuses = [looked(time) for time in times]
    frame = framed(statuses[-1], statuses[:-1])
    assert frame.speed == pytest.approx([0.8, 0.5])


def test_a_single_look_tells_no_speed_and_a_lost_car_has_none():
    car = car_status("red", Pose(1.0, 1.0, 0.0))
    assert framed(status_at(1, 1.0, "safe", [car])).speed.tolist() == [0.0]
    statuses = [
        status_at(
            k, 1.0 + 0.03 * k, "safe", [car_status("red", age=1.0 + 0.03 * k, tracking="lost")]
        )
        for k in range(4)
    ]
    assert framed(statuses[-1], statuses[:-1]).speed.tolist() == [0.0]


def test_a_room_that_nobody_looks_at_has_lost_its_cars():
    frame = framed(status_at(1, 1.0, "armed", [car_status("red")], None, [companion(1)]))
    gone = frame_without_loop(frame)
    assert (gone.live.states, gone.live.arm) == (("lost", "simulated"), "safe")
    assert gone.speed.tolist() == [0.0, 0.0]
    assert frame.live.arm == "armed"


def test_recordings_of_one_second_have_folders_of_their_own(tmp_path):
    now = datetime(2026, 11, 22, 9, 30, 15)
    names = []
    for _ in range(3):
        folder = new_folder(tmp_path, now)
        names.append(folder.name)
        folder.mkdir()
    assert names == ["2026-11-22-093015", "2026-11-22-093015-2", "2026-11-22-093015-3"]
