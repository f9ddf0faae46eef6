"""Reading an experiment's TOML file."""

import pytest

from agents.individuals import normal, uniform
from app.package_files import EXPERIMENTS
from app.studies.experiment_reader import experiment_names, read_experiment
from app.studies.experiment_runner import cell_of
from app.studies.key_lines import find_line, place
from experiments.small import TEXT, small
from worlds.input_error import InputError


def test_the_papers_files_are_found():
    assert {"liu2021-table1", "liu2021-fig5", "liu2021-fig6"} <= set(experiment_names())
    assert (EXPERIMENTS / "liu2021-table1.toml").is_file()


def test_table_1_has_18_rows_as_printed():
    table = read_experiment("liu2021-table1")
    printed = {(case.spec.model, case.agents): case.published("k_con").mean for case in table.cases}
    assert len(printed) == 18
    assert printed["vem-a", 500] == 4097.30
    assert printed["hwvem", 100] == 12.23
    marked = {(c.spec.model, c.agents) for c in table.cases if c.published("k_con").expected}
    assert marked == {("ivem", 500), ("ivem-a", 500), ("hwvem", 500)}
    for case in table.cases:
        assert (case.agents + 1) / case.spec.size**2 == pytest.approx(4.102, rel=1e-3)


def test_a_sweep_is_a_cell_for_each_value_and_size():
    figure = read_experiment("liu2021-fig6")
    assert [(case.agents, case.value) for case in figure.cases] == [
        (n, on) for n in (100, 200, 500) for on in (True, False)
    ]
    assert all(case.spec.parameters["p2"] == 5.0 for case in figure.cases)


def test_rows_inherit_the_settings(tmp_path):
    cases = small(tmp_path).cases
    assert cases[0].spec.parameters == {"eta": 0.0}
    assert cases[1].spec.parameters == {"eta": 0.0, "p2": 7.0}


DIFFER = (
    TEXT.replace("eta = 0.0", 'eta = "normal:0.1:0.02"')
    + """
[[sweeps]]
model = "vem"
agents = [12]
parameter = "eta.spread"
values = [0.0, 0.05]
fixed = { v0.uniform = [0.02, 0.04] }
"""
)


def test_agents_of_a_case_may_differ_and_a_sweep_goes_over_a_spread(tmp_path):
    experiment = small(tmp_path, DIFFER)
    own = [case.spec.individuals for case in experiment.cases]
    assert own[:2] == [{"eta": normal(0.1, 0.02)}] * 2
    assert own[2:] == [
        {"eta": normal(0.1, spread), "v0": uniform(0.02, 0.04)} for spread in (0.0, 0.05)
    ]
    assert [case.value for case in experiment.cases[2:]] == [0.0, 0.05]
    cells = [cell_of(case, experiment) for case in experiment.cases]
    assert '"eta":"normal(0.1, 0.02)"' in cells[0][1]
    plain = small(tmp_path)
    cells += [cell_of(case, plain) for case in plain.cases]
    assert len({key for key, _ in cells}) == 6
    with pytest.raises(InputError, match=r"has no place along an axis: vary eta.mean and eta.spr"):
        small(
            tmp_path, DIFFER.replace('eta.spread"\nvalues = [0.0,', 'eta"\nvalues = ["normal:1:1",')
        )


def test_narrowing(tmp_path):
    whole = small(tmp_path)
    assert [case.spec.model for case in whole.select(["vem"], []).cases] == ["vem"]
    assert [case.agents for case in whole.select([], [20]).cases] == [20]
    with pytest.raises(InputError, match="unknown agents '13'"):
        whole.select([], [13])


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("runs = 4", "runs = 0", ["runs", "a number >= 1 is needed", "line 5"]),
        ("hold = 5", "hold = 0", ["settings.hold", "line 10"]),
        ("desired = 0.9984", "desired = nan", ["settings.desired", "line 9"]),
        ("k_con.mean", "k_con.maen", ["rows.published.k_con.maen", "there is no such key"]),
        ("published.k_con", "published.k_kon", ["unknown measure 'k_kon'", "'k_con'"]),
        ('title = "Small"', 'kind = "misson"', ["unknown kind of experiment", "line 2"]),
        ('picture = "models"', 'picture = "modles"', ["unknown picture 'modles'", "'models'"]),
        ("agents = 12", "agents = 0", ["rows.agents", "line 22"]),
        ("12 = 1.7", "", ["agents = 12 has no side in [sizes]"]),
        ('title = "Small"', "title =", ["is not TOML", "line 2"]),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(tmp_path, before, after, words):
    with pytest.raises(InputError) as refusal:
        small(tmp_path, TEXT.replace(before, after, 1))
    for word in [*words, str(tmp_path / "small.toml")]:
        assert word in str(refusal.value)


def test_lines_of_keys():
    text = 'a = 1\n[t]\na = 2\n"b c" = 3\n[[rows]]\na = 4\n[u]\nx = { a = 5, b = 6 }\n'
    assert find_line(text, "a") == 1
    assert find_line(text, "a", "t") == 3
    assert find_line(text, "b c", "t") == 4
    assert find_line(text, "a", "rows") == 6
    assert find_line(text, "b", "x") == 8
    assert find_line(text, "c") is None
    assert place("f.toml", text, "c") == "f.toml"
    assert place("f.toml", text, "a", "t") == "f.toml, line 3"
