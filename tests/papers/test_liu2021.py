"""Liu et al. 2021, section 3.1, in small: N = 100 with fixed seeds, wide bands.

Means are those of the reading (100 to 1000 runs, an independent implementation); a band is four
standard errors of the means measured here.
"""

import math
from dataclasses import replace

import pytest

from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_experiment
from app.studies.judge.judge import ranges_of
from app.studies.judge.statistics import summary

RUNS = 30
READING = {"vem": 85.5, "ivem": 55.7, "wvem": 109.2, "hwvem": 12.0, "vem-a": 575.5}
MINIMUM_IMAGE = 6.5
"""HWVEM at N = 100 where neighbours are seen across the seam."""


def difference(a, b):
    """Mean of b minus mean of a, with its standard error."""
    return b.mean - a.mean, math.hypot(a.standard_error, b.standard_error)


def times(experiment, folder, runs=RUNS):
    """Summary of the runs of each case."""
    done = run_experiment(
        experiment, folder, runs=runs, seed=1, workers=2, tell=None, at=lambda *_: None
    )
    return [(one.case, summary(ranges_of(one.values["k_con"]))) for one in done.measured]


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """Table 1 for N = 100 and the models that are quick, by model."""
    experiment = read_experiment("liu2021-table1").select(list(READING), [100])
    return {case.spec.model: s for case, s in times(experiment, tmp_path_factory.mktemp("table"))}


@pytest.mark.parametrize("model", READING)
def test_means_are_those_of_the_reading(table, model):
    s = table[model]
    assert s.absent == 0
    assert abs(s.mean - READING[model]) < 4.0 * s.standard_error


def test_means_are_those_of_the_paper(table):
    for case in read_experiment("liu2021-table1").select(list(READING), [100]).cases:
        s = table[case.spec.model]
        assert abs(s.mean - case.published("k_con").mean) < 4.0 * s.sd * (1 / RUNS + 1 / 100) ** 0.5


def test_hierarchy_beats_weights_and_weights_beat_none(table):
    assert table["hwvem"].quartiles[2] < table["wvem"].quartiles[0]
    assert table["wvem"].quartiles[2] < table["vem-a"].quartiles[0]


def test_plain_distance_is_what_the_paper_has(tmp_path):
    whole = read_experiment("liu2021-table1").select(["hwvem"], [100])
    [case] = whole.cases
    across = replace(whole, cases=[replace(case, spec=case.spec.but(world="wrap"))])
    [(_, s)] = times(across, tmp_path)
    assert abs(s.mean - MINIMUM_IMAGE) < 4.0 * s.standard_error
    assert abs(s.mean - whole.cases[0].published("k_con").mean) > 20.0 * s.standard_error


def test_figure_5_trends(tmp_path):
    experiment = read_experiment("liu2021-fig5").select([], [100])
    ends = [c for c in experiment.cases if c.value in (c.sweep.values[0], c.sweep.values[-1])]
    found = times(replace(experiment, cases=ends), tmp_path, runs=60)
    by_value = {(case.sweep.parameter, case.value): s for case, s in found}
    rise, _ = difference(by_value["p1", 0.0], by_value["p1", 2.0])
    fall, error = difference(by_value["p2", 1.0], by_value["p2", 100.0])
    assert rise > 0.5
    assert fall < -10.0 * error


def test_figure_6_the_neighbourhood_weight_saves_about_3_ticks(tmp_path):
    experiment = read_experiment("liu2021-fig6").select([], [100])
    [(_, on), (_, off)] = times(experiment, tmp_path, runs=60)
    cost, error = difference(on, off)
    assert abs(cost - 3.0) < 4.0 * error
    assert cost > 3.0 * error
