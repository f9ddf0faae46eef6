"""Informed groups of Couzin et al. 2005 against their oracle, and in exact cases."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import leadership as oracle

from agents import Flock
from agents.individuals import each
from agents.kinds import Kind
from agents.spec import Spec

OPEN = {"world": "open", "size": 10.0, "rng": 1, "sigma": 0.0}


def start(rng, n, spread):
    angle = rng.uniform(-math.pi, math.pi, n)
    return {
        "position": rng.uniform(0.0, spread, (n, 2)),
        "heading": np.column_stack([np.cos(angle), np.sin(angle)]),
    }


def clear(position, heading, agents):
    """Whether no decision hangs on the last bits of a number."""
    gap = position[None] - position[:, None]
    d = np.linalg.norm(gap, axis=2) + 0.123 * np.eye(len(position))
    if min(np.abs(d - edge).min() for edge in (agents[0].alpha, agents[0].rho)) < 1e-7:
        return False
    wishes = [oracle.wanted(i, position, heading, agent) for i, agent in enumerate(agents)]
    return all(
        wish is not None and wish @ u > -0.99999 for wish, u in zip(wishes, heading, strict=True)
    )


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1), n=st.integers(1, 24), spread=st.sampled_from((2.0, 8.0, 25.0))
)
def test_every_tick_is_the_papers(seed, n, spread):
    rng = np.random.default_rng(seed)
    omega, g = rng.choice([0.0, 0.5, 2.0], n), rng.uniform(-180.0, 180.0, n)
    agents = [oracle.Agent(*one) for one in zip(omega, g, strict=True)]
    flock = Flock("leadership", start=start(rng, n, spread), omega=each(omega), g=each(g), **OPEN)
    for _ in range(5):
        assume(clear(flock.position, flock.heading, agents))
        position, heading = oracle.step(flock.position.copy(), flock.heading.copy(), agents)
        flock.run(1)
        np.testing.assert_allclose(flock.heading, heading, atol=1e-9)
        np.testing.assert_allclose(flock.position, position, atol=1e-9)


def test_who_is_alone_turns_to_what_it_prefers_and_no_further():
    begin = {"position": [[0.0, 0.0]], "heading": [[1.0, 0.0]]}
    flock = Flock("leadership", start=begin, omega=0.5, g=90.0, **OPEN)
    flock.run(1)
    half = math.atan2(0.5, 1.0)  # of the heading and half of the direction
    assert flock.heading[0] == pytest.approx([math.cos(min(half, 0.4)), math.sin(min(half, 0.4))],
                                             abs=1e-4)  # fmt: skip
    flock.run(200)
    assert flock.heading[0] == pytest.approx([0.0, 1.0], abs=1e-6)


def test_turned_agents_with_turned_directions_go_the_turned_way():
    """Space has no direction of its own: the preferred one alone is told from others."""
    c, s = math.cos(math.radians(70.0)), math.sin(math.radians(70.0))
    turn = np.array([[c, s], [-s, c]])
    begin = start(np.random.default_rng(3), 20, 6.0)
    rotated = {name: array @ turn for name, array in begin.items()}
    one = Flock("leadership", start=begin, omega=0.5, g=20.0, **OPEN)
    other = Flock("leadership", start=rotated, omega=0.5, g=90.0, **OPEN)
    one.run(60)
    other.run(60)
    np.testing.assert_allclose(one.position @ turn, other.position, atol=1e-7)


def test_a_fifth_that_is_informed_leads_the_rest():
    informed = Kind("informed", 20, omega=0.5, g=120.0, to={"flock": "own"})
    spec = Spec("leadership", agents=80, seed=2, kinds=[informed], to={"informed": "own"})
    flock = Flock(spec)
    assert flock.own["omega"][flock.rows_of("flock")].max() == 0.0
    flock.run(2000)
    before = flock.position.mean(axis=0)
    flock.run(2000)
    way = flock.position.mean(axis=0) - before
    assert np.linalg.norm(way) > 100.0
    assert abs(math.degrees(math.atan2(way[1], way[0])) - 120.0) < 30.0
