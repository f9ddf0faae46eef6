"""The injected car: exact places on its paths, its speed along them, and the hand."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.live.control.injected_target import INJECTED, InjectedTarget, Injection
from app.live.control.pose import Pose, seen
from live.rooms import lab
from worlds.input_error import InputError

AREA = lab().area
SQUARE = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
PLANS = {
    "circle": Injection(centre=(0.25, -0.25), radius=2.0, speed=1.1, begins=30.0),
    "back": Injection(radius=2.0, speed=-1.1),
    "eight": Injection(path="eight", radius=1.2, speed=0.8),
    "eight back": Injection(path="eight", radius=1.2, speed=-0.8),
    "route": Injection(path="route", route=SQUARE, speed=0.5),
    "route back": Injection(path="route", route=SQUARE, speed=-0.5),
}


def at(plan: Injection, seconds: float) -> tuple[float, float, float]:
    pose = plan.pose_after(seconds)
    return pose.x, pose.y, pose.yaw


def near(*place: float):
    return pytest.approx(place, abs=1e-12)


def test_places_on_the_circle():
    plan = Injection(radius=2.0, speed=1.0, begins=90.0)
    assert at(plan, 0.0)[:2] == near(0.0, 2.0)
    assert at(plan, math.pi) == near(-2.0, 0.0, -math.pi / 2)


def test_places_on_the_eight():
    plan = Injection(path="eight", centre=(0.5, 0.0), radius=1.0, speed=1.0)
    assert at(plan, 0.0) == near(0.5, 0.0, 0.0)
    assert at(plan, 0.5 * math.pi) == near(1.5, 1.0, math.pi / 2)
    assert at(plan, 1.5 * math.pi) == near(-0.5, 1.0, -math.pi / 2)
    assert at(plan, 2.5 * math.pi) == near(1.5, -1.0, -math.pi / 2)
    assert at(plan, 3.5 * math.pi) == near(-0.5, -1.0, math.pi / 2)
    assert at(plan, 4.5 * math.pi) == near(1.5, 1.0, math.pi / 2)


def test_places_on_the_route():
    plan = PLANS["route"]
    assert at(plan, 0.0) == near(1.0, 1.0, math.pi)
    assert at(plan, 2.0) == near(0.0, 1.0, math.pi)
    assert at(plan, 6.0) == near(-1.0, 0.0, -math.pi / 2)
    assert at(plan, 14.0) == near(1.0, 0.0, math.pi / 2)
    assert at(plan, 18.0) == near(0.0, 1.0, math.pi)
    assert at(PLANS["route back"], 2.0) == near(1.0, 0.0, -math.pi / 2)


@pytest.mark.parametrize("name", PLANS)
@given(seconds=st.floats(0.0, 100.0))
def test_it_moves_with_its_speed_along_its_nose_and_within_its_corners(name, seconds):
    plan = PLANS[name]
    here, later = plan.pose_after(seconds), plan.pose_after(seconds + 1e-5)
    turn = abs(math.remainder(later.yaw - here.yaw, 2.0 * math.pi))
    # at a corner of the route it turns on the spot, in the middle of the eight it changes sides
    if turn < 0.1:
        assert later.x - here.x == pytest.approx(
            abs(plan.speed) * 1e-5 * math.cos(here.yaw), abs=1e-9
        )
        assert later.y - here.y == pytest.approx(
            abs(plan.speed) * 1e-5 * math.sin(here.yaw), abs=1e-9
        )
    xs, ys = zip(*plan.corners(), strict=True)
    assert min(xs) - 1e-9 <= here.x <= max(xs) + 1e-9
    assert min(ys) - 1e-9 <= here.y <= max(ys) + 1e-9
    assert -math.pi <= here.yaw <= math.pi


def test_it_moves_only_while_the_cars_run():
    target = InjectedTarget(PLANS["circle"], AREA)
    first = target.pose_at(10.0, False, ())
    assert target.pose_at(20.0, False, ()) == first
    assert target.pose_at(21.0, True, ()) == PLANS["circle"].pose_after(1.0)
    assert target.pose_at(31.0, False, ()) == PLANS["circle"].pose_after(1.0)


def test_a_hand_cannot_leave_the_fence():
    hand = InjectedTarget(Injection(path="hand"), AREA)
    hand.place(9.0, -9.0)
    assert hand.pose_at(0.0, True, ()) == Pose(2.5, -2.5, pytest.approx(-math.pi / 4))
    with pytest.raises(InputError, match="cannot be at"):
        hand.place(math.nan, 0.0)
    hand.place(2.5, -2.495)
    assert hand.pose_at(0.0, True, ()) == Pose(2.5, -2.495, pytest.approx(-math.pi / 4))


def test_a_body_is_where_it_is_seen():
    target = InjectedTarget(Injection(path="body", body="wand"), AREA)
    pose = Pose(1.0, 2.0, 3.0)
    assert (
        target.pose_at(0.0, True, (seen("red", Pose(0.0, 0.0, 0.0)), seen(INJECTED, pose))) == pose
    )
    assert target.pose_at(0.0, True, ()) is None


def test_none_is_nowhere():
    assert InjectedTarget(Injection(path="none"), AREA).pose_at(0.0, True, ()) is None
