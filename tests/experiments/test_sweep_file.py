"""A sweep's file: every cell is checked before anything runs; a refusal says where it is from."""

import pytest

from app.studies.sweeps.checked_sweep import read_sweep
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
