"""Angular momentum: exact cases, invariants, and a naive version."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents import Flock
from agents.observables.order import angular_momentum, centre

OPEN2, OPEN3 = np.zeros(2, bool), np.zeros(3, bool)


def mill(n, centre_at=(0.0, 0.0), radius=2.0):
    angle = math.tau * np.arange(n) / n
    position = np.array(centre_at) + radius * np.c_[np.cos(angle), np.sin(angle)]
    return position, np.c_[-np.sin(angle), np.cos(angle)]


def test_a_mill_has_one_and_a_parallel_ring_none():
    position, heading = mill(12)
    assert angular_momentum(position, heading, np.ones(2), OPEN2) == pytest.approx(1.0)
    assert angular_momentum(position, -heading, np.ones(2), OPEN2) == pytest.approx(1.0)
    east = np.tile([1.0, 0.0], (12, 1))
    assert angular_momentum(position, east, np.ones(2), OPEN2) == pytest.approx(0.0, abs=1e-12)


def test_a_mill_across_the_seam_is_the_same_mill():
    size = np.array([20.0, 30.0])
    position, heading = mill(15, centre_at=(0.3, 29.6))
    wrapped = position % size
    images = np.ones(2, bool)
    np.testing.assert_allclose(centre(wrapped, size, images), [0.3, 29.6], atol=1e-9)
    assert angular_momentum(wrapped, heading, size, images) == pytest.approx(1.0)


def test_a_mill_in_space_has_its_axis_anywhere():
    position, heading = mill(10)
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    p3, u3 = np.c_[position, np.zeros(10)] @ turn.T, np.c_[heading, np.zeros(10)] @ turn.T
    assert angular_momentum(p3, u3, np.ones(3), OPEN3) == pytest.approx(1.0)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 30), dim=st.sampled_from((2, 3)))
def test_it_is_the_naive_sum_and_does_not_depend_on_where_the_flock_is(seed, n, dim):
    rng = np.random.default_rng(seed)
    position, heading = rng.normal(size=(n, dim)), rng.normal(size=(n, dim))
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    total = np.zeros(3)
    for x, u in zip(position - position.mean(axis=0), heading, strict=True):
        if np.linalg.norm(x) > 0.0:
            r, v = np.zeros(3), np.zeros(3)
            r[:dim], v[:dim] = x / np.linalg.norm(x), u
            total += np.cross(r, v)
    images, size = np.zeros(dim, bool), np.ones(dim)
    found = angular_momentum(position, heading, size, images)
    assert 0.0 <= found <= 1.0 + 1e-12
    if n > 1:
        assert found == pytest.approx(np.linalg.norm(total) / n, abs=1e-9)
        moved = angular_momentum(position + 7.0, heading, size, images)
        assert moved == pytest.approx(found, abs=1e-9)


def test_a_flock_observes_it():
    position, heading = mill(20, centre_at=(5.0, 5.0))
    flock = Flock("vem", start={"position": position, "heading": heading}, size=10.0, rng=1)
    assert flock.observe("angular-momentum") == pytest.approx(1.0)
