"""Regions by a paired bootstrap over frames, and what is said of parameters."""

from __future__ import annotations

import numpy as np
import pytest

from agents.catalogue import model
from app.tracks.fit.fit_region import (
    cells_like_best,
    has_moved,
    mean_interval,
    parameter_regions,
)
from app.tracks.fit.fitted_parameter import FittedParameter, fitted_parameters, grid
from worlds.input_error import InputError

VALUES = tuple(float(v) for v in range(11))


def parameter(name="a", values=VALUES, is_floor=False, is_ceiling=False):
    return FittedParameter(name, "length", values, is_floor, is_ceiling)


def test_noise_that_all_cells_share_drops_out():
    rng = np.random.default_rng(1)
    shared = rng.exponential(100.0, 40)
    costs = np.array([shared + extra for extra in (0.0, 0.001, 0.01)])
    assert cells_like_best(costs, 0).tolist() == [True, False, False]
    within_five_percent = costs.mean(axis=1) < 1.05 * costs.mean(axis=1).min()
    assert within_five_percent.all()  # what the rule of thumb would have said


def test_cells_that_differ_by_noise_alone_cannot_be_told_apart():
    rng = np.random.default_rng(2)
    costs = 1.0 + 0.1 * rng.normal(size=(20, 40))
    best = int(costs.mean(axis=1).argmin())
    assert cells_like_best(costs, best).sum() > 5


def test_a_cell_without_costs_is_in_no_region():
    costs = np.array([[1.0, 1.0, 1.0], [np.nan, 1.0, 1.0]])
    assert cells_like_best(costs, 0).tolist() == [True, False]


def test_the_interval_of_a_mean_is_that_of_students_for_many_frames():
    values = np.random.default_rng(3).normal(size=400)
    low, high = mean_interval(values)
    half = 1.96 * values.std(ddof=1) / 20.0
    assert low == pytest.approx(values.mean() - half, abs=0.15 * half)
    assert high == pytest.approx(values.mean() + half, abs=0.15 * half)


@pytest.mark.parametrize(
    ("inside", "floor", "words", "is_told"),
    [
        ([2, 3, 4], False, "a 2 to 4", True),
        ([3], False, "a 3", True),
        ([8, 9, 10], False, "a not told (8 to 10 and above)", False),
        ([0, 1], False, "a not told (0 to 1 and below)", False),
        ([0, 1], True, "a 0 to 1", True),
        ([1, 9], False, "a not told (1 to 9)", False),
    ],
)
def test_what_is_told_of_a_parameter(inside, floor, words, is_told):
    points = np.array(VALUES)[:, None]
    is_like = np.isin(np.arange(11), inside)
    (region,) = parameter_regions([parameter(is_floor=floor)], points, is_like, inside[0])
    assert region.describe() == words
    assert region.is_told is is_told


def test_a_best_that_moves_out_of_the_region_has_moved():
    points = np.array(VALUES)[:, None]

    def regions(inside, best):
        return parameter_regions([parameter()], points, np.isin(np.arange(11), inside), best)

    assert not has_moved([parameter()], regions([2, 3], 2), regions([4], 4))  # a step beside it
    assert has_moved([parameter()], regions([2, 3], 2), regions([7, 8], 8))
    # A wide region that holds the other best has not moved.
    assert not has_moved([parameter()], regions([2], 2), regions(range(11), 9))


def test_values_are_round_over_what_a_slider_spans():
    (dr_o, dr_a) = fitted_parameters([model("couzin")], ["dr_o", "dr_a"])["couzin"]
    assert dr_o.values == tuple(float(v) for v in range(16))
    assert dr_a.values == tuple(2.0 * v for v in range(16))
    assert (dr_o.is_floor, dr_a.is_floor) == (True, True)
    assert len(list(grid((dr_o, dr_a)))) == 256


def test_each_model_takes_the_parameters_that_it_has():
    fitted = fitted_parameters([model("couzin"), model("vem")], ["dr_o=1:3:3", "r=0.5:2:4"])
    assert [p.name for p in fitted["couzin"]] == ["dr_o"]
    assert fitted["vem"][0].values == (0.5, 1.0, 1.5, 2.0)


@pytest.mark.parametrize(
    ("requests", "says"),
    [
        (["dr_x"], "unknown parameter 'dr_x': did you mean 'dr_o'?"),
        (["dr_o", "dr_o=0:1:2"], "parameter 'dr_o' is given twice"),
        (["dr_o=1:2"], "is not of the form NAME=LOW:HIGH:STEPS"),
        (["dr_o=5:1:3"], "LOW < HIGH and 2 to 20000 STEPS are needed"),
        (["dr_o=0:99:3"], r"dr_o=0:99:3 is outside [0, 30] length"),
        (["dr_o=0:nan:3"], "LOW < HIGH"),
        (["neighbours"], "only numbers are fitted"),
        (["dr_o=0:30:200", "dr_a=0:30:200"], "a grid of 40000 cells is not allowed"),
    ],
)
def test_what_cannot_be_looked_for_is_refused(requests, says):
    with pytest.raises(InputError) as refusal:
        fitted_parameters([model("couzin")], requests)
    assert says in str(refusal.value)
    assert "\n" not in str(refusal.value)
