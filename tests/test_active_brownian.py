"""Active Brownian particles: forces against a naive version, the free one's closed form, noise."""

import math

import numpy as np
import pytest
import scipy  # its parts are imported when they are asked for
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import active_brownian as oracle
from oracles.close_up import close_up
from oracles.scenes import unit_vectors

from agents import Flock
from agents.engine.cache import compile_to_disk
from agents.rules import active_brownian as rule
from worlds.world import World

SETTINGS = settings(max_examples=60, deadline=None, derandomize=True)


@compile_to_disk
def explain(me, near, surroundings, p, out):
    rule.explain(me, near, surroundings, p, out)


@compile_to_disk
def weigh(me, near, p, out):
    rule.weigh(me, near, p, out)


def flock_of(position, heading, **given):
    """Particles in open space."""
    dim = np.shape(position)[1]
    start = {"position": position, "heading": heading}
    space = World("space", (9.0,) * dim, ("open",) * dim)
    return Flock("active-brownian", start=start, world=space, **given)


def free(dim, n, **given):
    """Particles that do not feel each other, far apart, with random headings."""
    rng = np.random.default_rng(1)
    place = rng.uniform(1.0, 2000.0, (n, dim))
    return flock_of(place, unit_vectors(rng, n, dim), mu=0.0, d=0.05, **{"seed": 5, **given})


@SETTINGS
@given(
    seed=st.integers(0, 999),
    n=st.integers(1, 14),
    dim=st.sampled_from((2, 3)),
    d=st.sampled_from((0.5, 1.0, 2.0)),
    mu=st.sampled_from((0.0, 0.7)),
)
def test_without_noise_two_ticks_are_those_of_the_paper(seed, n, dim, d, mu):
    rng = np.random.default_rng(seed)
    x, u = rng.uniform(0, 3, (n, dim)), unit_vectors(rng, n, dim)
    flock = flock_of(x, u, d=d, mu=mu, k=9.0, v0=0.8, D_r=0.0, D_t=0.0, dt=0.03)
    for _ in range(2):
        v = oracle.velocities(x, u, flock.parameters)
        x = x + 0.03 * v
        flock.run(1)
        np.testing.assert_allclose(flock.position, x, rtol=0, atol=1e-12)
        np.testing.assert_allclose(flock.speed, np.linalg.norm(v, axis=1), rtol=0, atol=1e-12)
        np.testing.assert_allclose(flock.heading, u, atol=1e-15)


def test_the_velocities_and_overlaps_shown_are_the_papers():
    rng = np.random.default_rng(2)
    flock = flock_of(rng.uniform(0, 2, (9, 3)), unit_vectors(rng, 9, 3))
    x, p = flock.position, flock.parameters
    expected = oracle.velocities(x, flock.heading, p)
    for row in range(9):
        me, around = close_up(flock, row)
        shown, weights = np.empty((2, 3)), np.empty(9)
        explain(me, around, flock.engine.surroundings, flock.context.parameters, shown)
        weigh(me, around, flock.context.parameters, weights)
        np.testing.assert_allclose(shown[0], p.v0 * flock.heading[row], atol=1e-15)
        np.testing.assert_allclose(shown.sum(axis=0), expected[row], atol=1e-12)
        r = np.linalg.norm(np.column_stack([around.x, around.y, around.z])[:9] - x[row], axis=1)
        np.testing.assert_allclose(weights, np.where((r > 0) & (r < 1), 1 - r, 0.0), atol=1e-14)


def test_two_that_overlap_part_by_the_exponential():
    """Without drive d - r falls by 1 - 2 mu k dt each tick."""
    flock = flock_of([[0.0, 0.0], [0.6, 0.0]], np.eye(2), v0=0.0, k=3.0, D_r=0.0, dt=0.01)
    flock.run(50)
    apart = flock.position[1, 0] - flock.position[0, 0]
    assert 1.0 - apart == pytest.approx(0.4 * (1.0 - 2.0 * 3.0 * 0.01) ** 50, rel=1e-12)


def test_two_that_push_head_on_come_to_a_stand_where_push_is_drive():
    flock = flock_of([[0.0, 0.0], [2.0, 0.0]], [[1.0, 0.0], [-1.0, 0.0]], D_r=0.0, k=10.0)
    flock.run(2000)
    apart = flock.position[1, 0] - flock.position[0, 0]
    assert apart == pytest.approx(1.0 - 1.0 / 10.0, abs=1e-9)
    assert flock.speed.max() < 1e-9


@pytest.mark.parametrize("dim", [2, 3])
def test_the_heading_is_forgotten_by_the_exponential(dim):
    """<u(t) . u(0)> = exp(-(dim - 1) D_r t), to the order of the step in space."""
    flock = free(dim, 5000, D_r=0.5, dt=0.02)
    first = flock.heading.copy()
    for t in (1.0, 2.0, 3.0):
        flock.run(50)
        along = (first * flock.heading).sum(axis=1)
        assert along.mean() == pytest.approx(math.exp(-(dim - 1) * 0.5 * t), abs=0.04)
    assert np.linalg.norm(flock.heading.mean(axis=0)) < 0.06


def test_the_angle_in_the_plane_is_normal():
    flock = free(2, 4000, D_r=0.3, dt=0.04)
    first = flock.heading.copy()
    flock.run(1)
    cross = first[:, 0] * flock.heading[:, 1] - first[:, 1] * flock.heading[:, 0]
    angle = np.arctan2(cross, (first * flock.heading).sum(axis=1))
    assert scipy.stats.kstest(angle / math.sqrt(2.0 * 0.3 * 0.04), "norm").pvalue > 0.01


@pytest.mark.parametrize("dim", [2, 3])
def test_a_free_particle_goes_from_ballistic_to_diffusive_by_the_closed_form(dim):
    flock = free(dim, 5000, D_r=1.0, D_t=0.05, v0=2.0, dt=0.01)
    first = flock.position.copy()
    for ticks in (10, 90, 400):
        flock.run(ticks)
        found = ((flock.position - first) ** 2).sum(axis=1).mean()
        expected = oracle.squared_displacement(flock.elapsed, dim, 2.0, 1.0, 0.05)
        assert found == pytest.approx(expected, rel=0.08)


def test_without_drive_kicks_diffuse_in_every_direction():
    flock = free(3, 5000, v0=0.0, D_t=0.2, D_r=0.0, dt=0.05)
    first = flock.position.copy()
    flock.run(40)
    for axis in range(3):
        moved = flock.position[:, axis] - first[:, axis]
        assert scipy.stats.kstest(moved / math.sqrt(0.8), "norm").pvalue > 0.01


def test_noise_is_the_runs_own():
    one, two, three = (free(2, 50, D_t=0.1, seed=seed) for seed in (5, 5, 6))
    for flock in (one, two, three):
        flock.run(5)
    assert np.array_equal(one.position, two.position)
    assert (np.abs(one.position - three.position) > 1e-9).all()


def test_crowded_particles_slow_down():
    """The velocity along the heading: 1 where there is room, and less the less there is."""
    along = []
    for size in (40.0, 20.0, 15.0):
        flock = Flock("active-brownian", agents=200, size=size, world="wrap", rng=1, D_r=0.5)
        flock.run(600)
        seen = []
        for _ in range(10):
            flock.run(49)
            before, heading = flock.position.copy(), flock.heading.copy()
            flock.run(1)
            step = flock.position - before
            step -= size * np.round(step / size)
            seen.append((step * heading).sum(axis=1).mean() / flock.dt)
        along.append(np.mean(seen))
    assert along[0] == pytest.approx(1.0 - 200 * math.pi / 4 / 1600, abs=0.06)
    assert 1.0 > along[0] > along[1] + 0.1 > along[2] + 0.2
