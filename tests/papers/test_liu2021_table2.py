"""Liu et al. 2021, section 3.2, in small: N = 20 and 50 with fixed seeds, wide bands.

Means are those of the reading (100 runs of an independent implementation, the same scene); a band
is four standard errors of the difference.
"""

import math

import pytest

from agents import Flock
from agents.run_records import fly
from app.studies.claims.claims import claims
from app.studies.judge.verdict import verdicts_on
from papers.flying import flown

RUNS = 24
READING = {
    ("VEM-A", 20): 20,
    ("IVEM-A", 20): 26,
    ("WVEM", 20): 76,
    ("HWVEM-I", 20): 85,
    ("HWVEM-II", 20): 83,
    ("VEM-A", 50): 8,
    ("IVEM-A", 50): 11,
    ("WVEM", 50): 52,
    ("HWVEM-I", 50): 80,
    ("HWVEM-II", 50): 81,
}


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """Table 2 for N = 20 and 50: the experiment and its verdicts."""
    return flown("liu2021-table2", tmp_path_factory.mktemp("table2"), RUNS, [20, 50])


@pytest.mark.parametrize(("label", "agents"), READING)
def test_success_is_that_of_the_reading(table, label, agents):
    [s] = [
        one.summary
        for one in table[1]
        if (one.case.label, one.case.agents, one.measure.name) == (label, agents, "success")
    ]
    assert s.absent == 0
    error = s.sd * math.sqrt(1.0 / RUNS + 1.0 / 100.0)
    assert abs(s.mean - READING[label, agents]) < 4.0 * error


def test_what_the_paper_claims_at_n_50(table):
    experiment, made = table
    found = claims([one for one in made if one.case.agents == 50], experiment.said)
    at_other_sizes = [one for one in experiment.said if one.says == "sizes"]
    assert len(found) == len(experiment.said) - len(at_other_sizes)
    assert [claim.text for claim in found if claim.word == "does not hold"] == []


def test_without_hierarchy_or_weights_most_uavs_get_lost_at_n_20(table):
    rows = [one for one in verdicts_on(table[1], "success") if one.case.agents == 20]
    mean = {one.case.label: one.summary.mean for one in rows}
    assert max(mean["VEM-A"], mean["IVEM-A"]) + 20.0 < mean["WVEM"]
    assert mean["WVEM"] < min(mean["HWVEM-I"], mean["HWVEM-II"])


def test_without_the_guard_uavs_enter_obstacles():
    flock = Flock("hwvem-nav", agents=49, p1=0.1, p2=5.0, guard=False, rng=1)
    assert fly(flock, 1000, every=100).least_obstacle < 0.0
