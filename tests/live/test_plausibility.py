"""What the tracking says, held against what cars on a floor can do: exact cases, and oracles."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.live.control.plausibility import (
    AGREES,
    LONGEST_STRIDE,
    STRIDE,
    BodyTrack,
    Jump,
    Swap,
    circular_spread,
    compare_yaw,
    find_jumps,
    find_vertical,
    judge_bodies,
    tilt_degrees,
)

NONE = np.empty((0, 3))


def track(x, y, yaw, name="red", up=NONE, step=0.01):
    """A track of 100 frames a second from lists or numbers."""
    x, y, yaw = np.broadcast_arrays(*(np.asarray(one, float) for one in (x, y, yaw)))
    n = len(x)
    return BodyTrack(name, np.arange(n), step * np.arange(n), np.column_stack([x, y]), yaw, up)


def ups(*vectors):
    return np.array(vectors, float)


def judged(*tracks, top="z"):
    return judge_bodies(tracks, top, {one.name: 1.0 for one in tracks}, 0.25)


@pytest.mark.parametrize(
    ("up", "axis", "tilt"),
    [
        ((0, 0, 1), "z", 0.0),
        ((0, 0, -1), "-z", 0.0),
        ((0, -1, 0), "-y", 0.0),
        ((math.sin(0.2), 0, math.cos(0.2)), "z", math.degrees(0.2)),
    ],
)
def test_the_axis_that_points_up(up, axis, tilt):
    found = find_vertical(ups(up, up, up))
    assert (found.axis, found.upright) == (axis, 1.0)
    assert found.tilt == pytest.approx(tilt, abs=1e-9)


@given(st.lists(st.tuples(*[st.floats(-1.0, 1.0)] * 3), min_size=1, max_size=20))
def test_the_tilt_is_the_angle_between_two_vectors(vectors):
    lengths = [math.hypot(*vector) for vector in vectors]
    vectors = [
        [part / length for part in vector]
        for vector, length in zip(vectors, lengths, strict=True)
        if length > 0.1
    ]
    for sign, axis in ((1.0, "y"), (-1.0, "-y")):
        there = [0.0, sign, 0.0]
        oracle = [
            2.0 * math.degrees(math.asin(min(0.5 * math.dist(vector, there), 1.0)))
            for vector in vectors
        ]
        if vectors:
            assert tilt_degrees(np.array(vectors), axis) == pytest.approx(oracle, abs=1e-5)


def test_a_body_whose_top_is_another_axis_says_which():
    reports, _ = judged(track([0.0] * 3, 0.0, 0.0, up=ups(*[(0, 0, -1)] * 3)))
    assert reports["red"].faults == ["its axis -z points up, not z"]
    reports, _ = judged(track([0.0] * 3, 0.0, 0.0, up=ups(*[(0, 1, 0)] * 3)), top="")
    assert reports["red"].faults == []


def test_a_body_that_rolls_about_its_nose_has_no_axis_that_stays_vertical():
    rolls = np.linspace(0.0, math.tau, 100)
    up = np.column_stack([0 * rolls, np.sin(rolls), np.cos(rolls)])
    reports, _ = judged(track([0.0] * 100, 0.0, 0.0, up=up))
    assert "points up in 18 % of its frames, and no other axis stays" in reports["red"].misread


@pytest.mark.parametrize(
    ("off", "forwards", "backwards", "says"),
    [
        (0.0, 1.0, 0.0, ""),
        (29.0, 1.0, 0.0, ""),
        (31.0, 0.0, 0.0, "agrees with its direction of motion in 0 % of its way, off by 31 degr"),
        (90.0, 0.0, 0.0, "off by 90 degrees in the mean"),
        (-90.0, 0.0, 0.0, "off by -90 degrees in the mean"),
        (179.0, 0.0, 1.0, "it drives backwards in 100 % of its way"),
    ],
)
def test_yaw_against_the_direction_of_motion_is_exact_on_a_circle(off, forwards, backwards, says):
    angle = 0.005 * np.arange(500)
    circle = track(2 * np.cos(angle), 2 * np.sin(angle), angle + math.pi / 2 - math.radians(off))
    found = compare_yaw(circle, set())
    assert found.difference == pytest.approx(off, abs=1e-6)
    assert (found.forwards, found.backwards) == (forwards, backwards)
    reports, _ = judged(circle)
    assert (says in reports["red"].misread) if says else not reports["red"].misread


def test_a_yaw_that_stays_while_the_car_turns_is_named():
    angle = 0.005 * np.arange(1000)
    reports, _ = judged(track(2 * np.cos(angle), 2 * np.sin(angle), 0.0))
    assert reports["red"].misread == "its yaw stays 0 degrees while it moves in many directions"
    # one that drives straight on has a constant yaw too
    reports, _ = judged(track(np.linspace(0.0, 3.0, 300), 0.0, 0.0))
    assert reports["red"].misread == ""


def test_a_car_that_stands_or_creeps_is_not_judged_by_its_yaw():
    shaken = 0.0005 * np.sin(12.9898 * np.arange(500))
    assert compare_yaw(track(shaken, -shaken, 1.0), set()) is None
    assert compare_yaw(track(np.linspace(0.0, 0.4, 500), 0.0, 1.0), set()) is None


def test_a_car_that_backs_out_now_and_then_is_sound():
    x = np.concatenate([np.linspace(0, 2, 200), np.linspace(2, 1.5, 50), np.linspace(1.5, 4, 250)])
    reports, _ = judged(track(x, 0.0, 0.0))
    assert reports["red"].faults == []
    assert 0.0 < reports["red"].yaw.backwards < 0.2


def naive_strides(found):
    """Chord directions and mean yaws, from the definition, one frame after the other."""
    result, start = [], 0
    for k in range(len(found.time)):
        if found.time[k] - found.time[start] > LONGEST_STRIDE:
            start = k
        chord = found.position[k] - found.position[start]
        if np.linalg.norm(chord) >= STRIDE:
            yaw = np.angle(np.mean(np.exp(1j * found.yaw[start : k + 1])))
            result.append((np.angle(complex(*chord)), yaw))
            start = k
    return np.array(result).reshape(-1, 2)


@given(st.integers(0, 2**32 - 1))
def test_strides_are_those_of_the_definition(seed):
    rng = np.random.default_rng(seed)
    steps = rng.normal(scale=rng.uniform(0.002, 0.05), size=(2, 200))
    found = track(*np.cumsum(steps, axis=1), rng.uniform(-4.0, 4.0, 200))
    strides = naive_strides(found)
    agreement = compare_yaw(found, set())
    if len(strides) < 10:
        assert agreement is None
        return
    off = np.angle(np.exp(1j * (strides[:, 0] - strides[:, 1])))
    assert agreement.strides == len(strides)
    assert agreement.forwards == np.mean(np.abs(off) <= math.radians(AGREES))
    mean = np.degrees(np.angle(np.mean(np.exp(1j * off))))
    assert math.remainder(agreement.difference - mean, 360.0) == pytest.approx(0.0, abs=1e-6)


def test_the_spread_of_angles_does_not_know_where_the_circle_is_cut():
    rng = np.random.default_rng(1)
    angles = rng.normal(scale=0.1, size=2000)
    assert circular_spread(angles) == pytest.approx(math.degrees(0.1), rel=0.05)
    assert circular_spread(angles + math.pi) == pytest.approx(circular_spread(angles))


def test_a_jump_is_what_twice_the_top_speed_and_the_leap_do_not_reach():
    # 100 Hz, 1 m/s: 0.25 + 2 * 0.01 = 0.27 m from frame to frame
    assert find_jumps(track([0.0, 0.2699, 0.0], 0.0, 0.0), 1.0, 0.25) == []
    assert find_jumps(track([0.0, 0.2701, 0.2701], 0.0, 0.0), 1.0, 0.25) == [Jump(1, 0.2701)]
    # a gap of a second allows 2 m more
    assert find_jumps(track([0.0, 2.2], 0.0, 0.0, step=1.0), 1.0, 0.25) == []


def test_two_that_change_places_are_no_jumps():
    a, b = np.zeros(10), np.ones(10)
    a[4:7], b[4:7] = 1.0, 0.0
    reports, swaps = judged(track(a, 0.0, 0.0, "red"), track(b, 0.0, 0.0, "blue"))
    assert swaps == [Swap(4, "red", "blue"), Swap(7, "red", "blue")]
    assert not reports["red"].faults
    assert not reports["blue"].faults
    # both leap in one frame, but not to where the other was
    b[4:7] = 5.0
    reports, swaps = judged(track(a, 0.0, 0.0, "red"), track(b, 0.0, 0.0, "blue"))
    assert swaps == []
    assert reports["red"].faults == [
        "it jumps 2 times as no car can, the furthest 1.00 m in frame 4"
    ]


@given(st.integers(0, 2**32 - 1))
def test_jumps_and_swaps_are_those_of_the_definition(seed):
    rng = np.random.default_rng(seed)
    tracks = [
        track(*rng.choice([0.0, 0.2, 1.0], size=(2, 12)), 0.0, name) for name in ("a", "b", "c")
    ]
    _, swaps = judged(*tracks)
    oracle = []
    for k in range(1, 12):
        for one, other in (("a", "b"), ("a", "c"), ("b", "c")):
            p, q = (next(t.position for t in tracks if t.name == name) for name in (one, other))

            def near(a, b):
                return math.dist(a, b) <= 0.27

            jumped = not near(p[k], p[k - 1]) and not near(q[k], q[k - 1])
            if jumped and near(p[k], q[k - 1]) and near(q[k], p[k - 1]):
                oracle.append(Swap(k, one, other))
    assert swaps == oracle
