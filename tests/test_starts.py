"""Starts, random orders and gusts are hashes of the seed: against the noise's own functions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from agents import Flock
from agents.conditions import gust_noise
from agents.engine.noise import (
    GUSTS,
    ORDERS,
    normal,
    random_direction,
    tick_key,
    uniform,
    uniform_numbers,
)
from agents.state.start import FIRST, random_headings
from worlds.compilation import plain_python

SEEDS = st.integers(0, 2**63 - 1)


@given(SEEDS, st.integers(0, FIRST + 300), st.lists(st.integers(0, 2**53), max_size=5))
@settings(max_examples=50)
def test_numbers_of_many_are_those_of_each(seed, tick, ids):
    many = uniform_numbers(seed, tick, np.array(ids, np.int64), 3, 2)
    with plain_python():
        key = tick_key(seed, tick)
        each = [[uniform(key, agent, draw) for draw in (2, 3, 4)] for agent in ids]
    assert many.tolist() == each


@pytest.mark.parametrize("dim", [2, 3])
def test_headings_are_the_directions_of_the_noise_at_the_tick_of_the_start(dim):
    ids = np.arange(1, 200)
    key = tick_key(5, FIRST)
    expected = np.array([random_direction(key, agent, dim)[:dim] for agent in ids])
    assert random_headings(5, ids, dim) == pytest.approx(expected, abs=1e-14)


def test_gusts_are_the_normal_numbers_of_the_noise():
    key = tick_key(5, GUSTS)
    expected = [[normal(key, tick, 2 * axis) for axis in range(3)] for tick in range(3, 9)]
    assert gust_noise(5, 3, 9) == pytest.approx(np.array(expected), abs=1e-13)


@pytest.mark.parametrize("model", ["vem", "hwvem", "thesis", "vasarhelyi"])
def test_an_agent_begins_where_its_seed_and_identity_say_whoever_else_there_is(model):
    few = Flock(model, agents=12, rng=3, world="open", size=90.0, spacing=0.0)
    many = Flock(model, agents=30, rng=3, world="open", size=90.0, spacing=0.0)
    rows = [int(np.flatnonzero(many.ids == one)[0]) for one in few.ids]
    for name in ("position", "heading", "speed"):
        assert (getattr(many, name)[rows] == getattr(few, name)).all(), name


def test_an_agent_that_comes_later_begins_where_it_would_have():
    flock, whole = (Flock("vem", agents=n, rng=3, size=9.0) for n in (12, 13))
    type(flock.members[0])(flock)
    place = whole.position[whole.ids == 13]
    assert flock.position[flock.ids == 13].tolist() == place.tolist()


@pytest.mark.parametrize("dim", [2, 3])
def test_places_and_headings_are_uniform(dim):
    flock = Flock("couzin", agents=4000, rng=2, dim=dim, world="open", size=7.0)
    for axis in range(dim):
        assert stats.kstest(flock.position[:, axis] / 7.0, "uniform").pvalue > 1e-4
    turn = np.arctan2(flock.heading[:, 1], flock.heading[:, 0]) / (2.0 * math.pi) + 0.5
    assert stats.kstest(turn, "uniform").pvalue > 1e-4
    if dim == 3:
        assert stats.kstest(0.5 * flock.heading[:, 2] + 0.5, "uniform").pvalue > 1e-4
    assert (
        np.abs(np.corrcoef(flock.position.T, flock.heading.T)).max(
            initial=0.0,
            where=[[row != column for column in range(2 * dim)] for row in range(2 * dim)],
        )
        < 0.08
    )


def test_a_random_order_is_that_of_the_hash_and_another_in_each_tick():
    flock = Flock("hwvem", agents=20, rng=3, activation="random")
    orders = [flock.engine.order(tick).tolist() for tick in range(50)]
    with plain_python():
        key = tick_key(3, ORDERS + 7)
        numbers = [uniform(key, int(one), 0) for one in flock.ids]
    assert orders[7] == np.argsort(numbers).tolist()
    assert all(sorted(order) == list(range(21)) for order in orders)
    first = [order[0] for order in orders]
    assert len(set(first)) > 12, "who is first differs"
