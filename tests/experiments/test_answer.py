"""Answers to claims: how often they are wrong, exact cases, and the binomial bound by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.experiments.file import Published
from app.experiments.verdicts.answer import (
    DOES_NOT,
    HOLDS,
    UNDECIDED,
    Answer,
    all_of,
    any_of,
    bounds_of_share,
    by_construction,
    interval,
    mean_above,
    mean_within,
    share_of_runs,
)
from app.experiments.verdicts.comparison import compare


@pytest.mark.parametrize("runs", [2, 3, 10, 50])
def test_an_answer_about_a_mean_is_wrong_in_one_case_of_a_hundred(runs):
    draws = np.random.default_rng(runs).normal(0.0, 3.0, (6000, runs))
    told = [mean_above(margins).word != "undecided" for margins in draws]
    assert np.mean(told) == pytest.approx(0.01, abs=0.006)


def test_the_interval_is_student_s():
    low, high = interval(np.array([1.0, 2.0, 3.0, 4.0, 5.0]))
    half = 4.604095 * math.sqrt(2.5 / 5)  # t of 4 degrees of freedom, 99.5 %, from a table
    assert (low, high) == (pytest.approx(3.0 - half, rel=1e-6), pytest.approx(3.0 + half, rel=1e-6))
    assert interval(np.array([7.0])) == (-math.inf, math.inf)


def test_means_without_spread():
    assert mean_above(np.full(7, 2.0)) == HOLDS
    assert mean_above(np.full(7, 0.0)) == DOES_NOT
    assert mean_above(np.full(7, -1.0)) == DOES_NOT
    assert mean_above(np.array([2.0, 2.0])) == Answer("undecided", 7), "they may be so by chance"
    assert mean_above(np.array([5.0])) == UNDECIDED


def test_whether_a_mean_is_near_a_value():
    values = np.array([1.0, 1.1, 0.9, 1.05, 0.95] * 4)
    assert mean_within(values, 1.0, 0.2) == HOLDS
    assert mean_within(values, 1.5, 0.2) == DOES_NOT
    assert mean_within(values, 0.5, 0.2) == DOES_NOT
    assert mean_within(np.array([1.0]), 1.0, 0.2) == UNDECIDED
    near = mean_within(values, 1.18, 0.2)
    assert near.word == "undecided"
    assert near.needed is not None
    assert near.needed > len(values)
    assert mean_within(np.full(3, 2.0), 2.0, 0.1) == HOLDS


def test_a_mean_is_said_to_be_near_in_one_case_of_a_hundred_if_it_is_at_the_edge():
    draws = np.random.default_rng(3).normal(1.0, 3.0, (1500, 20))
    found = [mean_within(values, 0.0, 1.0).word for values in draws]
    assert np.mean([word != "undecided" for word in found]) < 0.016


def test_the_runs_that_are_said_to_decide_do():
    margins = np.array([1.0, -1.0] * 20) + 0.2
    needed = mean_above(margins).needed
    assert needed is not None
    more = np.array([1.0, -1.0] * (needed // 2 + 1)) + 0.2
    assert mean_above(more) == HOLDS
    assert mean_above(more[: needed // 2]).word == "undecided"


@given(st.integers(1, 60), st.data())
def test_the_bounds_of_a_share_are_exact(runs, data):
    good = data.draw(st.integers(0, runs))
    low, high = bounds_of_share(good, runs)

    def at_least(p):
        return sum(math.comb(runs, k) * p**k * (1 - p) ** (runs - k) for k in range(good, runs + 1))

    if good:
        assert at_least(low) == pytest.approx(0.01, rel=1e-6)
    else:
        assert low == 0.0
    if good < runs:
        more = sum(math.comb(runs, k) * high**k * (1 - high) ** (runs - k) for k in range(good + 1))
        assert more == pytest.approx(0.01, rel=1e-6)
    else:
        assert high == 1.0


def test_what_is_said_of_every_run():
    assert share_of_runs(9, 10, 1.0) == DOES_NOT
    assert share_of_runs(44, 44, 1.0) == HOLDS
    assert share_of_runs(43, 43, 1.0) == Answer("undecided", 44)
    assert str(share_of_runs(2, 2, 1.0)) == "undecided (about 44 runs would decide)"


def test_what_is_said_of_a_share_of_runs():
    assert share_of_runs(100, 100, 0.99) == Answer("undecided", 459)
    assert share_of_runs(459, 459, 0.99) == HOLDS
    assert share_of_runs(60, 100, 0.99) == DOES_NOT
    assert share_of_runs(50, 100, 0.5) == UNDECIDED


def test_parts_make_a_whole():
    some = Answer("undecided", 30)
    assert all_of([HOLDS, HOLDS]) == HOLDS
    assert all_of([HOLDS, some]) == some
    assert all_of([some, UNDECIDED]) == UNDECIDED
    assert all_of([some, DOES_NOT]) == DOES_NOT
    assert any_of([some, HOLDS]) == HOLDS
    assert any_of([DOES_NOT, some]) == some
    assert any_of([DOES_NOT, DOES_NOT]) == DOES_NOT


def test_what_cannot_fail_says_so_unless_it_fails():
    assert by_construction(HOLDS).word == "by construction"
    assert by_construction(UNDECIDED).word == "by construction"
    assert by_construction(DOES_NOT) == DOES_NOT


def word(measured, **published):
    return compare(np.array(measured, float), Published(**published)).word


def test_runs_without_spread_agree_or_differ():
    assert word([12.0] * 12, mean=50.0) == "differs"
    assert word([12.0] * 12, mean=12.0) == "agrees"
    assert word([0.0] * 40, values=[0.0] * 5) == "agrees"
    assert word([1.0] * 40, values=[0.0] * 5) == "differs"
    assert word([12.0], mean=12.0) == "undecided"


def test_two_runs_decide_little():
    assert word([60.0, 62.0], mean=70.0) == "undecided"
    assert word([40.0, 60.0] * 50, mean=51.0) == "agrees"
    assert word([40.0, 60.0] * 50, mean=60.0) == "differs"


def test_a_published_mean_of_a_hundred_runs_is_told_apart_in_one_case_of_a_hundred():
    rng = np.random.default_rng(5)
    words = [word(rng.normal(50, 8, 20), mean=rng.normal(50, 8, 100).mean()) for _ in range(4000)]
    assert np.mean([one == "differs" for one in words]) == pytest.approx(0.01, abs=0.006)


def test_a_comparison_in_numbers():
    found = compare(np.array([40.0, 60.0] * 50), Published(mean=47.0))
    s = math.sqrt(100 * 100 / 99)
    assert found.difference == 3.0
    assert found.z == pytest.approx(3.0 / (s * math.sqrt(0.02)))
    assert found.effect == pytest.approx(3.0 / s)
    half = 2.626405 * s * math.sqrt(0.02)  # t of 99 degrees of freedom, 99.5 %, from a table
    assert found.interval == (
        pytest.approx(3.0 - half, rel=1e-5),
        pytest.approx(3.0 + half, rel=1e-5),
    )


def test_runs_against_runs_are_welch_s():
    """Beside scipy's own test of two samples."""
    from scipy.stats import ttest_ind

    rng = np.random.default_rng(6)
    ours, theirs = rng.normal(0.0, 2.0, 40), rng.normal(1.0, 0.5, 5)
    found = compare(ours, Published(values=list(theirs)))
    expected = ttest_ind(ours, theirs, equal_var=False)
    assert found.z == pytest.approx(expected.statistic)
    low, high = expected.confidence_interval(0.99)
    assert found.interval == (pytest.approx(low), pytest.approx(high))


def test_the_runs_said_to_decide_a_comparison():
    few = compare(np.array([40.0, 60.0] * 3), Published(mean=50.5))
    assert few.word == "undecided"
    assert compare(np.array([40.0, 60.0] * (few.needed // 2 + 1)), Published(mean=50.5)).word == (
        "agrees"
    )
