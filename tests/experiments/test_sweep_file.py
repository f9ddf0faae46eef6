"""A sweep's file: every cell is checked before anything runs; a refusal says where it is from."""

import re

import pytest

from agents.individuals import lognormal, normal, uniform
from app.studies.key_lines import KeyLocations
from app.studies.sweeps.checked_sweep import read_sweep, sweep_of
from worlds.input_error import InputError

TEXT = """
[run]
model = "hwvem"
agents = 20
world = "wrap-plain"
size = 2.2
ticks = 100
parameters = { eta = 0.0 }
[stop]
when = "consistency >= 0.9984"
hold = 5
[[design]]
kind = "grid"
[design.axes]
p1 = [0.0, 0.1]
[[design]]
kind = "list"
rows = [{ p2 = 7.0, agents = 30 }]
[replicates]
count = 3
[[observe]]
name = "polarisation"
[[observe]]
name = "polarisation"
over = 10
"""


def read(folder, *changes, text=TEXT):
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    path = folder / "s.toml"
    path.write_text(text)
    return read_sweep(path)


def test_joined_designs_make_one_plan(tmp_path):
    sweep = read(tmp_path)
    assert [cell.axes for cell in sweep.cells] == [
        {"p1": 0.0},
        {"p1": 0.1},
        {"p2": 7.0, "agents": 30},
    ]
    assert (sweep.axes, sweep.making.columns) == (
        ["p1", "p2", "agents"],
        ["k", "polarisation", "polarisation-over-10"],
    )
    assert [cell.spec.agents for cell in sweep.cells] == [20, 20, 30]
    assert list(sweep.seeds(sweep.cells[0], 3)) == [1, 2, 3]


def test_distinct_seeds_are_no_others_and_stay_with_their_cell(tmp_path):
    distinct = ("count = 3", 'count = 3\nseeds = "distinct"')
    sweep = read(tmp_path, distinct)
    seeds = [set(sweep.seeds(cell, 1000)) for cell in sweep.cells]
    assert len(set.union(*seeds)) == 3000
    more = read(tmp_path, distinct, ("[0.0, 0.1]", "[0.05, 0.0, 0.1]"))
    assert set(more.seeds(more.cells[1], 1000)) == seeds[0]


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("[0.0, 0.1]", "[0.0, 9.5]", r"p1 = 9.5 is outside \[0, 2\] .*s.toml, line 15; cell 2: p1"),
        ("p2 = 7.0", "p9 = 7.0", r"unknown parameter 'p9'.*\(.*s.toml, line 18; cell 3: p9 = 7.0"),
        ("agents = 30", "agents = 0", r"agents = 0 is not allowed.*line 18"),
        ("eta = 0.0", "eta = 99", r"eta = 99.* is outside .*line 8"),
        ('"hwvem"', '"hwven"', r"unknown model 'hwven': did you mean 'hwvem'.*line 3"),
        ('"wrap-plain"', '"wrapp"', r"unknown world 'wrapp'.*line 5"),
        ("hold = 5", "hold = 0", r"stop.hold: a number >= 1 is needed \(.*s.toml, line 11\)"),
        ('"consistency >=', '"consistencie >=', r"unknown observable 'consistencie'.*line 10"),
        ("over = 10", "over = 1000", r"over = 1000 is more than ticks = 100"),
        ("over = 10", "", r"column 'polarisation' is there twice"),
        ("count = 3", "cuont = 3", r"replicates.cuont: there is no such key \(.*line 20\)"),
        ("ticks = 100", "ticks = 100\nseed = 3", r"seed: the seeds of a sweep are first and seeds"),
        ('kind = "list"', 'kind = "lists"', r"'grid', 'list', 'csv'.* is needed"),
        ("p1 = [0.0, 0.1]", "p1 = { from = 0 }", r"p1"),
        ("over = 10", "over = 10\n[[record]]\nwhere = 'p9 > 1'", r"unknown axis 'p9'"),
        (
            "count = 3",
            "count = 3\nprecision = { observable = 'x', within = 1, most = 9 }",
            r"unknown column 'x' \(known: k, polarisation",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_its_place(tmp_path, before, after, said):
    with pytest.raises(InputError, match=said):
        read(tmp_path, (before, after))


def test_an_axis_is_no_column_of_the_table_of_runs(tmp_path):
    with pytest.raises(InputError, match=r"axis 'p1' is not allowed: .*s.toml, line 15"):
        read(tmp_path, ("over = 10", 'column = "p1"'))


def test_a_condition_names_its_line(tmp_path):
    with pytest.raises(InputError, match=r"unknown axis 'p7'.*s.toml, line 14\)"):
        read(tmp_path, ('kind = "grid"', 'kind = "grid"\nwhere = "p1 > p7"'))


def test_measures_of_ones_own_are_found_beside_the_file(tmp_path):
    (tmp_path / "mine.py").write_text("def width(flock):\n    return flock.position[:, 0].std()\n")
    own = ('name = "polarisation"\nover', 'measure = "mine.py:width"\nover')
    assert read(tmp_path, own).making.columns[-1] == "width-over-10"
    with pytest.raises(InputError, match="'depth': there is no such function"):
        read(tmp_path, (own[0], own[1].replace("width", "depth")))
    with pytest.raises(InputError, match="FUNCTION is needed"):
        read(tmp_path, (own[0], own[1].replace("mine.py:", "")))


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("hold = 5", "hold = 6"),
        ("ticks = 100", "ticks = 101"),
        ("eta = 0.0", "eta = 0.1"),
        ('"wrap-plain"', '"wrap"'),
        ("over = 10", "over = 9"),
    ],
)
def test_whatever_changes_numbers_makes_other_cells(tmp_path, before, after):
    first, again = read(tmp_path), read(tmp_path)
    other = read(tmp_path, (before, after))
    assert [one.hash for one in first.cells] == [one.hash for one in again.cells]
    assert not {one.hash for one in first.cells} & {one.hash for one in other.cells}


# Means and spreads of what agents differ in.

FIRST_SEED, OTHER_FIRST_SEED = 75737596230107136, 351289557430304768
DIFFER = """
[run]
model = "vem"
agents = 10
ticks = 5
parameters = { v0 = { lognormal = [0.03, 0.01] } }
[[design]]
kind = "grid"
where = "v0.spread < 0.02 or v0.mean > 0.04"
[design.axes]
v0.spread = { from = 0, to = 0.02, count = 2 }
"v0.mean" = [0.04, 0.05]
[[observe]]
name = "polarisation"
"""


def test_an_axis_is_a_mean_or_a_spread_of_what_agents_differ_in(tmp_path):
    """With quotes or without; the distribution keeps its kind, a plain number becomes normal."""
    sweep = read(tmp_path, text=DIFFER)
    assert sweep.axes == ["v0.spread", "v0.mean"]
    numbers = [(0.04, 0.0), (0.05, 0.0), (0.05, 0.02)]
    assert [cell.spec.individuals["v0"] for cell in sweep.cells] == [
        lognormal(*both) for both in numbers
    ]
    assert [cell.spec.parameters["v0"] for cell in sweep.cells] == [0.04, 0.05, 0.05]
    half = read(tmp_path, ("{ lognormal = [0.03, 0.01] }", '"uniform:0.02:0.06"'), text=DIFFER)
    assert [cell.spec.individuals["v0"] for cell in half.cells] == [
        uniform(mean - spread, mean + spread) for mean, spread in numbers
    ]
    plain = read(tmp_path, ("{ lognormal = [0.03, 0.01] }", "0.01"), text=DIFFER)
    assert [cell.spec.individuals["v0"] for cell in plain.cells] == [
        normal(*both) for both in numbers
    ]


def test_a_spread_is_about_the_number_of_the_run_and_a_mean_alone_is_a_number(tmp_path):
    changes = ("where", "# where"), ('"v0.mean"', "eta"), ("{ lognormal = [0.03, 0.01] }", "0.01")
    spread = read(tmp_path, *changes, text=DIFFER).cells[-1].spec
    assert spread.individuals == {"v0": normal(0.01, 0.02)}
    by_default = read(
        tmp_path, *changes[:2], ("v0 = { lognormal = [0.03, 0.01] }", ""), text=DIFFER
    )
    assert by_default.cells[-1].spec.individuals == {"v0": normal(0.03, 0.02)}
    mean = read(tmp_path, changes[0], ("v0.spread", "eta"), changes[2], text=DIFFER).cells[-1].spec
    assert (mean.individuals, mean.parameters["v0"]) == ({}, 0.05)


def test_a_number_as_an_axis_is_of_all_agents_and_text_may_be_a_distribution(tmp_path):
    changes = (
        ("where", "# where"),
        ("v0.spread", "eta"),
        ('"v0.mean" = [0.04, 0.05]', "v0 = VALUES"),
    )
    values = '[0.04, "normal(0.03, 0.01)"]'
    cells = read(tmp_path, *changes, ("VALUES", values), text=DIFFER).cells
    assert [cell.spec.individuals for cell in cells[:2]] == [{}, {"v0": normal(0.03, 0.01)}]
    assert [cell.axes["v0"] for cell in cells[:2]] == [0.04, "normal(0.03, 0.01)"]


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("from = 0,", "from = -1,", r"v0.spread = -1 length/tick is not allowed: .*, line 11;"),
        ("v0.spread =", "v9.spread =", r"v9.spread: unknown parameter 'v9'.*, line 11;"),
        ("v0.spread =", "k.spread =", r"k.spread: k cannot differ .* as many nearest .*, line 11;"),
        ("[0.04, 0.05]", "[9.0]", r"v0.mean = 9 length/tick is outside \[0, 1\].*, line 12;"),
        ("[0.04, 0.05]", "[0.0]", r"v0.spread: lognormal.* mean .* is > 0.*, line 11;"),
        ("[0.04, 0.05]", "['x']", r"v0.mean = 'x' is not allowed: a number is needed.*, line 12;"),
        ("lognormal", "one_of", r"v0.spread: one_of\(0.03, 0.01\) has no mean and no spread to"),
        ("{ lognormal =", "{ each =", r"v0.spread: each of 2 agents has no mean and no spread to"),
("v0.spread =", 'v0 = [0.1]\n"v0.spread" =', r"v0.spread is not allowed beside v0.* line 12;"),
        ("{ lognormal = [0.03, 0.01] }", "{ gauss = [1] }", r"run.parameters.v0: unknown .*line 6"),
        ("{ lognormal = [0.03, 0.01] }", "'normal(1)'", r"v0: normal.* are needed.*line 6"),
    ],
)  # fmt: skip
def test_a_mean_or_a_spread_that_cannot_be_is_refused_with_its_place(tmp_path, before, after, said):
    with pytest.raises(InputError, match=said) as refusal:
        read(tmp_path, ("where", "# where"), (before, after), text=DIFFER)
    assert all("s.toml" in line for line in str(refusal.value).splitlines())


def test_agents_that_differ_make_other_cells_and_alike_ones_those_of_before(tmp_path):
    """The seeds that follow from what a cell is were written down before agents could differ."""
    alike = ("parameters =", "# parameters ="), ("where", "# where")
    axes = ("v0.spread", "eta"), ('"v0.mean" = [0.04, 0.05]', "agents = [10, 20]")
    plain = read(tmp_path, *alike, *axes, text=DIFFER).cells
    assert [cell.first_seed for cell in plain[:2]] == [FIRST_SEED, OTHER_FIRST_SEED]
    assert all("individuals" not in cell.identity["spec"] for cell in plain)
    lognormal, again = read(tmp_path, text=DIFFER).cells, read(tmp_path, text=DIFFER).cells
    assert [cell.hash for cell in lognormal] == [cell.hash for cell in again]
    normal = read(tmp_path, ("lognormal", "normal"), text=DIFFER).cells
    shared = read(tmp_path, *alike, axes[0], ('"v0.mean"', "v0"), text=DIFFER).cells
    cells = [*plain, *lognormal, *normal, *shared]
    assert len({cell.hash for cell in cells}) == len({cell.first_seed for cell in cells}) == 14


def test_numbers_that_are_drawn_again_are_told_of_once(tmp_path):
    told = []
    read(tmp_path, ("to = 0.02", "to = 1.0"), ("{ lognormal = [0.03, 0.01] }", "0.1"), text=DIFFER)
    read_sweep(tmp_path / "s.toml", told.append)
    assert len(told) == 1
    assert re.fullmatch(r"flockscope: v0 = normal\(0.05, 1\): \d+ numbers of 10 drawn .*", told[0])


def test_a_file_from_options_keeps_the_order_of_axes(tmp_path):
    span = {"from": 0.0, "to": 0.02, "count": 2}
    axes = {"v0.spread": span, "v0.mean": [0.04, 0.05]}
    values = {
        "run": {"model": "vem", "agents": 10, "ticks": 5},
        "design": [{"kind": "grid", "axes": axes}],
    }
    sweep = sweep_of(values, KeyLocations("the command line"), tmp_path)
    (tmp_path / "s.toml").write_text(sweep.text)
    assert [cell.axes for cell in read_sweep(tmp_path / "s.toml").cells] == [
        cell.axes for cell in sweep.cells
    ]
