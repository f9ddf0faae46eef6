"""Means, quartiles, z-scores, verdicts: exact cases."""

import math
from dataclasses import replace

import numpy as np
import pytest

from agents.spec import Spec
from app.experiments.conduct import Measured
from app.experiments.experiment import Case
from app.experiments.file import Row, Sweep
from app.experiments.verdicts.claims import claims
from app.experiments.verdicts.statistics import difference, interval_of_mean, summary, z_score
from app.experiments.verdicts.verdict import verdicts
from experiments.small import small

VEM = Spec("vem", agents=5, size=1.0)


def test_summary_of_known_numbers():
    s = summary([2, 4, 4, 4, 5, 5, 7, 9])
    assert (s.runs, s.absent, s.mean, s.median) == (8, 0, 5.0, 4.5)
    assert s.sd == pytest.approx(math.sqrt(32 / 7))
    assert s.quartiles == (4.0, 4.5, 5.5)
    assert s.standard_error == pytest.approx(math.sqrt(32 / 7 / 8))


def test_runs_that_were_given_up_are_counted_and_left_out():
    s = summary([10, None, 20, None])
    assert (s.runs, s.absent, s.mean) == (2, 2, 15.0)


@pytest.mark.parametrize("times", [[], [None, None], [3]])
def test_too_few_runs_have_no_spread(times):
    s = summary(times)
    assert math.isnan(s.sd)
    assert math.isnan(z_score(s, 3.0))


def test_z_is_1_96_sigma_in_one_of_twenty_draws():
    rng = np.random.default_rng(1)
    z = [
        z_score(summary(list(rng.normal(50, 8, 100))), rng.normal(50, 8, 100).mean())
        for _ in range(4000)
    ]
    assert np.mean(np.abs(z) > 1.96) == pytest.approx(0.05, abs=0.012)
    assert np.mean(z) == pytest.approx(0.0, abs=0.06)


def test_z_of_known_numbers():
    s = summary([40, 60] * 50)
    expected = (50.0 - 47.0) / math.sqrt(s.sd**2 / 100 + s.sd**2 / 100)
    assert z_score(s, 47.0) == pytest.approx(expected)


def test_difference_of_two_means():
    a, b = summary([1, 2, 3]), summary([11, 12, 13])
    assert difference(a, b) == (10.0, pytest.approx(math.sqrt(2 / 3)))


def test_the_interval_of_the_mean_holds_it_in_19_of_20_draws():
    rng = np.random.default_rng(2)
    draws = [interval_of_mean(rng.normal(50, 8, 100)) for _ in range(400)]
    assert np.mean([low < 50.0 < high for low, high in draws]) == pytest.approx(0.95, abs=0.035)


def test_the_interval_of_equal_values_is_their_value():
    assert interval_of_mean(np.full(9, 100.0)) == (100.0, 100.0)
    assert all(math.isnan(end) for end in interval_of_mean(np.array([3.0])))


def case(mean, why=""):
    row = Row(model="vem", agents=5, published={"k_con": {"mean": mean, "not_reproduced": why}})
    return Case(VEM, 5, row)


def judged(tmp_path, cases, times):
    """The verdicts on the cases of an experiment."""
    measured = [Measured(c, {"k_con": t}) for c, t in zip(cases, times, strict=True)]
    return verdicts(small(tmp_path), measured)


def test_verdicts_in_a_word(tmp_path):
    cases = [case(50.0), case(60.0), case(60.0, "why"), Case(VEM, 5)]
    words = [one.word for one in judged(tmp_path, cases, [[40, 60] * 50] * 4)]
    assert words == ["agrees", "differs", "not reproduced", ""]


@pytest.mark.parametrize(
    ("table", "word", "z"),
    [("not_reproduced", "not reproduced", True), ("not_compared", "", False)],
)
def test_a_measure_may_be_set_aside_for_all_rows(tmp_path, table, word, z):
    experiment = replace(small(tmp_path), **{table: {"k_con": "why"}})
    [one] = verdicts(experiment, [Measured(case(60.0), {"k_con": [40, 60] * 50})])
    assert (one.word, one.why, one.z is not None) == (word, "why", z)


def test_claims_of_a_sweep(tmp_path):
    sweep = Sweep(
        model="vem", agents=[5], parameter="p", values=[1.0, 2.0, 3.0], trend="falls", flat_from=2.0
    )
    cases = [Case(VEM.but(parameters={"p": value}), 5, sweep=sweep) for value in sweep.values]

    def holds(*means):
        times = [[mean + n for n in (-1, 0, 1) * 5] for mean in means]
        return [one.holds for one in claims(judged(tmp_path, cases, times))]

    assert holds(100, 50, 49) == [True, True]
    assert holds(100, 50, 20) == [True, False]
    assert holds(50, 50, 50) == [False, True]
    assert holds(50, 100, 100) == [False, True]
