"""Answers to claims and verdicts beside published means: exact cases, and by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.studies.claims.claims import ranges_of_runs
from app.studies.experiment_file import PublishedMeasure
from app.studies.figures.mission import MissionSettings
from app.studies.judge.claim_verdict import (
    DOES_NOT,
    HOLDS,
    UNDECIDED,
    ClaimVerdict,
    join_all,
    join_any,
    mean_above,
    mean_within,
    share_of_runs,
    verdict_by_construction,
)
from app.studies.judge.comparison import compare
from app.studies.judge.judge import RunRanges, ranges_of, share_interval
from app.studies.judge.statistics import summary

FEW = ClaimVerdict("undecided", 5)


def spread_about(mean, runs=20, deviation=1.0):
    """Runs of a mean, as many above it as below."""
    return ranges_of(mean + deviation * np.array([1.0, -1.0] * (runs // 2)))


def test_means_that_are_told_from_0():
    assert mean_above(spread_about(1.0)) == HOLDS
    assert mean_above(spread_about(-1.0)) == DOES_NOT
    assert mean_above(spread_about(0.0)) == ClaimVerdict("undecided")
    assert mean_above(spread_about(1.0)).p < 0.01


def test_equal_runs_say_nothing_of_a_mean():
    for value in (2.0, 0.0, -1.0):
        answer = mean_above(ranges_of(np.full(100, value)))
        assert (answer.word, answer.why) == ("undecided", "all runs are equal")
    rounded = ranges_of([0.1 + 0.2] * 10).subtract(ranges_of([0.3] * 10))
    assert mean_above(rounded).why == "all runs are equal", "but for rounding"


def test_equal_runs_of_a_bounded_measure_do():
    def always(value, runs):
        values = np.full(runs, value)
        return RunRanges(values, values, (0.0, 1.0))

    assert mean_above(always(1.0, 50).add(-0.5)) == HOLDS
    assert mean_above(always(0.0, 50).add(-0.5)) == DOES_NOT
    few = mean_above(always(1.0, 6).add(-0.5))
    assert few.needed == 8, "0.005 ** (1 / 8) is the first above a half"


def test_few_runs_decide_no_mean():
    assert mean_above(ranges_of([5.0])) == FEW
    assert mean_above(ranges_of([5.0, 5.1, 4.9, 5.0])) == FEW
    assert mean_above(ranges_of([])) == FEW


def test_a_run_that_was_given_up_is_at_least_its_limit():
    given_up = ranges_of([*np.linspace(28.0, 32.0, 19), None], limit=40)
    assert mean_above(given_up.add(-20.0)) == HOLDS
    smaller = mean_above(given_up.add(-60.0))
    assert (smaller.word, smaller.why) == ("undecided", "1 of 20 runs given up")
    assert mean_within(given_up, 30.0, 15.0).word == "undecided"


def test_an_order_of_runs_that_were_given_up():
    slow, quick = ranges_of([None] * 20, limit=100), ranges_of(np.linspace(10.0, 12.0, 20))
    assert mean_above(slow.subtract(quick)) == HOLDS
    assert mean_above(quick.subtract(slow)).word == "does not hold"
    assert mean_above(slow.subtract(slow)).word == "undecided"


def test_whether_a_mean_is_near_a_value():
    values = ranges_of([1.0, 1.1, 0.9, 1.05, 0.95] * 4)
    assert mean_within(values, 1.0, 0.2) == HOLDS
    assert mean_within(values, 1.5, 0.2) == DOES_NOT
    assert mean_within(values, 0.5, 0.2) == DOES_NOT
    assert mean_within(ranges_of([1.0]), 1.0, 0.2) == FEW
    near = mean_within(values, 1.18, 0.2)
    assert near.word == "undecided"
    assert near.needed is not None
    assert near.needed > values.runs


def test_the_runs_that_are_said_to_decide_do():
    needed = mean_above(spread_about(0.2, 40)).needed
    assert needed is not None
    assert mean_above(spread_about(0.2, 2 * (needed // 2 + 1))) == HOLDS
    assert mean_above(spread_about(0.2, 2 * (needed // 4))).word == "undecided"


@given(st.lists(st.sampled_from([0.0, 1.0, 9.0, 100.0]), min_size=5, max_size=40))
def test_more_runs_are_asked_for_than_there_are_where_a_few_may_be_far_from_all_others(runs):
    values = RunRanges(np.array(runs), np.array(runs), (0.0, 100.0), rare=True)
    for bound in (2.0, 50.0, 97.0):
        answer = mean_above(values.add(-bound))
        assert answer.needed is None or answer.needed > len(runs)


@pytest.mark.parametrize(
    ("good", "runs", "share"), [(14, 25, 0.8), (34, 53, 0.8), (8, 13, 0.9), (41, 53, 0.9)]
)
def test_more_runs_are_asked_for_than_there_are_of_a_share(good, runs, share):
    answer = share_of_runs(good, runs, share)
    assert answer.word == "undecided"
    assert answer.needed is not None
    assert answer.needed > runs, "fewer would decide, if they were rounded luckily"


@given(st.integers(5, 60), st.integers(0, 60), st.sampled_from([[], [0.0, 100.0] * 20]))
def test_more_successes_are_asked_for_than_there_are_beside_published_ones(runs, failed, theirs):
    values = np.array([100.0] * max(runs - failed, 0) + [0.0] * min(failed, runs))
    ours = RunRanges(values, values, (0.0, 100.0), binary=True)
    published = PublishedMeasure(values=theirs) if theirs else PublishedMeasure(mean=60.0)
    found = compare(ours, published)
    assert found.needed is None or found.needed > runs
    assert found.why != "all runs are equal"


def test_a_rare_failure_that_few_runs_cannot_show_asks_for_more_of_them():
    values = np.full(20, 100.0) - np.linspace(0.0, 0.1, 20)
    few = mean_above(RunRanges(values, values, (0.0, 100.0), rare=True).add(-90.0))
    assert few.word == "undecided"
    assert few.needed is not None
    more = np.full(few.needed, 100.0) - np.linspace(0.0, 0.1, few.needed)
    assert mean_above(RunRanges(more, more, (0.0, 100.0), rare=True).add(-90.0)) == HOLDS


@pytest.mark.parametrize("theirs", [[], [95.0, 96.0] * 20])
def test_a_rare_failure_that_few_runs_cannot_show_may_lie_beside_a_published_mean(theirs):
    """20 of 20 runs near 100: one in five may fail, so that their mean may be 80."""
    published = PublishedMeasure(values=theirs) if theirs else PublishedMeasure(mean=95.5)

    def beside(runs, rare=True):
        values = np.full(runs, 100.0) - np.linspace(0.0, 0.1, runs)
        return compare(RunRanges(values, values, (0.0, 100.0), rare=rare), published)

    assert beside(20, rare=False).word == "differs"
    few = beside(20)
    assert few.word == "undecided"
    assert few.interval[0] < -10.0
    assert few.needed is not None
    assert beside(few.needed).word == "differs"


def test_a_run_without_a_value_is_no_0_and_was_not_given_up():
    """All that is known of it are the bounds of the measure: of a share, 0 to 1."""
    least, most = np.array([0.9] * 9 + [0.0]), np.array([0.9] * 9 + [1.0])
    values = RunRanges(least, most, (0.0, 1.0))
    found = summary(values)
    assert (found.runs, found.absent, found.limit) == (9, 1, None)
    assert found.mean == pytest.approx(0.9)
    assert compare(values, PublishedMeasure(mean=0.88)).why == "1 of 10 runs without a value"
    limited = summary(RunRanges(np.array([3.0, 8.0]), np.array([3.0, math.inf]), (0.0, math.inf)))
    assert (limited.mean, limited.limit) == (5.5, 8.0)


def test_a_distance_that_is_rarely_0_is_bounded_above_as_any_other():
    values = np.linspace(9.0, 11.0, 50)
    rare, usual = (RunRanges(values, values, (0.0, math.inf), rare=one) for one in (True, False))
    assert rare.interval()[0] < usual.interval()[0]
    assert rare.interval()[1] == usual.interval()[1]


@pytest.mark.parametrize(("arrived", "low"), [(0, 50.0), (1, 0.0)])
def test_a_mission_that_ended_early_was_not_given_up_at_the_limit(arrived, low):
    settings = MissionSettings(limit=50.0, world="open")
    measure = MissionSettings.measure("settled")
    values = {"settled": [None, 3.0], "arrived": [arrived, 1]}
    found = ranges_of_runs(values["settled"], measure, settings.limits_of(measure, values))
    assert found.least.tolist() == [low, 3.0]
    assert found.most.tolist() == [math.inf, 3.0]


@given(st.integers(1, 60), st.data())
def test_the_bounds_of_a_share_are_exact(runs, data):
    good = data.draw(st.integers(0, runs))
    low, high = (float(end) for end in share_interval(good, runs))

    def at_least(p):
        return sum(math.comb(runs, k) * p**k * (1 - p) ** (runs - k) for k in range(good, runs + 1))

    if good:
        assert at_least(low) == pytest.approx(0.005, rel=1e-6)
    else:
        assert low == 0.0
    if good < runs:
        more = sum(math.comb(runs, k) * high**k * (1 - high) ** (runs - k) for k in range(good + 1))
        assert more == pytest.approx(0.005, rel=1e-6)
    else:
        assert high == 1.0


def test_what_is_said_of_every_run():
    assert share_of_runs(9, 10, 1.0) == DOES_NOT
    assert share_of_runs(44, 44, 1.0) == HOLDS
    assert share_of_runs(43, 43, 1.0) == ClaimVerdict("undecided", 44)
    assert str(share_of_runs(2, 2, 1.0)) == "undecided (about 44 runs would decide)"


def test_what_is_said_of_a_share_of_runs():
    assert share_of_runs(100, 100, 0.99) == ClaimVerdict("undecided", 528)  # ln 0.005 / ln 0.99
    assert share_of_runs(528, 528, 0.99) == HOLDS
    assert share_of_runs(60, 100, 0.99) == DOES_NOT
    assert share_of_runs(50, 100, 0.5) == UNDECIDED


def test_parts_make_a_whole():
    some = ClaimVerdict("undecided", 30)
    assert join_all([HOLDS, HOLDS]) == HOLDS
    assert join_all([HOLDS, some]) == some
    assert join_all([some, UNDECIDED]) == UNDECIDED
    assert join_all([some, DOES_NOT]) == DOES_NOT
    assert join_any([some, HOLDS]) == HOLDS
    assert join_any([DOES_NOT, some]) == some
    assert join_any([DOES_NOT, DOES_NOT]) == DOES_NOT


def test_the_chance_of_a_whole_is_that_of_its_parts():
    parts = [ClaimVerdict("holds", p=0.001), ClaimVerdict("holds", p=0.004)]
    assert join_all(parts).p == 0.004
    assert join_any(parts).p == 0.001


def test_what_cannot_fail_says_so_unless_it_fails():
    assert verdict_by_construction(HOLDS).word == "by construction"
    assert verdict_by_construction(UNDECIDED).word == "by construction"
    assert verdict_by_construction(DOES_NOT) == DOES_NOT


def word(measured, **published):
    return compare(ranges_of(measured), PublishedMeasure(**published)).word


def test_equal_runs_neither_agree_nor_differ():
    for measured, published in (
        ([12.0] * 12, {"mean": 50.0}),
        ([12.0] * 12, {"mean": 12.0}),
        ([0.0] * 40, {"values": [0.0] * 5}),
        ([1.0] * 40, {"values": [0.0] * 5}),
    ):
        found = compare(ranges_of(measured), PublishedMeasure(**published))
        assert (found.word, found.why) == ("undecided", "all runs are equal")


def test_a_success_of_every_run_differs_from_a_published_share():
    values = np.full(50, 100.0)
    every = RunRanges(values, values, (0.0, 100.0), binary=True)
    assert compare(every, PublishedMeasure(mean=30.0)).word == "differs"
    assert compare(every, PublishedMeasure(mean=97.0)).word == "undecided"
    assert compare(every, PublishedMeasure(values=[0.0] * 20)).word == "differs"


def test_few_runs_decide_nothing():
    assert compare(ranges_of([60.0, 62.0]), PublishedMeasure(mean=10.0)).needed == 5
    assert word([40.0, 60.0] * 50, mean=51.0) == "agrees"
    assert word([40.0, 60.0] * 50, mean=60.0) == "differs"


def test_a_row_that_cannot_but_agree_says_so_unless_it_differs():
    published = PublishedMeasure(values=[0.0] * 5, by_construction="nobody looks")
    found = compare(spread_about(0.0, 100), published)
    assert (found.word, found.why, found.needed) == ("by construction", "nobody looks", None)
    assert compare(spread_about(50.0, 100), published).word == "differs"


def test_five_published_runs_cannot_agree():
    found = compare(
        spread_about(50.0, 400), PublishedMeasure(values=[49.0, 50.0, 51.0, 49.5, 50.5])
    )
    assert (found.word, found.why) == ("undecided", "the paper gives 5 runs")


def test_runs_that_were_given_up_are_larger_or_undecided():
    censored = [*[12.0, 13.0, 12.5] * 9, *[None] * 291]
    assert compare(ranges_of(censored, limit=50), PublishedMeasure(mean=12.66)).word == "differs"
    assert compare(ranges_of(censored, limit=50), PublishedMeasure(mean=23.0)).word == "differs"
    open_ = compare(ranges_of([*[12.0, 14.0] * 20, None], limit=50), PublishedMeasure(mean=13.0))
    assert (open_.word, open_.why) == ("undecided", "1 of 41 runs given up")
    assert open_.interval[1] == math.inf


def test_a_comparison_in_numbers():
    found = compare(ranges_of([40.0, 60.0] * 50), PublishedMeasure(mean=47.0))
    s = math.sqrt(100 * 100 / 99)
    assert found.difference == 3.0
    assert found.z == pytest.approx(3.0 / (s * math.sqrt(0.02)))
    assert found.effect == pytest.approx(3.0 / s)
    half = 2.692278 * s * math.sqrt(0.02)  # t of 99 / 2.25 = 44 degrees of freedom, from a table
    assert found.interval == (
        pytest.approx(3.0 - half, rel=1e-5),
        pytest.approx(3.0 + half, rel=1e-5),
    )


def test_runs_against_runs_are_welch_s():
    """Beside scipy's own test of two samples, of which the smaller has the larger spread."""
    from scipy.stats import ttest_ind

    rng = np.random.default_rng(6)
    ours, theirs = rng.normal(0.0, 0.5, 40), rng.normal(1.0, 2.0, 20)
    found = compare(ranges_of(ours), PublishedMeasure(values=list(theirs)))
    assert found.z == pytest.approx(ttest_ind(ours, theirs, equal_var=False).statistic)


def test_the_runs_said_to_decide_a_comparison():
    few = compare(ranges_of([40.0, 60.0] * 3), PublishedMeasure(mean=50.5))
    assert few.word == "undecided"
    assert word([40.0, 60.0] * (few.needed // 2 + 1), mean=50.5) == "agrees"
