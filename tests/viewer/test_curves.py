"""Curves over a run: how they are thinned, cut to its end, chosen and laid over each other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.observables.catalogue import default_charts
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_curves import align_curves, chart_title, choices, points, steps
from app.viewer.measuring.observable_format import offered_observables
from app.viewer.measuring.time_series import POINTS, TimeSeries


def series_of(ticks, value=float) -> TimeSeries:
    series = TimeSeries()
    for tick in ticks:
        series.add(tick, value(tick))
    return series


def test_a_series_keeps_its_ends_and_never_has_too_many_points():
    ticks, values = series_of(range(100_000), lambda tick: tick / 10).arrays()
    assert POINTS / 4 < len(ticks) <= POINTS
    assert ticks[0] == 0
    assert ticks[-1] > 99_000
    assert np.all(np.diff(ticks) > 0)
    np.testing.assert_array_equal(values, ticks / 10)


def test_a_series_with_long_strides_is_not_thinned_to_nothing():
    assert len(series_of(range(0, 10**7, 9973)).arrays()[0]) > POINTS / 4


def test_the_end_of_a_series_has_every_point():
    series = series_of(range(5000))
    ticks, values = series.arrays(last=200)
    assert ticks.tolist() == values.tolist() == list(range(4799, 5000))
    ticks, values = series.arrays(last=3000)
    assert ticks[0] == pytest.approx(1999, abs=series.apart)
    assert ticks[-POINTS:].tolist() == list(range(5000 - POINTS, 5000))
    assert np.all(np.diff(ticks) > 0)
    np.testing.assert_array_equal(values, ticks)


def test_a_second_reading_at_one_tick_replaces_the_first():
    series = TimeSeries()
    series.add(0, 1.0)
    series.add(0, 2.0)
    assert [column.tolist() for column in series.arrays()] == [[0.0], [2.0]]
    assert [column.tolist() for column in series.arrays(last=5)] == [[0.0], [2.0]]


def test_what_is_no_number_is_left_out():
    series = series_of(range(4), lambda tick: [1.0, math.nan, math.inf, 3.0][tick])
    assert [column.tolist() for column in series.arrays()] == [[0.0, 3.0], [1.0, 3.0]]
    assert [len(column) for column in TimeSeries().arrays(last=3)] == [0, 0]


@given(st.lists(st.integers(0, 60), max_size=20), st.integers(0, 40), st.floats(1.0, 200.0))
def test_steps_count_what_has_been(ticks, later, last):
    ticks = np.array(sorted(ticks), int)
    now = int(ticks.max(initial=0)) + later
    x, y = steps(ticks, now, last)
    assert x[-1] == now
    assert x[0] == max(0.0, now - last)
    assert np.all(np.diff(x) > 0)
    assert y.tolist() == [np.count_nonzero(ticks <= at) for at in x]
    for at in {*ticks.tolist()}:
        if x[0] <= at:
            # It stands upright: full height at the tick, the height before just before it.
            assert at in x
            assert np.interp(at - 0.5, x, y) == np.count_nonzero(ticks < at) or at - 0.5 < x[0]


def test_curves_share_the_ticks_of_all_and_the_time_of_the_first():
    first = series_of((0, 10, 20, 30)).arrays()
    second = series_of((0, 2, 5), lambda tick: 100.0 * tick).arrays()
    at, own, other, none = align_curves([first, second, TimeSeries().arrays()], [1.0, 5.0, 1.0])
    assert at.tolist() == own.tolist() == [0, 10, 20, 25, 30]
    assert other.tolist() == [0.0, 200.0, pytest.approx(200 + 1000 / 5 * 2 / 2 * 1.0), 500.0, 500.0]
    assert np.isnan(none).all()
    assert np.isnan(np.concatenate(align_curves([TimeSeries().arrays()], [1.0])[1:])).all()


@pytest.mark.parametrize("name", MODELS)
def test_every_model_brings_plots_that_can_be_chosen(name):
    flock = Flock(name, agents=4, rng=1)
    usual_ones = default_charts(flock.model, offered_observables(flock))
    assert len(usual_ones) == 3
    assert set(usual_ones) <= set(choices(offered_observables(flock)).values())
    assert all(
        choices(offered_observables(flock))[chart_title(names)] == names for names in usual_ones
    )


def test_a_model_brings_what_matters_for_it():
    def brought(name: str) -> tuple:
        flock = Flock(name, agents=4, rng=1)
        return default_charts(flock.model, offered_observables(flock))

    assert brought("couzin")[0] == ("polarisation", "angular-momentum")
    assert brought("safe") == (("groups",), ("polarisation",), ("crashes",))
    assert brought("echelon")[0] == ("drag-saved", "energy-saved")
    assert brought("hwvem-nav")[2] == ("goal-distance",)
    assert brought("hwvem") == (("polarisation", "consistency"), ("mean-neighbours",), ())
    assert brought("vasarhelyi")[:2] == (("polarisation",), ("nearest-neighbour",))
    assert brought("boundary-points") == (("nearest-neighbour",), ("groups",), ("goal-distance",))


def test_agreement_with_a_leader_is_plotted_where_one_leads():
    def first(**given) -> tuple:
        flock = Flock("hwvem", agents=4, rng=1, **given)
        return default_charts(flock.model, offered_observables(flock))[0]

    assert first(informed=1) == ("polarisation", "consistency")
    assert first(informed=0) == ("polarisation",)


def test_crashes_are_plotted_to_the_tick():
    flock = Flock("safe", agents=30, rng=3)
    readings = FlockReadings(flock)
    flock.arrays.crash_record[:3, :2] = [[2, 1], [2, 1], [7, 2]]
    flock.tick = 9
    readings.read(at_once=True)
    ticks, count = points(readings, "crashes")
    assert ticks.tolist() == [0, pytest.approx(1.999), 2, pytest.approx(6.999), 7, 9]
    assert count.tolist() == [0, 0, 2, 2, 3, 3]
    assert [
        len(one) for one in points(FlockReadings(Flock("vem", agents=3, rng=1)), "crashes")
    ] == [
        0,
        0,
    ]
