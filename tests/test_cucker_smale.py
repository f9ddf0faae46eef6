"""Cucker-Smale flocking: its sums against a naive version, its exact cases, its bound."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import cucker_smale as oracle
from oracles.close_up import close_up
from oracles.flocks import in_open_space, velocity_of
from oracles.scenes import unit_vectors
from scipy.integrate import quad

from agents import Flock
from agents.engine.cache import compile_to_disk
from agents.observables.order import velocity_spread
from agents.rules import cucker_smale as rule

SETTINGS = settings(max_examples=60, deadline=None, derandomize=True)


@compile_to_disk
def explain(me, near, surroundings, p, out):
    rule.explain(me, near, surroundings, p, out)


@compile_to_disk
def weigh(me, near, p, out):
    rule.weigh(me, near, p, out)


def flock_of(position, velocity, **given):
    return in_open_space("cucker-smale", position, velocity, **given)


@SETTINGS
@given(
    seed=st.integers(0, 999),
    n=st.integers(1, 12),
    dim=st.sampled_from((2, 3)),
    r=st.sampled_from((2.0, 4.0, 1000.0)),
    beta=st.sampled_from((0.0, 0.3, 0.5, 1.7)),
    sigma=st.sampled_from((0.1, 1.0, 3.0)),
)
def test_two_ticks_are_those_of_the_paper(seed, n, dim, r, beta, sigma):
    rng = np.random.default_rng(seed)
    x, v = rng.uniform(0, 6, (n, dim)), rng.normal(size=(n, dim))
    flock = flock_of(x, v, r=r, beta=beta, sigma=sigma, K=0.7, m=1.6, dt=0.05)
    for _ in range(2):
        x, v = oracle.step(x, v, flock.parameters)
        flock.run(1)
        np.testing.assert_allclose(flock.position, x, rtol=0, atol=1e-12)
        np.testing.assert_allclose(velocity_of(flock), v, rtol=0, atol=1e-12)


def test_the_acceleration_and_the_weights_shown_are_the_papers():
    rng = np.random.default_rng(2)
    flock = flock_of(rng.uniform(0, 6, (8, 3)), rng.normal(size=(8, 3)), r=4.0, sigma=2.0)
    x, p = flock.position, flock.parameters
    u = oracle.accelerations(x, velocity_of(flock), p)
    for row in range(8):
        me, around = close_up(flock, row)
        shown, weights = np.empty((1, 3)), np.empty(8)
        explain(me, around, flock.engine.surroundings, flock.context.parameters, shown)
        weigh(me, around, flock.context.parameters, weights)
        np.testing.assert_allclose(shown[0], u[row], atol=1e-13)
        d = np.linalg.norm(np.column_stack([around.x, around.y, around.z])[:8] - x[row], axis=1)
        a = np.where((d > 0.0) & (d <= 4.0), (4.0 / (4.0 + d**2)) ** p.beta, 0.0)
        np.testing.assert_allclose(weights, a, atol=1e-14)


def test_the_mean_velocity_stays_and_differences_fall():
    rng = np.random.default_rng(3)
    flock = flock_of(rng.uniform(0, 9, (40, 2)), rng.normal([3.0, 1.0], size=(40, 2)))
    before, spread = velocity_of(flock).mean(axis=0), []
    for _ in range(50):
        spread.append(velocity_spread(velocity_of(flock)))
        flock.run(8)
    assert (np.diff(spread) < 0.0).all()
    assert spread[-1] < 0.1 * spread[0]
    np.testing.assert_allclose(velocity_of(flock).mean(axis=0), before, atol=1e-13)


def test_where_distance_makes_no_difference_velocities_converge_by_the_exponential():
    """beta = 0: v_i - <v> falls by 1 - h N K each tick, whatever the places."""
    rng = np.random.default_rng(4)
    flock = flock_of(rng.uniform(0, 9, (20, 2)), rng.normal(size=(20, 2)), beta=0.0, K=0.1, dt=0.01)
    before = velocity_of(flock) - velocity_of(flock).mean(axis=0)
    flock.run(30)
    after = velocity_of(flock) - velocity_of(flock).mean(axis=0)
    np.testing.assert_allclose(after, before * (1.0 - 0.01 * 20 * 0.1) ** 30, atol=1e-13)


def apart(speed, beta, ticks, x0=1.0, dt=0.01):
    """Two agents that fly apart, each at a speed: their distance and relative speed over time."""
    start = [[4.0, 4.0], [4.0 + x0, 4.0]]
    flock = flock_of(
        start, [[-speed, 0.0], [speed, 0.0]], K=1.0, sigma=1.0, beta=beta, r=1e6, dt=dt
    )
    x, v = [x0], [2.0 * speed]
    for _ in range(ticks):
        flock.run(100)
        x.append(flock.position[1, 0] - flock.position[0, 0])
        v.append(velocity_of(flock)[1, 0] - velocity_of(flock)[0, 0])
    return np.array(x), np.array(v)


def test_of_two_that_fly_apart_speed_is_lost_to_the_integral_of_the_weight():
    """v + 2 K atan(x / sigma) / sigma stays for beta = 1, to the order of dt."""
    off = []
    for dt in (0.02, 0.01):
        x, v = apart(0.7, 1.0, 60, dt=dt)
        kept = v + 2.0 * np.arctan(x)
        off.append(np.abs(kept - kept[0]).max())
    assert off[1] < 0.01
    assert off[1] / off[0] == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize("beta", [0.75, 1.0, 2.0])
def test_above_one_half_the_critical_speed_decides(beta):
    """2 v = 2 K times the integral of the weight from where they are to infinity."""
    critical = quad(lambda x: (1.0 + x * x) ** -beta, 1.0, math.inf)[0]
    _, below = apart(0.7 * critical, beta, 600, dt=0.005)
    x, above = apart(1.3 * critical, beta, 600, dt=0.005)
    assert below[-1] < 0.02 * below[0]
    assert above[-1] == pytest.approx(2.0 * 0.3 * critical, rel=0.3)
    assert above[-1] > 2.0 * 0.3 * critical * 0.98
    assert np.diff(x).min() > 0.0


def test_below_one_half_a_speed_that_would_be_far_too_much_is_lost():
    _, v = apart(3.0, 0.3, 400, dt=0.02)
    assert v[-1] < 0.01 * v[0]


def test_an_agent_that_nobody_hears_goes_straight():
    flock = flock_of([[0.0, 0.0], [5.0, 0.0]], [[1.0, 1.0], [0.0, -1.0]], r=4.0)
    flock.run(10)
    np.testing.assert_allclose(velocity_of(flock), [[1.0, 1.0], [0.0, -1.0]], atol=1e-15)


def test_turned_agents_do_the_same_turned():
    rng = np.random.default_rng(6)
    x, v = rng.uniform(0, 6, (9, 3)), unit_vectors(rng, 9, 3)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    one, other = flock_of(x, v), flock_of(x @ turn.T, v @ turn.T)
    one.run(20)
    other.run(20)
    np.testing.assert_allclose(other.position, one.position @ turn.T, atol=1e-11)


def test_agents_set_off_at_random_speeds():
    """Velocities uniform in the disc: the mean square speed is half of the largest, squared."""
    flock = Flock("cucker-smale", agents=4000, rng=1, v_start=3.0)
    assert flock.speed.max() <= 3.0
    assert (flock.speed**2).mean() == pytest.approx(4.5, rel=0.05)
    assert not Flock("cucker-smale", agents=5, rng=1, v_start=0.0).speed.any()
