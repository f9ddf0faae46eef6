"""The rule by which runs are judged: its figures by simulation, its formulas written apart.

The limits are those that the rule promises; each cell has the spread of so many samples beside it.
"""

import math
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy  # its parts are imported when they are asked for
from hypothesis import given
from hypothesis import strategies as st

from app.studies.judge.judge import (
    bounded_interval,
    estimate_mean,
    mean_interval,
    share_difference,
    subtract_means,
    survives_holm,
    typical_spread,
)

sys.path.append(str(Path(__file__).parents[2] / "benchmarks" / "studies"))
import judge as simulation

SAMPLES = 4000


def at_most(limit, samples=SAMPLES):
    """A limit in per cent, and three standard errors of so many samples."""
    share = limit / 100.0
    return limit + 300.0 * math.sqrt(share * (1.0 - share) / samples)


def limit_of(name):
    """False words that a law may give, per cent."""
    return 1.5 if name in simulation.MILD else 2.5


@pytest.mark.parametrize("name", simulation.LAWS)
def test_few_words_are_false_of_any_law(name):
    for runs in simulation.RUNS:
        assert simulation.false_words(name, runs, SAMPLES) <= at_most(limit_of(name)), runs


def test_student_s_t_would_not_do():
    """What the rule is for: the same count with Student's t is far above the limit."""
    t = simulation.student_interval
    assert simulation.false_words("lognormal(1)", 10, SAMPLES, t) > 2.0 * at_most(2.5)
    assert simulation.coverage("lognormal(1)", 5, SAMPLES, t) < 85.0


@pytest.mark.parametrize("name", simulation.LAWS)
def test_intervals_hold_the_mean(name):
    for runs in simulation.RUNS:
        assert 100.0 - simulation.coverage(name, runs, SAMPLES) <= at_most(7.0), runs


@pytest.mark.parametrize("name", simulation.DEVIATION)
def test_what_is_there_is_seen(name):
    seen = simulation.effects_seen
    assert seen(name, 100, 1.0, SAMPLES) >= 95.0
    assert seen(name, 20, 2.0, SAMPLES) >= 80.0
    assert simulation.effects_seen_between(name, 100, SAMPLES) >= 95.0
    assert simulation.agreement_share(name, 100, SAMPLES) >= 95.0


@pytest.mark.parametrize("runs", simulation.RUNS)
def test_few_words_are_false_of_two_samples(runs):
    between = simulation.false_between
    assert between("lognormal(1)", runs, "normal", runs, SAMPLES) <= at_most(2.5)
    assert between("lognormal(1)", 5, "normal", runs, SAMPLES) <= at_most(2.5)
    assert between("exponential", 5, "exponential", runs, SAMPLES) <= at_most(2.5)


@pytest.mark.parametrize("runs", simulation.RUNS)
@pytest.mark.parametrize("name", simulation.DEVIATION)
def test_few_words_are_false_beside_a_published_mean(name, runs):
    published = simulation.false_published
    assert published(name, runs, 100, SAMPLES, with_spread=False) <= at_most(limit_of(name))
    for theirs in (5, 20, 100):
        assert published(name, runs, theirs, SAMPLES, with_spread=True) <= at_most(limit_of(name))
    assert simulation.false_agreement(name, runs, 100, SAMPLES) <= at_most(2.5)
    assert simulation.false_within(name, runs, SAMPLES) <= at_most(2.5)


@pytest.mark.parametrize("runs", simulation.RUNS)
def test_few_words_are_false_where_runs_are_given_up(runs):
    for name in ("exponential", "lognormal(1)"):
        assert simulation.false_censored(name, runs, SAMPLES) <= at_most(2.5)


@pytest.mark.parametrize("share", [0.02, 0.3, 0.5, 0.9])
def test_counted_successes_are_exact(share):
    assert all(simulation.false_shares(share, runs) <= 1.0 for runs in simulation.RUNS)


@pytest.mark.parametrize("share", [0.1, 0.02])
def test_a_rare_crash_is_missed_only_where_no_run_shows_it(share):
    for runs in simulation.RUNS:
        unseen = 100.0 * (1.0 - share) ** runs
        assert simulation.false_rare(share, runs, SAMPLES, is_known=False) <= at_most(unseen + 1.0)
        assert simulation.false_rare(share, runs, SAMPLES, is_known=True) <= at_most(1.0)


def test_looks_while_runs_come_in():
    assert simulation.false_looks("normal", SAMPLES) <= at_most(1.5)
    assert simulation.false_looks("lognormal(1)", SAMPLES) <= at_most(2.5)


@pytest.mark.parametrize(
    ("name", "limit"), [("normal", 2), ("exponential", 2), ("lognormal(1)", 6)]
)
def test_headlines_of_whole_tables(name, limit):
    for runs in (10, 20, 50):
        assert simulation.false_tables(name, runs, 300) <= at_most(limit, 300)


some = st.lists(st.integers(-(10**6), 10**6), min_size=5, max_size=40).map(
    lambda k: 1e-3 * np.array(k)
)


def by_hand(values, confidence):
    """Student's and Hall's limits, written from the formulas, one sample at a time."""
    n, mean, s = len(values), np.mean(values), np.std(values, ddof=1)
    error, freedom = s / math.sqrt(n), (n - 1) / (1 + 2.5 / 2)
    third = np.sum((values - mean) ** 3) / np.sum((values - mean) ** 2) ** 1.5
    y, a, b = scipy.stats.t.ppf(0.5 + confidence / 2, freedom), third / 3, third / 6

    def inverse(at):
        return at - b if abs(a) < 1e-6 else (np.cbrt(1 + 3 * a * (at - b)) - 1) / a

    low = mean - error * min(max(inverse(y), y), 2 * y)
    high = mean + error * min(max(-inverse(-y), y), 2 * y)
    return low, high


@given(some, st.sampled_from([0.95, 0.99, 0.998]))
def test_the_interval_is_the_wider_of_student_s_and_hall_s(values, confidence):
    if np.ptp(values) == 0.0:
        return
    low, high = mean_interval(estimate_mean(values), confidence)
    expected = by_hand(values, confidence)
    size = np.abs(values).max()
    assert (float(low), float(high)) == (
        pytest.approx(expected[0], rel=1e-6, abs=1e-6 * size),
        pytest.approx(expected[1], rel=1e-6, abs=1e-6 * size),
    )


@given(some, st.floats(-50.0, 50.0), st.floats(0.1, 10.0))
def test_intervals_move_and_stretch_with_the_runs(values, shift, factor):
    low, high = bounded_interval(values, values)
    moved_low, moved_high = bounded_interval(*[factor * values + shift] * 2)
    if np.ptp(values) < 1e-3:
        return
    assert float(moved_low) == pytest.approx(factor * float(low) + shift, rel=1e-6, abs=1e-6)
    mirrored = bounded_interval(-values, -values)
    assert (float(mirrored.low), float(mirrored.high)) == pytest.approx((-float(high), -float(low)))
    assert float(moved_high) >= float(moved_low)


@given(some, some)
def test_a_difference_turned_round_is_its_opposite(a, b):
    there = mean_interval(subtract_means(estimate_mean(a), estimate_mean(b)))
    back = mean_interval(subtract_means(estimate_mean(b), estimate_mean(a)))
    assert float(there.low) == pytest.approx(-float(back.high), rel=1e-9)


def test_two_normal_samples_of_one_size_have_welch_s_error():
    rng = np.random.default_rng(8)
    a, b = rng.normal(0.0, 1.0, 30), rng.normal(0.0, 3.0, 30)
    found = subtract_means(estimate_mean(a), estimate_mean(b))
    expected = scipy.stats.ttest_ind(a, b, equal_var=False)
    assert float(found.mean / found.error) == pytest.approx(expected.statistic)
    assert float(found.freedom) == pytest.approx(expected.df)


def test_the_typical_spread_is_that_of_a_normal_law_and_less_of_one_with_far_runs():
    rng = np.random.default_rng(9)
    assert float(typical_spread(rng.normal(0.0, 2.0, 100_000))) == pytest.approx(2.0, rel=0.02)
    far = np.concatenate([rng.normal(0.0, 1.0, 990), np.full(10, 100.0)])
    assert float(typical_spread(far)) < 0.5 * far.std()


def test_the_difference_of_two_shares():
    """Zou and Donner 2008 by hand: 56 of 70 beside 48 of 80, at 95 %, exact limits of each."""
    low, high = share_difference(56, 70, 48, 80, 0.95)
    a = scipy.stats.binomtest(56, 70).proportion_ci(0.95)
    b = scipy.stats.binomtest(48, 80).proportion_ci(0.95)
    assert float(low) == pytest.approx(0.2 - math.hypot(0.8 - a.low, b.high - 0.6))
    assert float(high) == pytest.approx(0.2 + math.hypot(a.high - 0.8, 0.6 - b.low))


def test_holm_passes_the_least_first():
    assert list(survives_holm(np.array([0.004, 0.0045, 0.2]))) == [False, False, False]
    assert list(survives_holm(np.array([0.003, 0.0045, 0.2]))) == [True, True, False]
    assert list(survives_holm(np.array([0.01]))) == [True]
