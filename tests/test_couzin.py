"""Couzin's zones against their oracle, exact cases and the phases that they are known for."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import couzin

from agents import Flock
from agents.individuals import uniform

OPEN = {"world": "open", "size": 10.0, "rng": 1}


def start(seed, n, dim, spread):
    rng = np.random.default_rng(seed)
    heading = rng.normal(size=(n, dim))
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    return {"position": rng.uniform(0.0, spread, (n, dim)), "heading": heading}


def clear(position, heading, p):
    """Whether no decision hangs on the last bits of a number."""
    gap = position[None] - position[:, None]
    d = np.linalg.norm(gap, axis=2) + 0.123 * np.eye(len(position))
    for edge in (p.r_r, p.r_r + p.dr_o, p.r_r + p.dr_o + p.dr_a):
        if np.abs(d - edge).min() < 1e-7:
            return False
    cosine = (gap * heading[:, None]).sum(axis=2) / d
    off = np.abs(cosine - math.cos(math.radians(p.alpha / 2))) + np.eye(len(d))
    wishes = [couzin.wanted(i, position, heading, p) for i in range(len(position))]
    straight = [
        w is None or (math.sqrt(w @ w) > 1e-3 and w @ u / math.sqrt(w @ w) > -0.99999)
        for w, u in zip(wishes, heading, strict=True)
    ]
    return bool((off > 1e-7).all()) and all(straight)


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 20),
    dim=st.sampled_from((2, 3)),
    spread=st.sampled_from((2.0, 8.0, 25.0)),
    alpha=st.sampled_from((90.0, 200.0, 270.0, 359.0)),
)
def test_every_tick_is_the_papers(seed, n, dim, spread, alpha):
    p = couzin.Zones(alpha=alpha, dr_o=2.0, dr_a=7.0)
    flock = Flock(
        "couzin",
        start=start(seed, n, dim, spread),
        dim=dim,
        alpha=alpha,
        dr_o=2.0,
        dr_a=7.0,
        sigma=0.0,
        **OPEN,
    )
    for _ in range(5):
        assume(n == 1 or clear(flock.position, flock.heading, p))
        position, heading = couzin.step(flock.position.copy(), flock.heading.copy(), p)
        flock.run(1)
        np.testing.assert_allclose(flock.heading, heading, atol=1e-9)
        np.testing.assert_allclose(flock.position, position, atol=1e-9)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), dim=st.sampled_from((2, 3)))
def test_agents_that_differ_act_each_by_its_own_numbers(seed, dim):
    spread = {"r_r": uniform(0.5, 1.5), "s": uniform(2.0, 4.0), "theta": uniform(20.0, 60.0)}
    flock = Flock("couzin", start=start(seed, 12, dim, 8.0), dim=dim, sigma=0.0, **OPEN, **spread)
    zones = [
        couzin.Zones(**{name: float(flock.own[name][k]) for name in spread}) for k in range(12)
    ]
    for _ in range(5):
        assume(all(clear(flock.position, flock.heading, p) for p in zones))
        position, heading = couzin.step_of_each(flock.position.copy(), flock.heading.copy(), zones)
        flock.run(1)
        np.testing.assert_allclose(flock.heading, heading, atol=1e-9)
        np.testing.assert_allclose(flock.position, position, atol=1e-9)


def pair(gap, **given):
    """Two agents side by side, both heading for +x."""
    begin = {"position": [[0.0, 0.0], [0.0, gap]], "heading": [[1.0, 0.0], [1.0, 0.0]]}
    return Flock("couzin", start=begin, sigma=0.0, dim=2, **OPEN, **given)


def test_two_that_are_too_near_turn_apart_by_the_turning_rate():
    flock = pair(0.5)
    flock.run(1)
    angle = math.radians(4.0)
    np.testing.assert_allclose(flock.heading[0], [math.cos(angle), -math.sin(angle)], atol=1e-12)
    np.testing.assert_allclose(flock.heading[1], [math.cos(angle), math.sin(angle)], atol=1e-12)


def test_two_in_the_zone_of_attraction_turn_to_each_other():
    flock = pair(6.0)
    flock.run(1)
    assert flock.heading[0, 1] > 0.0 > flock.heading[1, 1]
    assert flock.heading[0, 1] == pytest.approx(math.sin(math.radians(4.0)))


def test_one_behind_is_not_seen():
    begin = {"position": [[0.0, 0.0], [-6.0, 0.5]], "heading": [[1.0, 0.0], [0.0, 1.0]]}
    flock = Flock("couzin", start=begin, sigma=0.0, dim=2, **OPEN)
    flock.run(1)
    np.testing.assert_allclose(flock.heading[0], [1.0, 0.0], atol=1e-12)
    assert flock.heading[1, 0] > 0.0


@pytest.mark.parametrize("dim", [2, 3])
def test_the_error_of_movement_has_its_standard_deviation(dim):
    n = 4000
    begin = start(5, n, dim, 1e6)
    flock = Flock("couzin", start=begin, dim=dim, sigma=0.05, theta=1800.0, **OPEN)
    before = flock.heading.copy()
    flock.run(1)
    turned = np.arccos(np.clip((flock.heading * before).sum(axis=1), -1.0, 1.0))
    assert np.sqrt((turned**2).mean()) == pytest.approx(0.05, rel=0.06)


def test_a_wide_zone_of_orientation_makes_the_group_parallel_and_none_a_swarm():
    """The ends of the sweep of figure 3 of the paper, in three dimensions."""
    swarm, parallel = (
        Flock("couzin", agents=100, dim=3, world="open", size=6.0, rng=7, dr_o=dr_o, dr_a=14.0)
        for dr_o in (0.0, 12.0)
    )
    for flock in (swarm, parallel):
        flock.run(3000)
    assert swarm.observe("polarisation") < 0.4
    assert parallel.observe("polarisation") > 0.9
    assert swarm.observe("nearest-neighbour") > 0.3
