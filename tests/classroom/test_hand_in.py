"""A result that is handed in is the run that a sweep makes, to the bit."""

from __future__ import annotations

import math
import pickle
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import pytest

import flockscope
from agents.flock import Flock
from agents.individuals import normal
from agents.kinds import Kind, chase
from agents.spec import Spec
from app.classroom.collect.hand_in import hand_in, warm_up
from app.classroom.collect.question import question_of
from app.classroom.collect.run_cost import mean_neighbours
from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.run_preset import preset_spec
from tests.classroom.small import AGREE, LED, ORDER, SCENE, VALUES, WHEN, made
from tests.viewer.waiting import until
from worlds.input_error import InputError
from worlds.layout import layout_names
from worlds.layout import world as build_world


def swept(question, scene, axis, seeds):
    """The results of a sweep of the same runs, by value and seed."""
    one = question.measure
    words = {"until": one.until, "hold": one.hold} if one.until else {}
    observe = [] if one.until else [{"name": one.observe, "over": one.over} if one.over
                                    else {"name": one.observe}]  # fmt: skip
    results = flockscope.sweep(scene.but(seed=None), vary={question.parameter: axis},
                               runs=seeds, ticks=question.ticks, observe=observe, workers=1,
                               **words)  # fmt: skip
    rows = results.columns
    keys = zip(rows[question.parameter], rows["seed"], strict=True)
    return dict(zip(keys, zip(rows[question.column], rows["status"], strict=True), strict=True))


@pytest.mark.parametrize(
    ("question", "scene", "axis"),
    [
        (ORDER, SCENE, [0.0, 2.5]),
        (question_of(VALUES | {"measure": {"observe": "mean-neighbours"}}, SCENE), SCENE,
         [0.0, 2.5]),
        (question_of(VALUES | {"measure": {"observe": "binder", "over": 20}}, SCENE), SCENE, [2.5]),
        (question_of(VALUES | {"measure": {"until": "polarisation >= 0.9", "hold": 3}}, SCENE),
         SCENE, [0.0, 4.0]),
        (question_of(VALUES | {"parameter": "agents", "values": []}, SCENE), SCENE, [10, 20]),
        (AGREE, LED, [1.0, 50.0]),
    ],
)  # fmt: skip
def test_a_point_is_the_row_of_a_sweep_to_the_bit(question, scene, axis):
    rows = swept(question, scene, axis, 2)
    assert len({value for value, _ in rows.values()}) > 1
    for (value, seed), (result, status) in rows.items():
        point = hand_in(question, "Ada", question.with_value(scene, value).but(seed=seed), scene)
        assert (point.result, point.status, point.value) == (result, status, value)
        assert not point.differs


def test_a_point_opens_the_same_run_again():
    for question, scene in ((ORDER, SCENE), (AGREE, LED)):
        point = hand_in(question, "Ada", scene.but(seed=7), scene, WHEN)
        opened = point.scene(question)
        written = Spec.from_toml(point.spec).demand_complete("the point")
        assert hand_in(question, "Ada", opened.spec, scene, WHEN) == point
        assert hand_in(question, "Ada", written, scene, WHEN) == point
        assert "Ada" in opened.title
        assert f"{point.result:.4g}" in opened.watch


@pytest.mark.parametrize("world", layout_names())
def test_points_of_every_world_can_be_opened(world):
    model = "vem" if build_world(world, None, None, lambda _: 5.0).dim == 2 else "couzin"
    scene = preset_spec(model, world=world, agents=10)
    asked = {"observe": "polarisation"}
    values = VALUES | {"ticks": 2, "measure": asked, "parameter": "agents", "values": []}
    try:
        question = question_of(values, scene)
    except InputError:
        pytest.skip("no flock of ten begins there")
    point = hand_in(question, "Ada", scene, scene, WHEN)
    assert hand_in(question, "Ada", point.scene(question).spec, scene, WHEN) == point
    assert not point.differs


def test_it_is_made_in_another_process():
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        there = pool.submit(hand_in, ORDER, "Ada", SCENE, SCENE, WHEN).result()
    assert there == hand_in(ORDER, "Ada", SCENE, SCENE, WHEN)
    assert pickle.loads(pickle.dumps(there)) == there


def test_the_run_of_a_laboratory_is_handed_in_as_it_stands(tmp_path):
    laboratory = Laboratory(SCENE.but(seed=5), port=0, running=False, results=tmp_path)
    try:
        assert laboratory.simulation.ready.wait(60)
        until(lambda: laboratory.simulation.state.values)
        point = hand_in(ORDER, "Ada", laboratory.now().spec, SCENE, WHEN)
    finally:
        laboratory.close()
    assert not point.differs
    assert point == hand_in(ORDER, "Ada", SCENE.but(seed=5), SCENE, WHEN)


def test_what_does_not_happen_is_said_and_has_no_result():
    question = question_of(VALUES | {"measure": {"until": "polarisation >= 0.9"}}, SCENE)
    point = hand_in(question, "Ada", question.with_value(SCENE, 6.0), SCENE)
    assert (point.result, point.status, point.ticks) == (None, "gave-up", 40)
    assert point.reason == "it did not happen in 40 ticks: polarisation >= 0.9"
    assert point.told(question).startswith("Ada, eta = 6 rad, seed 1: it did not happen")


def test_a_value_that_is_none_is_no_result(monkeypatch):
    monkeypatch.setattr("agents.observables.order.polarisation", lambda _: math.nan)
    question = question_of(VALUES | {"measure": {"observe": "polarisation"}}, SCENE)
    point = hand_in(question, "Ada", SCENE, SCENE)
    assert (point.result, point.reason) == (None, "polarisation has no value there")


def test_a_run_that_raises_is_a_point_too(monkeypatch):
    def broken(_heading):
        raise ZeroDivisionError("a\nb;\x07")

    monkeypatch.setattr("agents.observables.order.polarisation", broken)
    point = hand_in(ORDER, "Ada", SCENE, SCENE)
    assert (point.result, point.status) == (None, "failed")
    assert point.reason == "the run failed: ZeroDivisionError: a b,\x07".replace("\x07", "")


def own_world(**changes):
    world = Flock(SCENE).world
    return replace(world, name="mine", title="Mine", **changes)


@pytest.mark.parametrize(
    ("spec", "differs"),
    [
        (SCENE.but(seed=99), ()),
        (SCENE.but(parameters={"eta": 5.0}), ()),
        (SCENE.but(parameters={"eta": 0.4, "v0": 0.1}), ("other v0: 0.1, not 0.03",)),
        (SCENE.but(agents=40), ("other agents: 40, not 30",)),
        (SCENE.but(activation="random"), ("other activation: random, not synchronous",)),
        (SCENE.but(size=4.0), ("another size: 4 x 4, not 3 x 3",)),
        (SCENE.but(world="open"), ("another world: open plane",)),
        (SCENE.but(world=own_world(), size=None), ()),
        (SCENE.but(world=own_world(distance="plain"), size=None), ("another world: Mine",)),
        (LED.but(world="wrap"), ("another model: hwvem", "other informed: 1, not 0")),
    ],
)
def test_what_differs_from_the_scene_is_said(spec, differs):
    assert hand_in(ORDER, "Ada", spec, SCENE).differs == differs


def test_own_obstacles_are_said():
    scene = preset_spec("vem", world="obstacles", agents=10)
    question = question_of(VALUES, scene)
    world = Flock(scene).world
    fewer = replace(world, obstacles=world.obstacles[1:], name="obstacles-edited")
    assert hand_in(question, "Ada", scene.but(world=fewer), scene).differs == ("own obstacles",)


def test_a_free_parameter_is_no_difference_and_is_kept():
    question = question_of(VALUES | {"free": ["v0", "r"]}, SCENE)
    point = hand_in(question, "Ada", SCENE.but(parameters={"v0": 0.1}), SCENE)
    assert (point.differs, point.free) == ((), (0.1, 1.0))


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        (SCENE.but(agents=5001), "5,001 agents are too many"),
        (SCENE.but(start="given"), "given places"),
        (preset_spec("couzin"), "couzin has no such parameter"),
        (SCENE.but(model="nothing"), "no model 'nothing'"),
        (SCENE.but(parameters={"eta": 9.0}), "eta = 9.0"),
        (SCENE.but(size=(3.0, 4.0)), "all sides are alike"),
        (SCENE.but(world="/etc/passwd"), "passwd"),
    ],
)
def test_what_cannot_be_handed_in_is_refused_before_it_is_run(spec, said, monkeypatch):
    monkeypatch.setattr("app.studies.sweeps.sweep_job.SweepJob.run", None)
    with pytest.raises(InputError, match=said) as refused:
        hand_in(ORDER, "Ada", spec, SCENE)
    assert "\n" not in str(refused.value)


def test_what_takes_too_long_is_refused_with_numbers():
    question = question_of(VALUES | {"ticks": 20_000}, SCENE)
    with pytest.raises(InputError, match=r"300 agents for 20,000 ticks .* here 250 agents"):
        hand_in(question, "Ada", SCENE.but(agents=300), SCENE)
    slow = question_of(VALUES | {"measure": {"observe": "connectivity", "over": 400},
                                 "ticks": 400}, SCENE)  # fmt: skip
    with pytest.raises(InputError, match="connectivity of 1,000 agents at each of 400 ticks"):
        hand_in(slow, "Ada", SCENE.but(agents=1000), SCENE)


@pytest.mark.parametrize(
    ("agents", "size", "refused"),
    [(2000, 1.0, "look at 2,001 take too long for 500 ticks: 2e.09 pairs"), (2000, 100.0, "")],
)
def test_what_it_costs_goes_by_pairs_and_not_by_agents_alone(agents, size, refused):
    question = question_of(
        {"title": "t", "parameter": "agents", "measure": {"observe": "polarisation"}, "ticks": 500},
        LED,
    )
    spec = LED.but(agents=agents, size=size)
    if not refused:
        question.demand_cheap(spec)
        return
    with pytest.raises(InputError, match=refused) as told:
        question.demand_cheap(spec)
    assert "\n" not in str(told.value)


def test_who_looks_at_the_nearest_looks_at_few_however_far_they_reach():
    near = preset_spec("topological", agents=1000, size=2.0, parameters={"k": 7, "r": 5.0})
    assert mean_neighbours(near) == 9 * 8
    every = near.but(parameters={"neighbours": "metric", "r": 5.0})
    assert mean_neighbours(every) == 1000


def test_warming_up_compiles_what_a_run_calls():
    warm_up(ORDER, SCENE)
    warm_up(AGREE, LED)
    assert made(0.4).result == made(0.4).result


def test_a_result_of_agents_that_differ_is_that_of_the_same_agents():
    scene = SCENE.with_parameters(SCENE.all_parameters | {"v0": normal(0.03, 0.01)})
    question = question_of(VALUES, scene)
    point = hand_in(question, "Ada", scene, scene, WHEN)
    assert point.differs == ()
    assert Spec.from_toml(point.spec).individuals == {"v0": normal(0.03, 0.01)}
    alike = hand_in(question, "Ada", SCENE, scene, WHEN)
    assert alike.differs == ("other v0: 0.03, not normal(0.03, 0.01)",)


def test_what_a_question_is_about_cannot_differ():
    scene = SCENE.with_parameters(SCENE.all_parameters | {"eta": normal(1.0, 0.1)})
    with pytest.raises(InputError, match=r"eta is what the class is asked about.* differ in it"):
        question_of(VALUES, scene)
    with pytest.raises(InputError, match=r"eta is what the class is asked about.* differ in it"):
        hand_in(ORDER, "Ada", scene, SCENE, WHEN)


def test_a_result_of_other_kinds_is_told():
    shark = Kind("shark", 2, to={"flock": chase(1.5, 2.0)})
    scene = SCENE.with_values(kinds=(shark,))
    point = hand_in(question_of(VALUES, scene), "Ada", scene, scene, WHEN)
    assert point.differs == ()
    assert Spec.from_toml(point.spec).kinds == (shark,)
    alone = hand_in(question_of(VALUES, scene), "Ada", SCENE, scene, WHEN)
    assert alone.differs == (
        "other agents of shark: none, not 2", "other shark to flock: none, not chase 1.5, radius 2",
    )  # fmt: skip
