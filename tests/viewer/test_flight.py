"""How birds bank into their turns, beat their wings and glide."""

from __future__ import annotations

import numpy as np
import pytest

from app.viewer.scene.draw.agent_shapes import MOTION
from app.viewer.scene.draw.attitude import nose
from app.viewer.scene.marks.agents import (
    FlockMotion,
    left_turns,
)
from tests.viewer.sky import STEP, Clock, frame, heading, shown
from tests.viewer.test_scene_geometry import rotated


def circling(flight: FlockMotion, clock: Clock, rate: float, frames: int = 400, speed: float = 3.0):
    """The poses of a bird that has turned left at `rate` rad/s for long."""
    for tick in range(frames):
        clock.now += STEP
        one = frame([heading(0.1 * rate * tick)], tick, speed=np.array([speed]))
        poses = flight.follow(shown(one))
    return one, poses


def bank(wxyz: np.ndarray) -> float:
    """How far the right wing is down, rad, of a bird that flies level: an oracle by vectors."""
    left = rotated(wxyz, np.array([0.0, 1.0, 0.0]))
    over = rotated(wxyz, np.array([0.0, 0.0, 1.0]))
    return float(np.arctan2(left[2], over[2]))


def test_turning_left_is_above_nought_and_at_most_a_right_angle():
    before = np.array([heading(0.0), heading(1.0), heading(3.0), heading(0.0, 0.5 * np.pi)])
    after = np.array([heading(0.2), heading(0.7), heading(3.0 + np.pi), heading(0.0)])
    assert left_turns(before, after) == pytest.approx([0.2, -0.3, 0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("rate", [-1.0, -0.3, 0.3, 1.0])
def test_a_bird_banks_into_its_turn_by_speed_times_turning_over_gravity(rate):
    clock = Clock()
    one, poses = circling(FlockMotion(clock), clock, rate)
    pull = one.speed_scale**2 / (MOTION.nimble * one.reach)
    angle = np.arctan(3.0 * np.arcsin(np.sin(0.1 * rate)) / 0.1 / pull)
    assert bank(poses.wxyz[0]) == pytest.approx(-angle, abs=2e-3)
    assert nose(poses.wxyz[0]) == pytest.approx(one.heading[0], abs=1e-5)


def test_no_bird_banks_further_than_the_steepest_or_at_rest():
    clock = Clock()
    _, poses = circling(FlockMotion(clock), clock, 12.0)
    assert bank(poses.wxyz[0]) == pytest.approx(-np.arctan(MOTION.steepest), abs=1e-5)
    _, poses = circling(FlockMotion(clock), clock, 12.0, speed=0.0)
    assert bank(poses.wxyz[0]) == pytest.approx(0.0, abs=1e-6)


def test_a_bird_leans_over_little_by_little():
    clock = Clock()
    flight = FlockMotion(clock)
    banks = []
    for tick in range(60):
        clock.now += STEP
        poses = flight.follow(shown(frame([heading(2.0 * (tick > 20))], tick)))
        banks.append(bank(poses.wxyz[0]))
    assert np.allclose(banks[:21], 0.0, atol=1e-6)
    steps = np.abs(np.diff(banks))
    assert steps[20] == steps.max()
    assert 0.05 < steps.max() < 0.2
    assert abs(banks[-1]) < 0.1


def test_wings_beat_while_ticks_pass_and_stand_still_while_paused():
    clock = Clock()
    flight = FlockMotion(clock)
    ahead = [heading(0.0)] * 3
    beats = []
    for tick in range(80):
        clock.now += STEP
        beats.append(flight.follow(shown(frame(ahead, tick))).beat)
    beats = np.array(beats)
    assert np.all(np.ptp(beats, axis=0) > 1.6 * MOTION.amplitude)
    assert np.all(np.abs(beats - MOTION.dihedral) <= MOTION.amplitude)
    assert np.abs(np.diff(beats, axis=0)).max() < 0.5
    assert not np.allclose(beats[:, 0], beats[:, 1])
    for _ in range(5):
        clock.now += 3.0
        assert np.array_equal(flight.follow(shown(frame(ahead, 79))).beat, beats[-1])
    clock.now += 3.0
    after = flight.follow(shown(frame(ahead, 80))).beat
    slow = FlockMotion(clock)
    slow.follow(shown(frame(ahead, 0)))
    assert (
        np.abs(after - beats[-1]).max() < MOTION.amplitude * 2.0 * np.pi * 3.0 * MOTION.longest_beat
    )


def test_a_diving_bird_glides():
    clock = Clock()
    flight = FlockMotion(clock)
    beats = []
    for tick in range(160):
        clock.now += STEP
        beats.append(flight.follow(shown(frame([heading(0.0, -0.8)], tick))).beat[0])
    assert (
        np.abs(np.array(beats) - MOTION.dihedral).max() <= MOTION.gliding * MOTION.amplitude + 1e-9
    )


def test_rows_that_come_and_go_leave_the_others_as_they_were():
    clock = Clock()
    flight = FlockMotion(clock)
    for tick in range(100):
        clock.now += STEP
        ahead = [heading(0.1 * tick), heading(-0.05 * tick), heading(1.0)]
        before = flight.follow(shown(frame(ahead, tick)))
    clock.now += STEP
    less = frame([ahead[2], ahead[0], heading(2.0)], 99, ids=np.array([3, 1, 9]))
    after = flight.follow(shown(less))
    for row, old in ((0, 2), (1, 0)):
        assert after.wxyz[row] == pytest.approx(before.wxyz[old], abs=1e-6)
        assert after.beat[row] == before.beat[old]
    assert bank(after.wxyz[2]) == pytest.approx(0.0, abs=1e-6)


def test_a_new_run_begins_level():
    clock = Clock()
    flight = FlockMotion(clock)
    circling(flight, clock, 1.0, frames=50)
    clock.now += STEP
    poses = flight.follow(shown(frame([heading(2.0)], 51, run=2)))
    assert bank(poses.wxyz[0]) == pytest.approx(0.0, abs=1e-6)
