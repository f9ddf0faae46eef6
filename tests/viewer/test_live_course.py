"""What the monitors of a room plot."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.live.control.injected import Injection
from app.live.control.pose import Pose
from app.viewer.live.course import EVERY, KEPT, Course, behind, least_distance, phase_lags
from tests.viewer.stub_operator import car_status, companion, status_at

CIRCLE = Injection(centre=(1.0, 0.0), radius=2.0)


def round_it(degrees, radius=2.0):
    """A pose on the circle, so far round it."""
    at = math.radians(degrees)
    return Pose(1.0 + radius * math.cos(at), radius * math.sin(at), 0.0)


def course_of(statuses, plan=CIRCLE):
    course = Course(plan)
    for status in statuses:
        course = course.after(status)
    return course


def test_times_count_from_the_first_look_and_come_ten_times_a_second():
    course = course_of(status_at(k, 500.0 + 0.03 * k) for k in range(101))
    assert course.times[0] == 0.0
    assert np.diff(course.times).min() >= EVERY - 1e-6
    assert np.diff(course.times).max() < EVERY + 0.03
    assert course.times[-1] == pytest.approx(3.0)
    assert course.loop == pytest.approx(np.full(len(course.times), 10.0))
    assert course.worst == pytest.approx(np.full(len(course.times), 20.0))
    assert course.latency == pytest.approx(np.full(len(course.times), 10.0))


def test_two_minutes_are_kept_and_times_go_on():
    course = course_of(status_at(k, 7.0 + k) for k in range(200))
    assert (course.times[0], course.times[-1]) == (199.0 - KEPT, 199.0)
    assert len(course.least) == len(course.times) == KEPT + 1


def test_a_course_that_was_taken_is_not_changed():
    before = course_of([status_at(0, 1.0)])
    after = before.after(status_at(30, 2.0))
    assert (len(before.times), len(after.times)) == (1, 2)


def test_the_least_distance_counts_simulated_cars_and_not_lost_ones():
    cars = [car_status("red", Pose(0.0, 0.0, 0.0)), car_status("blue", Pose(3.0, 4.0, 0.0))]
    near = car_status("green", Pose(0.1, 0.0, 0.0), age=2.0, tracking="lost")
    never = car_status("grey", None)
    injected = Pose(0.0, 0.0, 0.0)

    def least(*cars, companions=()):
        return course_of([status_at(0, 1.0, "safe", cars, injected, companions)]).least[0]

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
    assert behind(math.pi) == 180.0
    assert behind(-math.pi) == 180.0
    assert behind(math.radians(181.0)) == pytest.approx(-179.0)


def test_without_a_circle_there_is_no_lag():
    status = status_at(0, 1.0, "safe", [car_status("red")], Pose(1.0, 0.0, 0.0))
    assert course_of([status], Injection(path="eight")).lags == {}
    assert course_of([status_at(0, 1.0, "safe", [car_status("red")])]).lags == {}


def test_lags_have_a_gap_where_a_car_is_not_seen_or_not_yet_there():
    injected = round_it(90)
    red = car_status("red", round_it(60))
    lost = car_status("red", round_it(60), age=1.0, tracking="lost")
    sims = [companion(1, round_it(45).x, round_it(45).y)]
    course = course_of(
        [
            status_at(0, 1.0, "armed", [red], injected),
            status_at(30, 2.0, "armed", [lost], injected, sims),
            status_at(60, 3.0, "armed", [red], injected, sims),
        ]
    )
    assert course.lags["red"] == pytest.approx([30.0, math.nan, 30.0], nan_ok=True)
    assert course.lags["sim 1"] == pytest.approx([math.nan, 45.0, 45.0], nan_ok=True)
