"""The correlation length of velocity fluctuations: exact cases, invariants, a naive version."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import order_over_groups as naive
from oracles.scenes import scenes
from oracles.topology import distances
from scipy.special import jn_zeros

from agents import Flock
from agents.observables.correlation import (
    BINS,
    LARGEST,
    bin_width,
    correlation,
    correlation_length,
)
from agents.run_records import follow

OPEN = np.zeros(2, bool)
WRAP = np.ones(2, bool)
SIZE = np.array([10.0, 10.0])


def test_two_agents_apart():
    """Their fluctuations are opposite: C(d) = -1, and the line from C(0) = 1 is 0 at d/2."""
    position, velocity = np.array([[1.0, 1.0], [1.0, 9.0]]), np.array([[1.0, 0.5], [1.0, -0.5]])
    far, across = (correlation(position, velocity, SIZE, images) for images in (OPEN, WRAP))
    assert far.distance.tolist() == [8.0]
    assert across.distance.tolist() == [2.0]
    assert far.value.tolist() == across.value.tolist() == [-1.0]
    assert far.pairs.tolist() == [1]
    assert correlation_length(position, velocity, SIZE, OPEN) == pytest.approx(4.0)
    assert correlation_length(position, velocity, SIZE, WRAP) == pytest.approx(1.0)


def test_four_agents_on_a_line_by_hand():
    """u = +, +, -, - at 0, 1, 2, 3: C(1) = 1/3, C(2) = -1, C(3) = -1; 0 at 1 + 1/4."""
    position = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    velocity = np.array([[1.0, 0.1], [1.0, 0.1], [1.0, -0.1], [1.0, -0.1]])
    found = correlation(position, velocity, SIZE, OPEN, width=0.7)
    assert found.distance == pytest.approx([1.0, 2.0, 3.0])
    assert found.value == pytest.approx([1.0 / 3.0, -1.0, -1.0])
    assert found.pairs.tolist() == [3, 2, 1]
    assert correlation_length(position, velocity, SIZE, OPEN, width=0.7) == pytest.approx(1.25)


@pytest.mark.parametrize(("dim", "waves"), [(2, 1), (2, 2), (3, 2)])
def test_a_wave_across_the_torus(dim, waves):
    """u = sin(k x): C(r) is J_0(k r) in the plane and sin(k r)/(k r) in space."""
    rng, side = np.random.default_rng(3), 10.0
    position = rng.uniform(0.0, side, (3000, dim))
    velocity = np.zeros((3000, dim))
    k = math.tau * waves / side
    velocity[:, 0], velocity[:, 1] = 1.0, 0.2 * np.sin(k * position[:, 0])
    size, images = np.full(dim, side), np.ones(dim, bool)
    expected = jn_zeros(0, 1)[0] / k if dim == 2 else math.pi / k
    found = correlation_length(position, velocity, size, images)
    assert found == pytest.approx(expected, rel=0.02)


def test_who_all_fly_alike_have_no_fluctuations():
    position = np.random.default_rng(1).uniform(0, 10, (50, 2))
    for velocity in (np.zeros((50, 2)), np.tile([0.3, 0.1], (50, 1))):
        assert correlation(position, velocity, SIZE, OPEN) is None
        assert math.isnan(correlation_length(position, velocity, SIZE, OPEN))
    angle = 0.7 + np.full(50, 1e-17)
    alike = np.c_[np.cos(angle), np.sin(angle)]
    assert math.isnan(correlation_length(position, alike, SIZE, OPEN))


@pytest.mark.parametrize("n", [0, 1])
def test_nobody_and_one_alone_have_none(n):
    assert math.isnan(correlation_length(np.zeros((n, 2)), np.ones((n, 2)), SIZE, WRAP))


def test_all_on_one_spot_are_correlated_over_no_distance():
    rng = np.random.default_rng(2)
    found = correlation_length(np.ones((20, 2)), rng.normal(size=(20, 2)), SIZE, OPEN)
    assert found == 0.0


def test_agents_at_random_are_correlated_over_less_than_their_spacing():
    rng = np.random.default_rng(4)
    position, velocity = rng.uniform(0, 10, (400, 2)), rng.normal(size=(400, 2))
    assert correlation_length(position, velocity, SIZE, WRAP) < 0.5


def test_of_a_large_flock_a_sample_is_taken_always_the_same():
    rng = np.random.default_rng(6)
    n = LARGEST + 2000
    position = rng.uniform(0, 10, (n, 2))
    velocity = np.c_[np.ones(n), np.sin(math.tau * position[:, 0] / 10.0)]
    found = correlation(position, velocity, SIZE, WRAP)
    assert found.pairs.sum() == LARGEST * (LARGEST - 1) // 2
    again = correlation(position, velocity, SIZE, WRAP)
    assert np.array_equal(found.value, again.value)
    expected = jn_zeros(0, 1)[0] / math.tau * 10.0
    assert correlation_length(position, velocity, SIZE, WRAP) == pytest.approx(expected, rel=0.02)


def test_a_bin_is_as_wide_as_neighbours_are_apart_and_there_are_never_too_many():
    lattice = np.stack(np.meshgrid(np.arange(5.0), np.arange(5.0)), axis=-1).reshape(-1, 2)
    assert bin_width(lattice, SIZE, OPEN) == pytest.approx(1.0)
    spots = np.repeat([[0.0, 0.0], [3.0, 4.0]], 10, axis=0)
    assert bin_width(spots, SIZE, OPEN) == pytest.approx(5.0 / BINS)
    assert bin_width(np.zeros((3, 2)), SIZE, OPEN) == 1.0


@settings(max_examples=100, deadline=None, derandomize=True)
@given(where=scenes(most=40), seed=st.integers(0, 999))
def test_it_is_the_naive_sum_over_pairs(where, seed):
    n, dim = len(where.position), where.dim
    velocity = np.random.default_rng(seed).normal(size=(n, dim))
    images = np.full(dim, where.edges == "wrap")
    width = 0.31 * where.r
    apart = distances(where.position, where.size, where.edges)[np.triu_indices(n, 1)] / width
    assume(n > 1 and apart.max() < BINS)
    assume(np.abs(apart - np.round(apart))[apart > 0].min(initial=1.0) > 1e-9)
    distance, value, pairs = naive.correlation(
        where.position, velocity, where.size, where.edges, width
    )
    found = correlation(where.position, velocity, where.size, images, width)
    assert found.pairs.tolist() == pairs
    assert found.distance == pytest.approx(distance, abs=1e-9)
    assert found.value == pytest.approx(value, abs=1e-9)
    xi = correlation_length(where.position, velocity, where.size, images, width)
    assert xi == pytest.approx(naive.first_zero(distance, value), abs=1e-6)
    # fluctuations add up to nothing
    assert (found.value * found.pairs).sum() == pytest.approx(-n / 2.0, abs=1e-6)
    # how fast all fly together, and by how much they differ, does not matter
    drifting = correlation(where.position, 3.0 * velocity + 5.0, where.size, images, width)
    assert drifting.value == pytest.approx(found.value, abs=1e-9)


def test_a_flock_observes_it_with_its_speeds():
    position = np.array([[1.0, 1.0], [1.0, 4.0]])
    start = {"position": position, "heading": np.array([[1.0, 0.0], [0.0, 1.0]])}
    flock = Flock("vem", start=start, size=10.0, rng=1)
    assert flock.observe("correlation-length") == pytest.approx(1.5)
    alike = {"position": position, "heading": np.array([[1.0, 0.0], [1.0, 0.0]])}
    flock = Flock("vem", start=alike, size=10.0, rng=1)
    assert math.isnan(flock.observe("correlation-length"))
    flock.speed[:] = 1.0, 2.0
    assert flock.observe("correlation-length") == pytest.approx(1.5)


def test_in_an_ordered_flock_it_grows_with_the_flock():
    """Scale-free: four times the agents in a torus of twice the side, about twice the length."""
    mean = []
    for n in (400, 1600):
        flock = Flock("vem", agents=n, rng=1, eta=1.0)
        flock.run(1000)
        series = follow(flock, 2000, ["correlation-length"], every=100)
        mean.append(series.values["correlation-length"].mean())
    assert 1.4 < mean[1] / mean[0] < 3.0
