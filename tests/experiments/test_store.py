"""The store of runs: what is in it is not run again, what a kill has torn is cut off."""

import csv

import pytest

from agents.spec import Spec
from app.experiments.conduct import conduct
from app.experiments.experiment import Case
from app.experiments.kinds import Convergence
from app.experiments.store import Store, key_of
from app.experiments.trial import Result, fingerprint
from experiments.small import TEXT, small
from worlds.refusal import Refusal

MEASURES = Convergence.measures
COLUMNS = ("model", "agents", "parameters", "seed", "fingerprint", "k_con", "seconds", "astray")
CASE = Case(Spec("vem", agents=12, size=1.7, parameters={"eta": 0.0, "r": 1.0}), 12)


def carry_out(experiment, folder, runs=4, seed=1, workers=2):
    return conduct(
        experiment, folder, runs=runs, seed=seed, workers=workers, tell=None, at=lambda *_: None
    )


def times(done):
    """k_con of each case's runs."""
    return [one.values["k_con"] for one in done.measured]


def lines_of(folder):
    with open(folder / "runs.csv", newline="") as file:
        return list(csv.reader(file))


def test_what_is_added_is_read_back(tmp_path):
    path = tmp_path / "deep" / "runs.csv"
    with Store(path, MEASURES) as store:
        store.add(key_of(CASE, 3, "abc"), Result({"k_con": 17}, 0.25))
        assert path.read_text().endswith("abc,17,0.250000,\n"), "each line is written at once"
        store.add(key_of(CASE, 4, "abc"), Result({"k_con": None}, 0.5))
    with Store(path, MEASURES) as store:
        assert store.results == {
            key_of(CASE, 3, "abc"): Result({"k_con": 17}, 0.25),
            key_of(CASE, 4, "abc"): Result({"k_con": None}, 0.5),
        }


@pytest.mark.parametrize("torn", ['vem,12,"{""et', "vem", "vem,12,{},5,abc,1"])
def test_a_torn_last_line_is_cut_off(tmp_path, torn):
    path = tmp_path / "runs.csv"
    with Store(path, MEASURES) as store:
        store.add(key_of(CASE, 3, "abc"), Result({"k_con": 17}, 0.25))
    whole = path.read_bytes()
    path.write_bytes(whole + torn.encode())
    with Store(path, MEASURES) as store:
        assert list(store.results) == [key_of(CASE, 3, "abc")]
        assert path.read_bytes() == whole
        store.add(key_of(CASE, 4, "abc"), Result({"k_con": 18}, 0.25))
    with Store(path, MEASURES) as store:
        assert len(store.results) == 2


def test_a_torn_header_is_written_again(tmp_path):
    path = tmp_path / "runs.csv"
    path.write_text("model,agen")
    with Store(path, MEASURES):
        pass
    assert path.read_text() == ",".join(COLUMNS) + "\n"


@pytest.mark.parametrize("content", [b"a,b,c\n1,2,3\n", b"\xff\xfe\x00\n", b"%PDF\n"])
def test_another_file_is_refused_and_left_alone(tmp_path, content):
    path = tmp_path / "runs.csv"
    path.write_bytes(content)
    with pytest.raises(Refusal, match="is not a store of runs"), Store(path, MEASURES):
        pass
    assert path.read_bytes() == content


def test_a_wrong_line_is_named(tmp_path):
    path = tmp_path / "runs.csv"
    path.write_text(",".join(COLUMNS) + "\nvem,12,{},x,abc,17,0.1\n")
    with pytest.raises(Refusal, match=r"line 2 of .*runs.csv"), Store(path, MEASURES):
        pass


def test_a_rerun_takes_what_is_there(tmp_path):
    experiment = small(tmp_path)
    first = carry_out(experiment, tmp_path)
    assert (first.made, first.taken) == (8, 0)
    stored = lines_of(tmp_path)
    again = carry_out(experiment, tmp_path)
    assert (again.made, again.taken) == (0, 8)
    assert lines_of(tmp_path) == stored
    assert times(again) == times(first)
    more = carry_out(experiment, tmp_path, runs=6)
    assert (more.made, more.taken) == (4, 8)
    assert [one[:4] for one in times(more)] == times(first)


def test_only_what_a_kill_has_torn_is_run_again(tmp_path):
    experiment = small(tmp_path)
    whole = carry_out(experiment, tmp_path, workers=1)
    path = tmp_path / "runs.csv"
    path.write_bytes(path.read_bytes()[:-5])
    again = carry_out(experiment, tmp_path)
    assert (again.made, again.taken) == (1, 7)
    assert times(again) == times(whole)


def test_the_number_of_workers_changes_no_number(tmp_path):
    made = [
        carry_out(small(tmp_path), tmp_path / str(workers), workers=workers).measured
        for workers in (1, 3)
    ]
    assert made[0] == made[1]


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
    with pytest.raises(Refusal, match=r"p2 = 0.5 is outside .* \(small, hwvem with N = 20\)"):
        carry_out(experiment, tmp_path)


def test_a_store_of_before_strays_were_looked_for_is_taken_on(tmp_path):
    path = tmp_path / "runs.csv"
    path.write_text(",".join(COLUMNS[:-1]) + '\nvem,12,"{}",3,abc,17,0.25\n')
    with Store(path, MEASURES) as store:
        [(key, result)] = store.results.items()
        assert (key.seed, result) == (3, Result({"k_con": 17}, 0.25))
        store.add(key_of(CASE, 4, "abc"), Result({"k_con": 18}, 0.25, "agent 3 where it cannot be"))
    with Store(path, MEASURES) as store:
        assert [one.astray for one in store.results.values()] == ["", "agent 3 where it cannot be"]
