"""Sensitivity: exact indices of functions that have them, and refusals where SALib prints zeros."""

import numpy as np
import pytest

from app.studies.runs.store_reader import StoreReader
from app.studies.sensitivity.sensitivity_result import (
    Index,
    Influence,
    Sensitivity,
    analyse,
    design_of,
    morris,
    noise_share,
    sobol,
)
from app.studies.sweeps.designs import unit_sample
from app.studies.sweeps.sweep_file import Morris, Saltelli, Span
from app.studies.sweeps.sweep_runner import run_sweep
from experiments.test_sweep_file import read
from worlds.input_error import InputError

ANGLE = Span(**{"from": -np.pi, "to": np.pi})
UNIT = Span(**{"from": 0.0, "to": 1.0})
ZONES = """
[run]
model = "couzin"
agents = 50
dim = 3
world = "open"
size = 8.0
ticks = 300
[[design]]
kind = "saltelli"
points = 64
[design.axes]
dr_o = { from = 0, to = 10 }
dr_a = { from = 2, to = 14 }
sigma = { from = 0, to = 0.3 }
[replicates]
count = 2
[[observe]]
name = "polarisation"
"""


SPREADS = """
[run]
model = "vem"
agents = 5
size = 2.0
ticks = 1
parameters = { eta = 1.0 }
[[design]]
kind = "morris"
trajectories = 3
[design.axes]
eta.spread = { from = 0.0, to = 0.5 }
eta.mean = { from = 1.0, to = 2.0 }
v0.spread = { from = 0.0, to = 0.01 }
[replicates]
count = 2
[[observe]]
measure = "mine.py:mean"
"""


def test_means_and_spreads_matter_as_much_as_they_move_agents_numbers(tmp_path):
    (tmp_path / "mine.py").write_text("def mean(flock):\n    return flock.own['eta'].mean()\n")
    sweep = read(tmp_path, text=SPREADS)
    run_sweep(sweep, tmp_path / "out", workers=2)
    (found,) = analyse(sweep, StoreReader(tmp_path / "out"))
    moved = {influence.axis: influence.total.value for influence in found.influences}
    assert found.influences[0].axis == "eta.mean"
    assert moved["eta.mean"] == pytest.approx(1.0)
    assert 0.0 < moved["eta.spread"] < 0.5
    assert moved["v0.spread"] == 0.0


def ishigami(design):
    """7 sin^2 x2 + (1 + 0.1 x3^4) sin x1, whose indices are known exactly."""
    x1, x2, x3 = (2.0 * np.pi * unit_sample(design) - np.pi).T
    return np.sin(x1) + 7.0 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1)


def angles(points=1024, second_order=False):
    axes = dict.fromkeys(("x1", "x2", "x3"), ANGLE)
    return Saltelli(kind="saltelli", axes=axes, points=points, seed=1, second_order=second_order)


def test_ishigami():
    design = angles()
    influences, pairs = sobol(design, ishigami(design))
    assert [one.alone.value for one in influences] == pytest.approx([0.314, 0.442, 0.0], abs=0.01)
    assert [one.total.value for one in influences] == pytest.approx([0.558, 0.442, 0.244], abs=0.01)
    assert all(0.0 < one.total.half < 0.1 for one in influences)
    assert pairs == []


def test_ishigami_has_one_pair():
    design = angles(second_order=True)
    _, pairs = sobol(design, ishigami(design))
    found = {pair.axes: pair.index.value for pair in pairs}
    assert found[("x1", "x3")] == pytest.approx(0.244, abs=0.05)
    assert found[("x1", "x2")] == pytest.approx(0.0, abs=0.05)


def test_effects_of_a_plane_are_its_slopes():
    design = Morris(kind="morris", axes={"a": UNIT, "b": UNIT}, trajectories=6)
    influences = morris(design, unit_sample(design) @ [3.0, -0.5])
    assert [one.total.value for one in influences] == pytest.approx([3.0, 0.5])
    assert [one.alone.value for one in influences] == pytest.approx([3.0, -0.5])
    assert [one.spread for one in influences] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_what_gives_zeros_is_refused():
    design = angles(8)
    y = ishigami(design)
    hole = y.copy()
    hole[3] = np.nan
    with pytest.raises(InputError, match="1 of 40 cells have no value"):
        sobol(design, hole)
    with pytest.raises(InputError, match="it is 2 in every cell: there is nothing to explain"):
        sobol(design, np.full(40, 2.0))
    ends = np.full(40, 2.0)
    ends[1] = 3.0  # of neither of the two samples that the variance is taken of
    with pytest.raises(InputError, match="nothing to explain"):
        sobol(design, ends)
    with pytest.raises(InputError, match="64 values are not allowed: the design has 40 cells"):
        sobol(design, np.arange(64.0))
    effects = Morris(kind="morris", axes={"a": UNIT}, trajectories=2)
    with pytest.raises(InputError, match="nothing to explain"):
        morris(effects, np.ones(4))


def test_noise_is_the_variance_of_a_mean():
    rng = np.random.default_rng(1)
    cells = rng.normal(0.0, 2.0, 4000)[:, None] + rng.normal(0.0, 1.0, (4000, 4))
    assert noise_share(cells.tolist()) == pytest.approx(0.25 / 4.25, rel=0.05)
    assert noise_share([[1.0], [2.0]]) is None


def test_the_order_in_words():
    influences = [
        Influence("a", Index(0.8, 0.1), Index(0.7, 0.1)),
        Influence("b", Index(0.2, 0.1), Index(0.1, 0.1)),
        Influence("c", Index(0.1, 0.12), Index(0.0, 0.1)),
    ]
    said = list(Sensitivity("order", "sobol", influences, [], 0.3, 40, 4).words())
    assert said == [
        "order depends most on a (S_T 0.80 ± 0.10), then on b (S_T 0.20 ± 0.10), then on c "
        "(S_T 0.10 ± 0.12)",
        "b and c cannot be told apart: their intervals are wider than they are different",
        "no influence is seen of c",
        "each by itself, the axes explain 80% of the variance",
        "chance makes up 30% of the variance between cells: more seeds are needed",
    ]


@pytest.mark.exhaustive
def test_order_of_couzins_zones(tmp_path):
    sweep = read(tmp_path, text=ZONES)
    assert run_sweep(sweep, tmp_path / "a", workers=2).whole
    (found,) = analyse(sweep, StoreReader(tmp_path / "a"))
    first, second, third = found.influences
    assert (first.axis, second.axis, third.axis) == ("dr_o", "dr_a", "sigma")
    assert first.total.value > 0.8
    assert found.noise is not None
    assert found.noise < 0.2


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ('"saltelli"', '"latin-hypercube"', "design latin-hypercube is not allowed: .*line 10"),
        ("count = 2", 'count = 2\nseeds = "distinct"', "needs the same seeds.*line 18"),
        (
            "count = 2",
            'count = 2\n[replicates.precision]\nobservable = "polarisation"\nwithin = 1\nmost = 9',
            "needs the same seeds.*line 19",
        ),
        ("[[observe]]", '[[observe]]\nwhen = "every 10"', "nothing has one value for each run"),
        ("points = 64", "points = 30", "30 is not a power of two .*line 11"),
    ],
)
def test_designs_without_indices_are_refused(tmp_path, before, after, said):
    with pytest.raises(InputError, match=said):
        design_of(read(tmp_path, (before, after), text=ZONES))


def test_runs_without_a_value_are_refused(tmp_path):
    small = (("points = 64", "points = 2"), ("ticks = 300", "ticks = 5"))
    (tmp_path / "mine.py").write_text(
        "def m(flock):\n    return float('nan') if flock.seed == 2 else 1.0\n"
    )
    for number, (change, said) in enumerate(
        [
            (("[[design]]", '[stop]\nwhen = "polarisation > 2"\n[[design]]'), "20 of 20 runs gave"),
            (('name = "polarisation"', 'measure = "mine.py:m"'), "m cannot be analysed: 10 of 20"),
        ]
    ):
        sweep = read(tmp_path, *small, change, text=ZONES)
        folder = tmp_path / str(number)
        run_sweep(sweep, folder, workers=1, limit=3)
        with pytest.raises(InputError, match="17 of 20 runs are not made yet"):
            analyse(sweep, StoreReader(folder))
        run_sweep(sweep, folder, workers=1)
        with pytest.raises(InputError, match=said):
            analyse(sweep, StoreReader(folder))
