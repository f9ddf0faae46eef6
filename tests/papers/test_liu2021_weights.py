"""The outlook of Liu et al. 2021: small searches of weights; `flockscope paper` has full ones."""

import pytest

from app.studies.experiment import flock_of
from app.studies.experiment_reader import read_experiment
from app.studies.experiment_runner import run_cases
from worlds.input_error import InputError

SMALL = {"evaluations": 12, "population": 4, "seeds": 3, "fresh": 10}


def run(name, seed=1, **more):
    experiment = read_experiment(name)
    settings = experiment.settings.model_copy(update=SMALL | more)
    case = experiment.cases[0]
    (result,) = run_cases(flock_of(case, seed), [case], settings)
    assert list(result.measures) != []
    assert set(result.measures) == {one.name for one in settings.measures}
    return result.measures


def test_two_searches_agree_on_the_value_and_stand_on_the_plateau():
    found = run("liu2021-weights")
    assert found["ga_gain"] == pytest.approx(3.0, abs=1.2)
    assert found["pso_gain"] == pytest.approx(3.0, abs=1.2)
    assert found["apart"] < 0.3
    assert found["flat"] < 0.4
    assert found["default"] - found["plateau"] > 1.5
    assert (found["ga_p1"], found["ga_p2"]) != (found["pso_p1"], found["pso_p2"])


def test_the_calm_end_of_a_front_is_slower():
    found = run("liu2021-tradeoff", evaluations=24, population=8)
    assert found["slower"] > 2.0
    assert found["calmer"] > 0.0005
    assert found["quick_p2"] > found["calm_p2"]
    assert found["quick_deg"] == pytest.approx(0.981, abs=0.002)


def test_searches_of_two_seeds_share_no_run():
    experiment = read_experiment("liu2021-weights")
    settings, case = experiment.settings, experiment.cases[0]
    first, second = (flock_of(case, seed) for seed in (1, 2))
    runs = [
        set(of(flock))
        for flock in (first, second)
        for of in (settings.search_seeds, settings.fresh_seeds)
    ]
    assert sum(map(len, runs)) == len(set().union(*runs)) == 2 * (10 + 40)


def test_a_box_rises_and_its_logarithms_are_of_what_is_above_0():
    experiment = read_experiment("liu2021-weights")
    values = experiment.settings.model_dump()
    for wrong in ({"box": {"p1": (2.0, 0.0), "p2": (1.0, 9.0)}}, {"log": ["p1"]}):
        with pytest.raises((ValueError, InputError)):
            type(experiment.settings)(**(values | wrong))
