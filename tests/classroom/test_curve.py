"""The curve of a question: the sweep that makes it, and what is found in the stores."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import flockscope
from agents.flock import Flock
from app.classroom.collect.class_curve import FIRST_SEED, CurveAsked, curve_of, find_curve
from app.classroom.collect.collection import Collection
from app.classroom.collect.question import question_of
from app.studies.runs.database import FILE
from app.studies.sweeps.checked_sweep import read_sweep
from app.studies.sweeps.sweep_results import Results
from app.studies.sweeps.sweep_runner import run_sweep
from app.viewer.lab.sweeps.laboratory_sweeps import Sweeps, demand_from_page
from app.viewer.run.run_preset import preset_spec
from tests.classroom.small import AGREE, LED, ORDER, SCENE, VALUES
from tests.viewer.waiting import until
from worlds.input_error import InputError
from worlds.layout import world as build_world


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A folder with the curves of two questions, and a sweep over two axes."""
    folder = tmp_path_factory.mktemp("results")
    for question, scene in ((ORDER, SCENE), (AGREE, LED)):
        asked = CurveAsked(question, scene, runs=3)
        run_sweep(asked.sweep(folder), folder / asked.name, workers=1)
    flockscope.sweep(SCENE.but(seed=None), vary={"eta": [0.0, 1.0], "v0": [0.1, 0.2]}, runs=1,
                     ticks=40, observe=[{"name": "polarisation", "over": 10}], workers=1,
                     folder=folder / "both")  # fmt: skip
    (folder / "broken").mkdir()
    (folder / "broken" / FILE).write_bytes(b"nothing")
    return folder


@pytest.mark.parametrize(("question", "scene"), [(ORDER, SCENE), (AGREE, LED)])
def test_the_sweep_that_is_said_makes_the_curve_that_is_found(results, question, scene):
    found = find_curve(results, question, scene)
    assert found is not None
    assert (found.name, found.differs) == (f"{question.model}-{question.parameter}", ())
    assert [group.value for group in found.groups] == question.values
    table = Results(results / found.name).to_pandas()
    assert set(table["seed"]) == {FIRST_SEED + k for k in range(3)}
    for group in found.groups:
        rows = table[table[question.parameter] == group.value][question.column].dropna()
        assert group.values == tuple(rows)
        assert group.mean == pytest.approx(rows.mean())
        assert group.sd == pytest.approx(np.std(rows, ddof=1))


def test_the_file_that_is_said_is_read_by_the_command(tmp_path):
    asked = CurveAsked(ORDER, SCENE)
    (tmp_path / "spec.toml").write_text(asked.to_toml())
    made = read_sweep(tmp_path / "spec.toml")
    assert [cell.axes["eta"] for cell in made.cells] == ORDER.values
    assert made.making.measures == ORDER.making.measures
    assert (made.title, made.making.ticks) == (ORDER.title, ORDER.ticks)


def test_the_laboratory_s_sweeps_begin_it(tmp_path):
    sweeps = Sweeps(tmp_path)
    try:
        name = sweeps.begin(CurveAsked(ORDER, SCENE, runs=2))
        until(lambda: sweeps.making is None or not sweeps.making.runs, 90)
    finally:
        sweeps.close()
    demand_from_page(tmp_path / name)
    found = curve_of(tmp_path / name, ORDER, SCENE)
    assert [group.runs for group in found.groups] == [2] * 5


def test_a_world_of_ones_own_goes_along(tmp_path):
    world = replace(build_world("obstacles", 2, None, lambda _: 1.0), name="mine")
    scene = preset_spec("vem", world=world, agents=10)
    question = question_of(VALUES | {"values": [0.0, 1.0]}, scene)
    asked = CurveAsked(question, scene, runs=1)
    folder = tmp_path / asked.name
    folder.mkdir()
    (folder / "world.toml").write_text(asked.world())
    run_sweep(asked.sweep(folder), folder, workers=1)
    assert curve_of(folder, question, scene).differs == ()
    fewer = scene.but(world=replace(Flock(scene).world, obstacles=world.obstacles[1:]))
    assert curve_of(folder, question, fewer).differs == ("own obstacles",)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"ticks": 41}, "other runs than 41 ticks"),
        ({"measure": {"observe": "polarisation"}}, "does not measure polarisation"),
        ({"measure": {"observe": "polarisation", "over": 11}}, "does not measure"),
        ({"measure": {"until": "polarisation >= 0.9"}}, "stops otherwise"),
        ({"parameter": "v0", "values": [0.1, 0.2]}, "is swept over eta too"),
    ],
)
def test_a_sweep_of_something_else_is_not_the_curve(results, changes, said):
    question = question_of(VALUES | changes, SCENE)
    with pytest.raises(InputError, match=said):
        curve_of(results / "vem-eta", question, SCENE)
    assert find_curve(results, question, SCENE) is None


def test_a_sweep_over_two_axes_or_of_another_model_is_not_the_curve(results):
    with pytest.raises(InputError, match="is swept over v0 too"):
        curve_of(results / "both", ORDER, SCENE)
    with pytest.raises(InputError, match="is not a sweep of vem"):
        curve_of(results / "hwvem-p2", ORDER, SCENE)
    with pytest.raises(InputError, match="not a store of runs"):
        curve_of(results / "broken", ORDER, SCENE)
    assert find_curve(results / "nowhere", ORDER, SCENE) is None


def test_how_a_curve_differs_from_the_scene_is_said(results):
    scene = SCENE.but(agents=60)
    found = curve_of(results / "vem-eta", ORDER, scene)
    assert found.differs == ("other agents: 30, not 60",)


@pytest.mark.parametrize(
    ("parameter", "scene", "ends"),
    [("eta", SCENE, (0.0, 6.2832)), ("agents", SCENE, (8, 120)), ("p2", LED, (1.0, 20.0))],
)
def test_values_that_students_choose_are_swept_over_what_a_slider_spans(parameter, scene, ends):
    question = question_of(VALUES | {"parameter": parameter, "values": []}, scene)
    axis = CurveAsked(question, scene).axis()
    assert (axis[0], axis[-1]) == pytest.approx(ends, rel=1e-3)
    assert 8 <= len(axis) <= 12
    assert CurveAsked(question, scene, 1).values()["replicates"]["count"] == 1


@pytest.mark.parametrize(("parameter", "scene", "ratio"), [("r", SCENE, 100.0), ("p2", LED, 20.0)])
def test_a_wide_range_is_swept_in_equal_ratios(parameter, scene, ratio):
    question = question_of(VALUES | {"parameter": parameter, "values": []}, scene)
    axis = CurveAsked(question, scene).axis()
    assert np.diff(np.log(axis)) == pytest.approx(np.log(ratio) / 11, rel=0.01)


def test_what_spans_decades_is_shown_on_a_logarithmic_axis():
    question = question_of(VALUES | {"parameter": "r", "values": []}, SCENE)
    assert Collection(question).is_log(CurveAsked(question, SCENE).axis())
    assert not Collection(ORDER).is_log(CurveAsked(ORDER, SCENE).axis())


def test_what_is_too_much_for_a_page_is_refused():
    with pytest.raises(InputError, match="101 runs of a cell are not allowed"):
        CurveAsked(ORDER, SCENE, 101).to_toml()
