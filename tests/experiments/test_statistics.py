"""Means, quartiles, z-scores, verdicts: exact cases."""

import math

import numpy as np
import pytest

from app.experiments.conduct import Measured
from app.experiments.experiment import Cell, Row, Sweep
from app.experiments.statistics import difference, summary, z_score
from app.experiments.verdict import claims, verdicts


def test_summary_of_known_numbers():
    s = summary([2, 4, 4, 4, 5, 5, 7, 9])
    assert (s.runs, s.given_up, s.mean, s.median) == (8, 0, 5.0, 4.5)
    assert s.sd == pytest.approx(math.sqrt(32 / 7))
    assert s.quartiles == (4.0, 4.5, 5.5)
    assert s.standard_error == pytest.approx(math.sqrt(32 / 7 / 8))


def test_runs_that_were_given_up_are_counted_and_left_out():
    s = summary([10, None, 20, None])
    assert (s.runs, s.given_up, s.mean) == (2, 2, 15.0)


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


def cell(mean, why=""):
    row = Row(model="vem", agents=5, mean=mean, not_reproduced=why)
    return Cell("vem", 5, 1.0, {}, row)


def test_verdicts_in_a_word():
    times = [40, 60] * 50
    cells = [cell(50.0), cell(60.0), cell(60.0, "why"), Cell("vem", 5, 1.0, {})]
    words = [one.word for one in verdicts([Measured(c, times) for c in cells])]
    assert words == ["agrees", "differs", "not reproduced", ""]


def test_claims_of_a_sweep():
    sweep = Sweep(
        model="vem", agents=[5], parameter="p", values=[1.0, 2.0, 3.0], trend="falls", flat_from=2.0
    )
    cells = [Cell("vem", 5, 1.0, {"p": value}, sweep=sweep) for value in sweep.values]

    def holds(*means):
        noise = (-1, 0, 1) * 5
        measured = [
            Measured(c, [mean + n for n in noise]) for c, mean in zip(cells, means, strict=True)
        ]
        return [one.holds for one in claims(verdicts(measured))]

    assert holds(100, 50, 49) == [True, True]
    assert holds(100, 50, 20) == [True, False]
    assert holds(50, 50, 50) == [False, True]
    assert holds(50, 100, 100) == [False, True]
