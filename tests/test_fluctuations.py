"""Susceptibility and Binder's cumulant: exact cases, invariants, naive sums; series over a run."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import order_over_groups as naive
from oracles.scenes import unit_vectors

from agents import Flock
from agents.observables.order import binder, polarisation, susceptibility
from agents.run_records import Follower, follow, needed
from worlds.input_error import InputError

SERIES = st.lists(st.floats(0.0, 1.0), min_size=1, max_size=40)


def test_a_flock_that_does_not_change_does_not_fluctuate():
    for phi in (1e-9, 0.5, 1.0):
        assert susceptibility(np.full(7, phi), 100) == pytest.approx(0.0, abs=1e-12)
        assert binder(np.full(7, phi)) == pytest.approx(2.0 / 3.0)


def test_half_of_the_time_ordered():
    half = np.tile([0.0, 1.0], 10)
    assert susceptibility(half, 300) == 75.0
    assert binder(half) == pytest.approx(1.0 / 3.0)


def test_rarely_ordered_is_below_nothing():
    """A share s of the time at 1, else at 0: U = 1 - 1/(3 s)."""
    rarely = np.repeat([1.0, 0.0], [1, 9])
    assert binder(rarely) == pytest.approx(1.0 - 10.0 / 3.0)


@pytest.mark.parametrize(("dim", "expected"), [(2, 1.0 / 3.0), (3, 4.0 / 9.0)])
def test_headings_at_random(dim, expected):
    """phi is Rayleigh's in the plane and Maxwell's in space: chi = 1 - pi/4, 1 - 8/(3 pi)."""
    rng = np.random.default_rng(5)
    n = 200
    series = np.array([polarisation(unit_vectors(rng, n, dim)) for _ in range(20_000)])
    assert binder(series) == pytest.approx(expected, abs=0.01)
    chi = 1.0 - math.pi / 4.0 if dim == 2 else 1.0 - 8.0 / (3.0 * math.pi)
    assert susceptibility(series, n) == pytest.approx(chi, rel=0.03)


def test_without_a_series_or_without_order_there_is_nothing_to_tell():
    assert math.isnan(susceptibility(np.array([]), 10))
    assert math.isnan(binder(np.array([])))
    assert math.isnan(binder(np.zeros(4)))
    assert susceptibility(np.zeros(4), 10) == 0.0
    assert binder(np.full(3, 1e-200)) == pytest.approx(2.0 / 3.0)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(series=SERIES, n=st.integers(0, 10**6))
def test_they_are_the_naive_sums_and_within_their_bounds(series, n):
    chi = susceptibility(series, n)
    assert chi == pytest.approx(naive.susceptibility(series, n), abs=1e-12 * max(1, n))
    assert 0.0 <= chi <= n / 4.0 * (1.0 + 1e-12)
    assert susceptibility(series[::-1], n) == pytest.approx(chi, abs=1e-12 * max(1, n))
    if max(series) > 1e-3:
        u = binder(series)
        assert u == pytest.approx(naive.binder(series), rel=1e-9)
        assert u <= 2.0 / 3.0 + 1e-12
        assert u >= 1.0 - len(series) / 3.0 - 1e-9
        assert binder([0.5 * x for x in series]) == pytest.approx(u)


# --- over a run -------------------------------------------------------------------------------


def flock_at_random(**more):
    return Flock("vem", agents=40, rng=7, eta=2.0, **more)


def test_a_series_is_what_a_flock_shows_tick_by_tick():
    series = follow(flock_at_random(), 20, ["polarisation", "groups"])
    other = flock_at_random()
    for k in range(20):
        other.run(1)
        assert series.tick[k] == other.tick
        assert series.values["polarisation"][k] == other.observe("polarisation")
        assert series.values["groups"][k] == other.observe("groups")
    assert series.agents.tolist() == [40] * 20
    phi = series.values["polarisation"]
    assert series.over("susceptibility") == pytest.approx(naive.susceptibility(phi, 40))
    assert series.over("binder") == pytest.approx(naive.binder(phi))


def test_looking_does_not_change_the_run_and_every_tick_is_run():
    flock, other = flock_at_random(), flock_at_random()
    series = follow(flock, 23, every=5)
    other.run(23)
    assert series.tick.tolist() == [5, 10, 15, 20]
    assert flock.tick == 23
    assert np.array_equal(flock.position, other.position)


def test_a_run_without_ticks_has_an_empty_series():
    series = follow(flock_at_random(), 0)
    assert len(series.tick) == 0
    assert math.isnan(series.over("susceptibility"))
    assert math.isnan(series.over("binder"))


def test_what_is_needed_for_what_is_asked():
    assert needed(["susceptibility", "polarisation", "binder", "groups"]) == [
        "polarisation",
        "groups",
    ]
    assert needed([]) == []


def test_what_cannot_be_followed_is_refused_before_anything_runs():
    flock = flock_at_random()
    for names, ticks, every, words in [
        (["group-sizes"], 5, 1, "group-sizes is a table"),
        (["polarization"], 5, 1, "did you mean 'polarisation'"),
        (["polarisation"], -1, 1, "ticks = -1"),
        (["polarisation"], 5, 0, "every = 0"),
    ]:
        with pytest.raises(InputError, match=words):
            follow(flock, ticks, names, every)
    assert flock.tick == 0


def test_a_series_has_only_what_was_observed():
    follower = Follower(flock_at_random(), ["groups"])
    follower.note_values()
    with pytest.raises(InputError, match="series of polarisation, which was not observed"):
        follower.series.over("binder")
    with pytest.raises(InputError, match=r"unknown observable over a run 'bindr'.*'binder'"):
        follower.series.over("bindr")
    with pytest.raises(InputError, match="unknown observable over a run 'groups'"):
        follower.series.over("groups")


def test_the_vicsek_model_fluctuates_most_where_it_loses_its_order():
    chi, u = {}, {}
    for eta in (1.0, 3.5, 6.0):
        flock = Flock("vem", agents=300, rng=1, eta=eta)
        flock.run(1000)
        series = follow(flock, 2000, every=2)
        chi[eta], u[eta] = series.over("susceptibility"), series.over("binder")
    assert chi[3.5] > 5.0 * max(chi[1.0], chi[6.0])
    assert u[1.0] > 0.66
    assert 0.3 < u[6.0] < 0.42


def test_one_tick_has_no_fluctuations():
    with pytest.raises(InputError, match="binder is measured over a run"):
        flock_at_random().observe("binder")
