"""Designs: which cells they make, exactly where that can be said, and by their properties else."""

import numpy as np
import pytest
from pydantic import TypeAdapter

from app.studies.sweeps.designs import points_of
from app.studies.sweeps.sweep_file import AnyDesign
from worlds.input_error import InputError

BOUNDS = {"a": {"from": 0.0, "to": 1.0}, "b": {"from": -2.0, "to": 2.0}}


def made(folder=None, **design):
    return points_of(TypeAdapter(AnyDesign).validate_python(design), folder)


def array(points):
    return np.array([list(point.values()) for point in points], float)


def test_a_grid_changes_its_last_axis_first():
    axes = {"p": [1.0, 2.0], "agents": {"from": 10, "to": 20, "step": 5}}
    points = [(point["p"], point["agents"]) for point in made(kind="grid", axes=axes)]
    assert points == [(1, 10), (1, 15), (1, 20), (2, 10), (2, 15), (2, 20)]
    assert all(isinstance(agents, int) for _, agents in points)


@pytest.mark.parametrize(
    ("axis", "values"),
    [
        ({"from": 0, "to": 0.3, "count": 4}, [0.0, 0.1, 0.2, 0.3]),
        ({"from": 0, "to": 0.3, "step": 0.1}, [0.0, 0.1, 0.2, 0.3]),
        ({"from": 1, "to": 0, "step": 0.4}, [1.0, 0.6, 0.2]),
        ({"from": 1, "to": 100, "count": 3, "scale": "log"}, [1.0, 10.0, 100.0]),
    ],
)
def test_a_span_has_neat_values_and_exact_ends(axis, values):
    assert [point["p"] for point in made(kind="grid", axes={"p": axis})] == values


def test_a_condition_leaves_cells_out():
    axes = {"a": [1, 2, 3], "b": [1, 2, 3]}
    points = made(kind="grid", where="a > b", axes=axes)
    assert [tuple(point.values()) for point in points] == [(2, 1), (3, 1), (3, 2)]
    with pytest.raises(InputError, match="holds for none of 9 cells"):
        made(kind="grid", where="a > 9", axes=axes)


def test_rows_of_a_csv_are_cells(tmp_path):
    (tmp_path / "points.csv").write_text("p, layers\n0.5,instant\n2,delayed\n")
    assert made(tmp_path, kind="csv", file="points.csv") == [
        {"p": 0.5, "layers": "instant"},
        {"p": 2, "layers": "delayed"},
    ]


@pytest.mark.parametrize("text", ["", "p\n", "p,p\n1,2\n", "p,q\n1\n", "p,\n1,2\n"])
def test_another_csv_is_refused(tmp_path, text):
    (tmp_path / "points.csv").write_text(text)
    with pytest.raises(InputError, match=r"points\.csv"):
        made(tmp_path, kind="list", file="points.csv")


def test_a_latin_hypercube_has_one_point_in_each_part():
    points = array(made(kind="latin-hypercube", points=8, seed=3, axes=BOUNDS))
    for column, (low, wide) in zip(points.T, ((0, 1), (-2, 4)), strict=True):
        assert sorted(np.floor(8 * (column - low) / wide)) == list(range(8))
    again = array(made(kind="latin-hypercube", points=8, seed=3, axes=BOUNDS))
    assert (points == again).all()


def test_a_sobol_sequence_is_balanced():
    points = array(made(kind="sobol", points=16, seed=1, axes=BOUNDS))
    assert ((points[:, 0] < 0.5).sum(), (points[:, 1] < 0.0).sum()) == (8, 8)


def test_saltelli_and_morris_have_their_numbers_of_cells():
    assert len(made(kind="saltelli", points=8, axes=BOUNDS)) == 8 * (2 + 2)
    assert len(made(kind="saltelli", points=8, second_order=True, axes=BOUNDS)) == 8 * (2 * 2 + 2)
    points = array(made(kind="morris", trajectories=5, axes=BOUNDS)).reshape(5, 3, 2)
    steps = (np.diff(points, axis=1) != 0.0).sum(axis=2)
    assert (steps == 1).all(), "one axis changes at a time"


def test_words_are_drawn_as_evenly_as_numbers():
    points = made(kind="sobol", points=16, axes={"a": BOUNDS["a"], "world": ["wrap", "open"]})
    assert [point["world"] for point in points].count("wrap") == 8


@pytest.mark.parametrize(
    ("design", "said"),
    [
        ({"kind": "sobol", "points": 12, "axes": BOUNDS}, "12 is not a power of two"),
        ({"kind": "morris", "trajectories": 4, "levels": 5, "axes": BOUNDS}, "5 levels"),
        ({"kind": "list"}, "either rows or file"),
        ({"kind": "sobol", "points": 4, "axes": {"a": {"from": 0, "to": 1, "count": 3}}}, "leave"),
        ({"kind": "grid", "axes": {"a": {"from": 0, "to": 1, "count": 3, "scale": "log"}}}, "log"),
        ({"kind": "grid", "axes": {"a": {"from": 1, "to": 1, "count": 3}}}, "the same"),
        ({"kind": "grid", "axes": {"a": BOUNDS["a"]}}, "a grid needs count or step"),
        (
            {"kind": "saltelli", "points": 4, "where": "a > 0", "axes": BOUNDS},
            "needs all its cells",
        ),
        ({"kind": "grid", "axes": {name: list(range(100)) for name in "abcd"}}, "100000000 cells"),
    ],
)
def test_what_cannot_be_is_refused(design, said):
    with pytest.raises(ValueError, match=said):
        made(**design)
