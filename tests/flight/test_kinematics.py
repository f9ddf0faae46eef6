"""How the wings are driven: (2.1), (2.2) and their derivatives."""

import math

import numpy as np
import pytest

from agents.flight.air_forces import Flapping, swing


def test_quarters_of_a_beat_are_exact():
    made = Flapping(0.3, twist=0.2, frequency=2.0)
    at = np.array([0.0, 0.125, 0.25, 0.375])
    omega = 4.0 * math.pi
    flap, tip = made.flap(at), made.tip_twist(at)
    assert flap.angle == pytest.approx([0.0, 0.3, 0.0, -0.3], abs=1e-15)
    assert flap.rate == pytest.approx([0.3 * omega, 0.0, -0.3 * omega, 0.0], abs=1e-14)
    assert flap.acceleration == pytest.approx(-(omega**2) * flap.angle, abs=1e-13)
    assert tip.angle == pytest.approx([0.2, 0.0, -0.2, 0.0], abs=1e-15)
    assert tip.rate == pytest.approx([0.0, -0.2 * omega, 0.0, 0.2 * omega], abs=1e-14)


def test_the_nose_is_down_while_the_wing_goes_down():
    made = Flapping(0.3)
    flap, tip = made.flap(0.5 * made.period), made.tip_twist(0.5 * made.period)
    assert flap.rate < 0.0
    assert tip.angle == pytest.approx(-made.twist)


def test_frequencies_and_phases_are_apart():
    made = Flapping(0.3, 0.2, frequency=1.0, twist_frequency=3.0, phase=0.4, twist_phase=-0.7)
    assert made.flap(0.1).angle == pytest.approx(0.3 * math.sin(0.2 * math.pi + 0.4))
    assert made.tip_twist(0.1).angle == pytest.approx(0.2 * math.sin(0.6 * math.pi - 0.7))


@pytest.mark.parametrize("time", [0.0, 0.13, 0.5, 1.7])
def test_the_derivatives_are_those_of_the_angle(time):
    h = 1e-5
    before, at, after = (swing(0.4, 1.5, 0.3, time + k * h) for k in (-1, 0, 1))
    assert at.rate == pytest.approx((after.angle - before.angle) / (2 * h), abs=1e-7)
    assert at.acceleration == pytest.approx((after.rate - before.rate) / (2 * h), abs=1e-6)


def test_an_array_of_amplitudes_flies_several_copies():
    made = Flapping(np.array([0.1, 0.2])).flap(0.1)
    assert made.angle[1] == pytest.approx(2.0 * made.angle[0])
    assert made.acceleration.shape == (2,)
