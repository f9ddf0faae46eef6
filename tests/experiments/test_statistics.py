"""Means, quartiles, intervals, verdicts: exact cases."""

import math
from dataclasses import replace

import numpy as np
import pytest

from agents.spec import Spec
from app.studies.claims.claims import claims, verdicts, word_and_expected
from app.studies.experiment import Case
from app.studies.experiment_file import PaperRow, PaperSweep
from app.studies.experiment_runner import MeasuredCase
from app.studies.judge.judge import ranges_of
from app.studies.judge.statistics import interval_of_mean, summary
from experiments.small import small

VEM = Spec("vem", agents=5, size=1.0)


def test_summary_of_known_numbers():
    s = summary(ranges_of([2, 4, 4, 4, 5, 5, 7, 9]))
    assert (s.runs, s.absent, s.mean, s.median) == (8, 0, 5.0, 4.5)
    assert s.sd == pytest.approx(math.sqrt(32 / 7))
    assert s.quartiles == (4.0, 4.5, 5.5)
    assert s.standard_error == pytest.approx(math.sqrt(32 / 7 / 8))


def test_runs_that_were_given_up_count_as_their_limit():
    s = summary(ranges_of([10, None, 20, None], limit=50))
    assert (s.runs, s.absent, s.limit, s.mean, s.median) == (2, 2, 50.0, 32.5, 35.0)
    assert math.isnan(s.sd)
    assert s.interval[1] == math.inf


def test_runs_without_a_value_and_without_a_limit_count_in_no_number():
    s = summary(ranges_of([10, None, 20, None]))
    assert (s.runs, s.absent, s.limit, s.mean) == (2, 2, None, 15.0)


@pytest.mark.parametrize("times", [[], [None, None], [3]])
def test_too_few_runs_have_no_spread(times):
    s = summary(ranges_of(times))
    assert math.isnan(s.sd)


def test_the_interval_of_the_mean_holds_it_in_19_of_20_draws():
    rng = np.random.default_rng(2)
    draws = [interval_of_mean(ranges_of(rng.normal(50, 8, 100))) for _ in range(400)]
    assert np.mean([low < 50.0 < high for low, high in draws]) == pytest.approx(0.95, abs=0.035)


def test_equal_values_have_no_interval():
    assert all(math.isnan(end) for end in interval_of_mean(ranges_of(np.full(9, 100.0))))
    assert all(math.isnan(end) for end in interval_of_mean(ranges_of([3.0])))


def case(mean, **more):
    row = PaperRow(model="vem", agents=5, published={"k_con": {"mean": mean} | more})
    return Case(VEM, 5, row)


def judged(tmp_path, cases, times):
    """The verdicts on the cases of an experiment."""
    measured = [MeasuredCase(c, {"k_con": t}) for c, t in zip(cases, times, strict=True)]
    return verdicts(small(tmp_path), measured)


def test_verdicts_come_from_the_runs_whatever_was_expected(tmp_path):
    expected = {"verdict": "differs", "why": "why"}
    cases = [case(50.0), case(60.0), case(60.0, expected=expected), case(50.0, expected=expected)]
    made = judged(tmp_path, [*cases, Case(VEM, 5)], [[40, 60] * 50] * 5)
    assert [one.word for one in made] == ["agrees", "differs", "differs", "agrees", ""]
    assert word_and_expected(made[2].word, made[2].expected) == "expected: differs; why"
    assert (
        word_and_expected(made[3].word, made[3].expected) == "expected: differs; now: agrees; why"
    )
    assert word_and_expected(made[0].word, made[0].expected) == ""


def test_a_measure_may_be_set_aside_for_all_rows(tmp_path):
    experiment = replace(small(tmp_path), not_compared={"k_con": "why"})
    [one] = verdicts(experiment, [MeasuredCase(case(60.0), {"k_con": [40, 60] * 50})])
    assert (one.word, one.not_compared, one.comparison) == ("", "why", None)


def test_claims_of_a_sweep(tmp_path):
    sweep = PaperSweep(
        model="vem", agents=[5], parameter="p", values=[1.0, 2.0, 3.0], trend="falls", flat_from=2.0
    )
    cases = [Case(VEM.but(parameters={"p": value}), 5, sweep=sweep) for value in sweep.values]

    def holds(*means):
        rng = np.random.default_rng(1)
        times = [list(mean + rng.permutation([-1, 0, 1] * 5)) for mean in means]
        return [one.word for one in claims(judged(tmp_path, cases, times))]

    assert holds(100, 50, 49) == ["holds", "holds"]
    assert holds(100, 50, 20) == ["holds", "does not hold"]
    assert holds(50, 50, 50) == ["undecided", "holds"]
    assert holds(0, 0, 0) == ["undecided", "undecided"], "nothing is divided by a mean of 0"
    assert holds(50, 100, 100) == ["does not hold", "holds"]
