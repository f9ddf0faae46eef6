"""Swarms of prey: their velocities against a naive version, with a predator, and at rest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import prey_swarm as oracle
from oracles.close_up import close_up
from oracles.flocks import in_open_space

from agents import Flock
from agents.engine.cache import compile_to_disk
from agents.kinds import Kind, chase, flee
from agents.rules import prey_swarm as rule
from agents.spec import Spec

SETTINGS = settings(max_examples=40, deadline=None, derandomize=True)
FAR = 1000.0


@compile_to_disk
def explain(me, near, surroundings, p, out):
    rule.explain(me, near, surroundings, p, out)


@compile_to_disk
def weigh(me, near, p, out):
    rule.weigh(me, near, p, out)


def hunted(n, b, c, p, start=None, **words):
    """Prey with a predator in their middle."""
    predator = Kind(
        "predator", 1, start=[[1.0, 1.0]] * 2, to={"flock": chase(c / n, FAR, power=p - 1.0)}
    )
    to = {"predator": flee(b, FAR, power=1.0)}
    spec = Spec("prey-swarm", seed=1, size=2.0, dim=2, world="open", kinds=[predator], to=to)
    return Flock(spec.but(agents=n if start is None else None).taking(**words), start=start)


@SETTINGS
@given(
    seed=st.integers(0, 999),
    n=st.integers(1, 12),
    r=st.sampled_from((1.0, 2.0, 1000.0)),
    a=st.sampled_from((0.0, 1.0, 3.5)),
)
def test_two_ticks_are_those_of_the_paper(seed, n, r, a):
    x = np.random.default_rng(seed).uniform(0, 3, (n, 2))
    flock = in_open_space("prey-swarm", x, np.zeros((n, 2)), r=r, a=a, dt=0.005)
    for _ in range(2):
        x = x + 0.005 * oracle.prey_velocities(x, None, a, 0.0, r)
        flock.run(1)
        np.testing.assert_allclose(flock.position, x, rtol=0, atol=1e-12)


@SETTINGS
@given(seed=st.integers(0, 999), n=st.integers(1, 12), p=st.sampled_from((2.0, 2.5, 3.0, 4.0)))
def test_with_a_predator_they_are_the_papers_too(seed, n, p):
    rng = np.random.default_rng(seed)
    x, z = rng.uniform(0, 3, (n, 2)), rng.uniform(0, 3, 2)
    start = {"position": np.vstack([x, z]), "heading": np.tile([1.0, 0.0], (n + 1, 1))}
    flock = hunted(n, 0.3, 0.4, p, start, a=1.5, dt=0.001)
    for _ in range(2):
        x, z = oracle.step(x, z, 0.001, 1.5, 0.3, 0.4, p)
        flock.run(1)
        np.testing.assert_allclose(flock.position, np.vstack([x, z]), rtol=1e-11, atol=1e-11)


def test_the_velocities_and_weights_shown_are_the_papers():
    x = np.random.default_rng(2).uniform(0, 3, (8, 2))
    flock = in_open_space("prey-swarm", x, np.zeros((8, 2)), r=2.0, a=1.5)
    pushed = oracle.prey_velocities(x, None, 0.0, 0.0, 2.0)
    both = oracle.prey_velocities(x, None, 1.5, 0.0, 2.0)
    for row in range(8):
        me, around = close_up(flock, row)
        shown, weights = np.empty((2, 3)), np.empty(8)
        explain(me, around, flock.engine.surroundings, flock.context.parameters, shown)
        weigh(me, around, flock.context.parameters, weights)
        np.testing.assert_allclose(shown[0, :2], pushed[row], atol=1e-13)
        np.testing.assert_allclose(shown.sum(axis=0)[:2], both[row], atol=1e-13)
        d = np.linalg.norm(np.column_stack([around.x, around.y])[:8] - x[row], axis=1)
        size = np.zeros(8)
        near = (d > 0.0) & (d <= 2.0)
        size[near] = np.abs(1.0 / d[near] - 1.5 * d[near])
        np.testing.assert_allclose(weights, size / (1.0 + size), atol=1e-13)


def test_two_rest_where_push_and_pull_are_equal():
    """At the distance 1 / sqrt(a), to which others come by exp(-2 a t / N)."""
    flock = in_open_space("prey-swarm", [[0.0, 0.0], [3.0, 0.0]], np.zeros((2, 2)), a=4.0)
    flock.run(4000)
    assert np.ptp(flock.position[:, 0]) == pytest.approx(0.5, abs=1e-12)
    assert flock.position[:, 0].mean() == pytest.approx(1.5, abs=1e-12)


def test_a_predator_chases_one_alone_until_it_is_as_fast():
    """Beside one prey at distance d: d' = b / d - c / d^(p - 1)."""
    start = {"position": [[0.0, 0.0], [2.0, 0.0]], "heading": [[1.0, 0.0]] * 2}
    flock = hunted(1, 0.2, 0.6, 3.0, start, dt=0.001)
    flock.run(1)
    np.testing.assert_allclose(flock.speed, [0.2 / 2.0, 0.6 / 4.0], rtol=1e-12)


@pytest.mark.parametrize("n", [100, 300])
def test_the_ring_at_rest_has_the_mean_square_radius_that_it_must(n):
    """What is off goes with the square of the speed that shells of prey still slip at."""
    flock = hunted(n, 0.2, 0.4, 3.0)
    flock.run(6000)
    x = flock.position[flock.rows_of("flock")]
    square = ((x - x.mean(axis=0)) ** 2).sum(axis=1).mean()
    assert square == pytest.approx(oracle.mean_square_at_rest(n, 1.0, 0.2), rel=2e-5)
    assert flock.speed.max() < 0.01


def test_a_swarm_alone_fills_a_disc():
    flock = Flock("prey-swarm", agents=200, rng=1, a=2.0)
    flock.run(6000)
    x = flock.position
    r2 = ((x - x.mean(axis=0)) ** 2).sum(axis=1)
    assert r2.mean() == pytest.approx(oracle.mean_square_at_rest(200, 2.0, 0.0), rel=1e-7)
    assert np.sqrt(2.0 * r2.max()) == pytest.approx(1.0, abs=0.06)


def test_those_in_one_spot_are_thrown_apart_to_places_that_are_numbers():
    start = {"position": [[0.0, 0.0], [0.0, 0.0], [1e-12, 0.0]], "heading": [[1.0, 0.0]] * 3}
    flock = Flock("prey-swarm", world="open", size=2.0, start=start, rng=1)
    flock.run(5)
    assert np.isfinite(flock.position).all()
