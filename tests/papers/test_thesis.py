"""The thesis's chapter 5 in small: crashes and groups of a few runs with fixed seeds.

Shares are those of the reading (40 runs of an independent implementation).
"""

import math

import pytest

from app.studies.claims.claims import claims, verdicts
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_experiment
from app.studies.judge.judge import ranges_of
from app.studies.judge.statistics import summary

RUNS = 24
READING = {100: 8.1, 500: 3.8, 1500: 2.0, 3000: 1.3}
"""Groups of the literal zones, by tick."""
ONE = 0.7
"""Share of the runs of the literal zones that end as one group."""


def carried_out(name, folder, labels, runs=RUNS):
    """Verdicts of the rows with these labels, and the claims about them."""
    experiment = read_experiment(name).select(labels, [])
    done = run_experiment(
        experiment, folder, runs=runs, seed=1, workers=2, tell=None, at=lambda *_: None
    )
    made = verdicts(experiment, done.measured)
    return made, claims(made, experiment.said)


def values(made, label, measure, tick):
    """The values of a measure in a row at a tick."""
    [found] = [
        one.values
        for one in made
        if (one.case.label, one.measure.name, one.case.tick) == (label, measure, tick)
    ]
    return found


@pytest.fixture(scope="module")
def free(tmp_path_factory):
    """Table 5.1: the literal zones, also with bodies that stay solid."""
    return carried_out("thesis-table5.1", tmp_path_factory.mktemp("free"), ["thesis", "solid"])


def test_crashes_at_tick_0_are_as_many_as_the_thesis_counts_and_none_come_later(free):
    made, said = free
    [row] = [
        one
        for one in made
        if (one.case.label, one.measure.name, one.case.last) == ("thesis", "at_0", True)
    ]
    assert row.published.average == 6.6
    assert row.word == "undecided", "five published runs tell little"
    assert abs(row.comparison.z) < 2.0
    assert (
        values(made, "thesis", "early", 3000) == values(made, "thesis", "late", 3000) == [0] * RUNS
    )
    assert [claim.word for claim in said] == ["by construction", "does not hold"]


@pytest.mark.parametrize("tick", READING)
def test_groups_become_fewer_as_in_the_reading(free, tick):
    s = summary(ranges_of(values(free[0], "thesis", "groups", tick)))
    error = s.sd * math.sqrt(1.0 / RUNS + 1.0 / 40.0)
    assert abs(s.mean - READING[tick]) < 4.0 * error


def test_most_runs_end_as_one_group_that_flies_one_way(free):
    one = values(free[0], "thesis", "one", 3000)
    share = sum(one) / (100.0 * RUNS)
    assert abs(share - ONE) < 4.0 * math.sqrt(ONE * (1.0 - ONE) * (1.0 / RUNS + 1.0 / 40.0))
    assert summary(ranges_of(values(free[0], "thesis", "p", 3000))).mean > 0.98


def test_bodies_that_stay_solid_crash_43_of_50(free):
    counts = [values(free[0], "solid", measure, 3000) for measure in ("at_0", "early", "late")]
    total = summary(ranges_of([sum(run) for run in zip(*counts, strict=True)]))
    assert abs(total.mean - 43.0) < 4.0 * total.standard_error
