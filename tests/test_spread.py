"""Gyration radius and velocity spread: exact cases, and what makes no difference to them."""

import numpy as np
import pytest

from agents import Flock
from agents.observables.order import gyration_radius, velocity_spread

OPEN, WRAPS = np.zeros(2, bool), np.ones(2, bool)


def test_a_ring_has_its_radius_and_so_has_one_across_the_seam():
    turn = 2.0 * np.pi * np.arange(12) / 12
    ring = 1.5 * np.column_stack([np.cos(turn), np.sin(turn)])
    assert gyration_radius(ring + 7.0, np.ones(2), OPEN) == pytest.approx(1.5, abs=1e-14)
    size = np.array([10.0, 10.0])
    assert gyration_radius((ring + 9.5) % 10.0, size, WRAPS) == pytest.approx(1.5, abs=1e-13)
    assert gyration_radius((ring + 9.5) % 10.0, size, OPEN) > 4.0


def test_a_common_velocity_makes_no_difference():
    v = np.array([[3.0, 4.0], [-3.0, -4.0], [0.0, 5.0], [0.0, -5.0]])
    assert velocity_spread(v) == pytest.approx(5.0, abs=1e-15)
    assert velocity_spread(v + np.array([100.0, -20.0])) == pytest.approx(5.0, abs=1e-13)
    assert velocity_spread(np.tile([3.0, 4.0], (9, 1))) == 0.0


def test_noisy_ones_come_near_what_they_were_drawn_with():
    rng = np.random.default_rng(5)
    drawn = rng.normal(0.0, 2.0, (20_000, 3))
    assert velocity_spread(drawn) == pytest.approx(2.0 * np.sqrt(3.0), rel=0.02)
    box = np.ones(3), np.zeros(3, bool)
    assert gyration_radius(drawn, *box) == pytest.approx(2.0 * np.sqrt(3.0), rel=0.02)


def test_a_flock_has_them_by_name():
    start = {
        "position": [[0.0, 0.0], [6.0, 8.0]],
        "heading": [[1.0, 0.0], [0.0, 1.0]],
        "speed": [2.0, 2.0],
    }
    flock = Flock("cucker-smale", start=start, world="open", size=10.0, interpret=True)
    assert flock.observe("gyration-radius") == pytest.approx(5.0, abs=1e-14)
    assert flock.observe("velocity-spread") == pytest.approx(np.sqrt(2.0), abs=1e-14)
