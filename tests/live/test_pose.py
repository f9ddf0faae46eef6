"""Poses on the floor: quaternions, axes and units."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.live.control.pose import MocapFrame, Pose, seen, unseen
from app.live.sources.axes import NOSES, Axes, rotate_axis
from worlds.input_error import InputError

HALF = math.sqrt(0.5)
ABOUT_Z = (0.0, 0.0, HALF, HALF)
"""90 degrees anticlockwise about z."""
ABOUT_Y = (0.0, HALF, 0.0, HALF)
ABOUT_X = (HALF, 0.0, 0.0, HALF)


def test_a_frame_tells_only_of_what_it_tracks():
    frame = MocapFrame(1, 10.0, (seen("car1", Pose(1.0, 2.0, 3.0)), unseen("car2")))
    assert frame.pose("car1") == Pose(1.0, 2.0, 3.0)
    assert frame.pose("car2") is None
    assert frame.pose("car3") is None
    assert frame.age(10.5) == 0.5
    assert frame.sent is None


@pytest.mark.parametrize(
    ("axes", "point", "quaternion", "pose"),
    [
        (Axes(), (1, 2, 3), (0, 0, 0, 1), (1, 2, 0)),
        (Axes(), (1, 2, 3), ABOUT_Z, (1, 2, math.pi / 2)),
        (Axes(), (1, 2, 3), (0, 0, 1, 0), (1, 2, math.pi)),
        (Axes(), (1, 2, 3), (0, 0, -HALF, HALF), (1, 2, -math.pi / 2)),
        (Axes(), (1, 2, 3), tuple(-q for q in ABOUT_Z), (1, 2, math.pi / 2)),
        (Axes(top="y"), (0, 0, 0), ABOUT_X, (0, 0, 0)),  # a body defined on its side
        (Axes(up="y"), (1, 2, 3), (0, 0, 0, 1), (1, -3, 0)),
        (Axes(up="y"), (1, 2, 3), ABOUT_Y, (1, -3, math.pi / 2)),
        (Axes(up="y"), (0, 0, -1), (0, 0, 0, 1), (0, 1, 0)),
        (Axes(unit="mm"), (1000, -250, 40), (0, 0, 0, 1), (1, -0.25, 0)),
        (Axes(unit="cm"), (100, -25, 4), (0, 0, 0, 1), (1, -0.25, 0)),
        (Axes(up="y", unit="mm"), (1500, 40, -500), ABOUT_Y, (1.5, 0.5, math.pi / 2)),
        (Axes(nose="y"), (0, 0, 0), (0, 0, 0, 1), (0, 0, math.pi / 2)),
        (Axes(nose="-x"), (0, 0, 0), (0, 0, 0, 1), (0, 0, math.pi)),
        (Axes(nose="-y"), (0, 0, 0), ABOUT_Z, (0, 0, 0)),
        (Axes(up="y", nose="-z"), (0, 0, 0), (0, 0, 0, 1), (0, 0, math.pi / 2)),
        (Axes(up="y", nose="z"), (0, 0, 0), ABOUT_Y, (0, 0, 0)),
        (Axes(nose="z"), (0, 0, 0), ABOUT_Y, (0, 0, 0)),
    ],
)
def test_exact_poses(axes, point, quaternion, pose):
    found = axes.pose(point, quaternion)
    assert (found.x, found.y) == pytest.approx(pose[:2], abs=1e-12)
    assert math.remainder(found.yaw - pose[2], math.tau) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("axes", "point", "quaternion"),
    [
        (Axes(), (1, 2, 3), (0, 0, 0, 0)),  # as an untracked body is sent
        (Axes(), (1, 2, 3), (0, 0, 0, 1.02)),
        (Axes(), (1, 2, 3), (0, 0, 0, math.nan)),
        (Axes(), (math.nan, 2, 3), (0, 0, 0, 1)),
        (Axes(), (1, math.inf, 3), (0, 0, 0, 1)),
        (Axes(), (1, 2, 3), ABOUT_Y),  # on its nose
        (Axes(), (1, 2, 3), ABOUT_X),  # on its side: the nose still points on
        (Axes(), (1, 2, 3), (1, 0, 0, 0)),  # on its roof, as yaw 0 looks that is written w first
        (Axes(top="z"), (1, 2, 3), ABOUT_X),
        (Axes(top="-z"), (1, 2, 3), (0, 0, 0, 1)),
        (Axes(up="y"), (1, 2, 3), (1, 0, 0, 0)),
        (Axes(up="y"), (1, 2, 3), ABOUT_Z),
        (Axes(up="y"), (1, 2, math.nan), (0, 0, 0, 1)),
        (Axes(nose="z"), (1, 2, 3), (0, 0, 0, 1)),
    ],
)
def test_what_is_no_pose_on_the_floor_is_none(axes, point, quaternion):
    assert axes.pose(point, quaternion) is None


def test_a_nose_is_too_steep_beyond_60_degrees():
    for degrees, told in ((59.0, True), (61.0, False)):
        half = math.radians(degrees) / 2
        pose = Axes().pose((0, 0, 0), (0.0, math.sin(half), 0.0, math.cos(half)))
        assert (pose is not None) is told


def test_a_car_lies_beyond_a_roll_of_30_degrees_whatever_its_pitch():
    for degrees, told in ((-31.0, False), (-29.0, True), (29.0, True), (31.0, False)):
        half = math.radians(degrees) / 2
        x, w = math.sin(half), math.cos(half)
        for pitch in (-0.9, 0.0, 0.9):
            c, s = math.cos(pitch / 2), math.sin(pitch / 2)
            sighting = Axes().sighting("red", (0, 0, 0), (c * x, s * w, -s * x, c * w))
            assert sighting.valid is told
            assert sighting.why == (
                ""
                if told
                else "its axis z, which should point up, is rolled 31 degrees about its nose"
            )


def test_the_yaw_of_a_car_that_looks_back_is_pi_and_not_minus_pi():
    for axes, quaternion in ((Axes(), (0, 0, -1, 0)), (Axes(up="y"), (0, 1, 0, 0))):
        assert axes.pose((0, 0, 0), quaternion).yaw == math.pi


def test_the_height_of_a_car_does_not_matter():
    assert Axes().pose((1, 2, math.nan), (0, 0, 0, 1)) == Pose(1.0, 2.0, 0.0)


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: math.hypot(*q) > 0.1))
def test_a_turned_axis_is_that_of_the_hamilton_product(quaternion):
    """q v q*, with products of quaternions written out as a matrix, apart from the code."""
    x, y, z, w = np.array(quaternion) / math.hypot(*quaternion)
    left = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    right = np.array([[w, -z, y, -x], [z, w, -x, -y], [-y, x, w, -z], [x, y, z, w]])
    for nose in NOSES:
        axis = np.zeros(4)
        axis["xyz".index(nose[-1])] = -1.0 if nose.startswith("-") else 1.0
        assert rotate_axis(nose, (x, y, z, w)) == pytest.approx(
            (left @ right @ axis)[:3], abs=1e-12
        )


@given(
    st.floats(-math.pi, math.pi),
    st.floats(-0.9, 0.9),
    st.sampled_from([("z", (0, 0, 1)), ("y", (0, 1, 0))]),
)
def test_yaw_is_the_angle_about_the_up_axis_whatever_the_pitch(yaw, pitch, up):
    """A car that is pitched about its own left axis, then turned about the up axis."""
    name, axis = up
    left = np.cross(axis, (1, 0, 0))
    turn = np.append(np.sin(yaw / 2) * np.array(axis), np.cos(yaw / 2))
    tip = np.append(np.sin(pitch / 2) * left, np.cos(pitch / 2))
    x, y, z = turn[3] * tip[:3] + tip[3] * turn[:3] + np.cross(turn[:3], tip[:3])
    pose = Axes(up=name).pose((0, 0, 0), (x, y, z, turn[3] * tip[3] - turn[:3] @ tip[:3]))
    assert math.remainder(pose.yaw - yaw, math.tau) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("declared", "says"),
    [
        ({"up": "Z"}, "unknown up axis 'Z': did you mean 'z'"),
        ({"unit": "millimetres"}, "unknown unit 'millimetres'"),
        ({"nose": "w"}, "unknown nose axis 'w'"),
        ({"top": "up"}, "unknown top axis 'up'"),
        ({"nose": "-x", "top": "x"}, "top = x lies along the nose, -x"),
    ],
)
def test_axes_that_are_none_are_refused(declared, says):
    with pytest.raises(InputError, match=says):
        Axes(**declared)
