"""The runs of an experiment are kept: what is there is not run again, whatever was lost is."""

import math
import sqlite3

import pytest

from agents import Flock
from agents.individuals import normal
from app.studies.experiment_runner import fingerprint, run_experiment
from app.studies.runs.database import FILE
from app.studies.runs.store import Store
from app.studies.runs.store_reader import StoreReader
from app.studies.study_runner import STOP
from experiments.small import TEXT, small
from worlds.input_error import InputError


def carry_out(experiment, folder, runs=4, seed=1, workers=2):
    return run_experiment(
        experiment, folder, runs=runs, seed=seed, workers=workers, tell=None, at=lambda *_: None
    )


def times(done):
    """k_con of each case's runs."""
    return [one.values["k_con"] for one in done.measured]


def test_a_rerun_takes_what_is_there(tmp_path):
    experiment = small(tmp_path)
    first = carry_out(experiment, tmp_path)
    assert (first.made, first.taken) == (8, 0)
    stored = StoreReader(tmp_path).runs()
    again = carry_out(experiment, tmp_path)
    assert (again.made, again.taken) == (0, 8)
    assert StoreReader(tmp_path).runs() == stored
    assert times(again) == times(first)
    more = carry_out(experiment, tmp_path, runs=6)
    assert (more.made, more.taken) == (4, 8)
    assert [one[:4] for one in times(more)] == times(first)


def test_agents_that_differ_do_so_in_every_run(tmp_path):
    experiment = small(tmp_path, TEXT.replace("eta = 0.0", "eta.normal = [0.2, 0.1]"))
    done = carry_out(experiment, tmp_path)
    case = experiment.cases[0]
    measured = []
    for seed in range(1, 5):
        flock = Flock("vem", agents=12, size=1.7, world="wrap", eta=normal(0.2, 0.1), rng=seed)
        measured.append(experiment.settings.run(flock, lambda: None)["k_con"])
    assert case.spec.individuals == {"eta": normal(0.2, 0.1)}
    assert times(done)[0] == measured
    assert carry_out(experiment, tmp_path).made == 0


def test_only_what_is_not_there_is_run_again(tmp_path):
    experiment = small(tmp_path)
    whole = carry_out(experiment, tmp_path, workers=1)
    connection = sqlite3.connect(tmp_path / FILE)
    with connection:
        connection.execute("DELETE FROM run WHERE seed = 3 AND cell = 1")
    connection.close()
    again = carry_out(experiment, tmp_path)
    assert (again.made, again.taken) == (1, 7)
    assert times(again) == times(whole)


def test_processes_make_the_same_numbers(tmp_path, monkeypatch):
    here = carry_out(small(tmp_path), tmp_path / "here")
    monkeypatch.setattr("app.studies.workers.thread_executor.SHARE", math.inf)
    there = carry_out(small(tmp_path), tmp_path / "there")
    assert there.measured == here.measured


@pytest.mark.parametrize(
    ("before", "after"),
    [("hold = 5", "hold = 6"), ('"wrap"', '"wrap-plain"'), ("12 = 1.7", "12 = 1.8")],
)
def test_other_settings_are_other_runs(tmp_path, before, after):
    experiment, other = small(tmp_path), small(tmp_path, TEXT.replace(before, after))
    prints = [fingerprint(one.cases[0], one.settings) for one in (experiment, experiment, other)]
    assert prints[0] == prints[1] != prints[2]


def test_a_parameter_out_of_range_names_the_experiment(tmp_path):
    experiment = small(tmp_path, TEXT.replace("p2 = 7.0", "p2 = 0.5"))
    with pytest.raises(InputError, match=r"p2 = 0.5 is outside .* \(small, hwvem with N = 20\)"):
        carry_out(experiment, tmp_path)


def test_a_paper_stops_when_it_is_asked_to_and_goes_on_later(tmp_path):
    experiment = small(tmp_path)

    def ask(share, *_):
        if share:  # on a busy machine nothing may be made yet
            (tmp_path / STOP).touch()

    with pytest.raises(KeyboardInterrupt):
        run_experiment(experiment, tmp_path, runs=4000, seed=1, workers=1, tell=None, at=ask)
    assert StoreReader(tmp_path).state["progress"] is None
    again = carry_out(experiment, tmp_path, runs=4000)
    assert 0 < again.taken < 8000
    assert again.made + again.taken == 8000


def test_a_paper_leaves_the_runs_of_a_sweep_alone(tmp_path):
    experiment = small(tmp_path)
    folder = tmp_path / "sweep"
    with Store(folder, []) as store:
        store.tell(kind="sweep")
    with pytest.raises(InputError, match="has other runs: give the paper another folder"):
        carry_out(experiment, folder)
    assert StoreReader(folder).state["kind"] == "sweep"
