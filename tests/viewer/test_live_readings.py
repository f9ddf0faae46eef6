"""What is measured of a room."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.live.control.injected_target import Injection
from app.live.control.pose import Pose
from app.viewer.live.room_frame import (
    EVERY,
    RoomReadings,
    least_distance,
    phase_lags,
    wrapped_degrees,
)
from app.viewer.measuring.time_series import POINTS
from tests.viewer.stub_operator import car_status, companion, status_at

CIRCLE = Injection(centre=(1.0, 0.0), radius=2.0)


def round_it(degrees, radius=2.0):
    """A pose on the circle, so far round it."""
    at = math.radians(degrees)
    return Pose(1.0 + radius * math.cos(at), radius * math.sin(at), 0.0)


def readings_of(statuses, plan=CIRCLE):
    readings = RoomReadings(plan)
    for status in statuses:
        readings.note(status)
    return readings


def values(series):
    """The last minute of a series, (T,)."""
    return series.arrays(60.0)[1]


def test_times_count_from_the_first_look_and_come_ten_times_a_second():
    readings = readings_of(status_at(k, 500.0 + 0.03 * k) for k in range(101))
    times, loop = readings.loop.arrays(60.0)
    assert times[0] == 0.0
    assert np.diff(times).min() >= EVERY - 1e-6
    assert np.diff(times).max() < EVERY + 0.03
    assert times[-1] == pytest.approx(3.0)
    assert loop == pytest.approx(np.full(len(times), 10.0))
    assert values(readings.worst) == pytest.approx(np.full(len(times), 20.0))
    assert values(readings.latency) == pytest.approx(np.full(len(times), 10.0))


def test_the_last_minute_is_kept_in_full_and_times_go_on():
    readings = readings_of(status_at(k, 7.0 + 0.1 * k) for k in range(2000))
    times, _ = readings.loop.arrays(60.0)
    assert (times[0], times[-1]) == (pytest.approx(139.9, abs=0.11), pytest.approx(199.9))
    assert len(times) >= POINTS
    assert np.diff(times) == pytest.approx(np.full(len(times) - 1, 0.1))
    assert len(readings.least.arrays(60.0)[0]) == len(times)


def test_what_was_looked_at_is_not_changed():
    readings = readings_of([status_at(0, 1.0)])
    before = readings.loop.arrays()
    readings.note(status_at(30, 2.0))
    assert (len(before[0]), len(readings.loop.arrays()[0])) == (1, 2)


def test_the_least_distance_counts_simulated_cars_and_not_lost_ones():
    cars = [car_status("red", Pose(0.0, 0.0, 0.0)), car_status("blue", Pose(3.0, 4.0, 0.0))]
    near = car_status("green", Pose(0.1, 0.0, 0.0), age=2.0, tracking="lost")
    never = car_status("grey", None)
    injected = Pose(0.0, 0.0, 0.0)

    def least(*cars, companions=()):
        return readings_of([status_at(0, 1.0, "safe", cars, injected, companions)]).least.newest

    assert least(*cars) == 5.0
    assert least(*cars, near, never) == 5.0
    assert least(*cars, companions=[companion(1, 0.0, 0.5)]) == 0.5
    assert math.isnan(least(cars[0], never))
    assert math.isnan(least_distance([]))


@pytest.mark.parametrize(("sense", "ahead"), [(1.1, 1.0), (-1.1, -1.0)])
def test_the_lag_is_how_far_a_car_is_behind_along_the_sense(sense, ahead):
    plan = Injection(centre=(1.0, 0.0), speed=sense)
    for lag in (-179.0, -90.0, 0.0, 30.0, 55.9, 179.9):
        for at in range(0, 360, 45):
            found = phase_lags(plan, round_it(at), {"red": round_it(at - ahead * lag, 1.5)})
            assert found["red"] == pytest.approx(lag)


def test_a_lag_is_never_below_minus_180():
    assert wrapped_degrees(math.pi) == 180.0
    assert wrapped_degrees(-math.pi) == 180.0
    assert wrapped_degrees(math.radians(181.0)) == pytest.approx(-179.0)


def test_without_a_circle_there_is_no_lag():
    status = status_at(0, 1.0, "safe", [car_status("red")], Pose(1.0, 0.0, 0.0))
    assert readings_of([status], Injection(path="eight")).lags == {}
    assert readings_of([status_at(0, 1.0, "safe", [car_status("red")])]).lags == {}


def test_lags_have_a_gap_where_a_car_is_not_seen_or_not_yet_there():
    injected = round_it(90)
    red = car_status("red", round_it(60))
    lost = car_status("red", round_it(60), age=1.0, tracking="lost")
    sims = [companion(1, round_it(45).x, round_it(45).y)]
    readings = readings_of(
        [
            status_at(0, 1.0, "armed", [red], injected),
            status_at(30, 2.0, "armed", [lost], injected, sims),
            status_at(60, 3.0, "armed", [red], injected, sims),
        ]
    )
    assert values(readings.lags["red"]) == pytest.approx([30.0, math.nan, 30.0], nan_ok=True)
    assert readings.lags["sim 1"].arrays()[0].tolist() == [1.0, 2.0]
    assert values(readings.lags["sim 1"]) == pytest.approx([45.0, 45.0])
