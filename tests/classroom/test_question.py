"""Questions: from a browser, from a file, ready-made, and what cannot be asked."""

from __future__ import annotations

import json
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.individuals import normal
from agents.observables.catalogue import OBSERVABLES
from app.classroom.collect.question import question_from_toml, question_of
from app.classroom.collect.question_choices import measures_of, parameters_of, ready_for
from app.viewer.gallery.scene_collection import find_scene, scene_names
from app.viewer.run.run_preset import preset_spec
from tests.classroom.small import AGREE, LED, ORDER, SCENE, VALUES
from worlds.input_error import InputError

ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=8,
)


def test_a_question_goes_through_json_toml_and_pickle():
    for question, scene in ((ORDER, SCENE), (AGREE, LED)):
        assert question_of(json.loads(json.dumps(question.to_values())), scene) == question
        assert question_from_toml(question.to_toml(), scene, "q.toml") == question
        assert pickle.loads(pickle.dumps(question)) == question


def test_values_are_in_order_and_titles_on_one_line():
    made = question_of(VALUES | {"values": [3, 0.5, 3.0], "title": " a\n\tb\x07 "}, SCENE)
    assert (made.values, made.title) == ([0.5, 3.0], "a b")


def test_an_answer_is_one_number_of_agents_that_differed():
    differ = SCENE.with_values(individuals={"eta": normal(0.5, 0.1), "v0": normal(0.03, 0.01)})
    spec = question_of(VALUES, SCENE).with_value(differ, 3.0)
    assert (spec.parameters["eta"], spec.individuals) == (3.0, {"v0": normal(0.03, 0.01)})


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"title": ""}, "title"),
        ({"title": "\x07"}, "no letters"),
        ({"title": "x" * 81}, "at most 80"),
        ({"title": 3}, "a text is needed"),
        ({"parameter": "p2"}, "'p2'"),
        ({"parameter": "neighbours"}, "'neighbours'"),
        ({"model": "hwvem"}, "not that of the scene"),
        ({"values": [0.0, 9.0]}, r"eta = 9 is not in \[0, 6.28"),
        ({"values": [0.0, float("nan")]}, "finite number"),
        ({"values": ["0"]}, "a number is needed"),
        ({"values": [True, False]}, "number"),
        ({"values": [1.0]}, "two or more"),
        ({"values": list(range(51))}, "at most 50"),
        ({"parameter": "agents", "values": [10, 10.5]}, "10.5 is not a whole number"),
        ({"parameter": "agents", "values": [10, 4000]}, "agents = 4000"),
        ({"ticks": 0}, "ticks = 0"),
        ({"ticks": 20_001}, "<= 20000"),
        ({"ticks": "40"}, "whole number"),
        ({"ticks": True}, "whole number"),
        ({"measure": {}}, "either observe or until"),
        ({"measure": {"observe": "order"}}, "unknown observable 'order'"),
        ({"measure": {"observe": "layers"}}, "is a table"),
        ({"measure": {"observe": "goal-distance"}}, "observable of this scene"),
        ({"measure": {"observe": "polarisation", "over": 41}}, "over = 41 is more"),
        ({"measure": {"observe": "binder"}}, "over = 2 or more"),
        ({"measure": {"observe": "polarisation", "hold": 3}}, "hold is of until"),
        ({"measure": {"until": "polarisation"}}, "one comparison"),
        ({"measure": {"until": "binder >= 0.1"}}, "no tick has it"),
        ({"measure": {"until": "polarisation >= inf"}}, "finite"),
        ({"measure": {"until": "polarisation >= 0.9", "hold": 41}}, "hold = 41 is more"),
        ({"measure": {"until": "polarisation >= 0.9", "over": 3}}, "over is of what"),
        ({"measure": {"measure": "mine.py:f"}}, "unknown key 'measure.measure'"),
        ({"counts": "first"}, "'last' or 'all'"),
        ({"free": ["eta"]}, "eta is there twice"),
        ({"free": ["nothing"]}, "'nothing'"),
        ({"more": 1}, "unknown key 'more'"),
        ({"values": [], "ticks": 20_000, "parameter": "agents", "measure":
          {"observe": "groups", "over": 20_000}}, "takes too long"),
        ({"parameter": "agents", "values": [10, 3000], "ticks": 2000}, "2,500 agents"),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_is_refused_in_one_line(changes, said):
    with pytest.raises(InputError, match=said) as refused:
        question_of(VALUES | changes, SCENE)
    assert "\n" not in str(refused.value)


@given(st.dictionaries(st.sampled_from([*VALUES, "free", "counts"]), ANYTHING))
def test_whatever_a_browser_sends_is_a_question_or_refused(changes):
    said = "in one line"
    try:
        made = question_of(VALUES | changes, SCENE)
        assert question_of(made.to_values(), SCENE) == made
    except InputError as refusal:
        said = str(refusal)
    assert "\n" not in said


@given(ANYTHING)
def test_nothing_else_is_a_question(values):
    with pytest.raises(InputError):
        question_of(values, SCENE)


def test_choices_are_those_of_the_scene():
    found = {one.name: one for one in parameters_of(SCENE)}
    assert set(found) == {"r", "eta", "k", "v0", "agents"}
    eta = found["eta"]
    assert (eta.symbol, eta.unit, eta.now, eta.low) == ("η", "rad", 0.4, 0.0)
    for one in found.values():
        assert all(one.low <= value <= one.high for value in one.suggested)
        question_of(VALUES | {"parameter": one.name, "values": list(one.suggested)}, SCENE)
    measures = {one.name: one for one in measures_of(SCENE)}
    assert measures["binder"].how == ("over",)
    assert "goal-distance" not in measures
    assert measures["velocity-spread"].unit == "length/tick"
    flock = Flock(SCENE)
    assert all(OBSERVABLES[name].applies(flock) for name in measures)
    for one in measures.values():
        question_of(VALUES | {"measure": {"observe": one.name, "over": 10}}, SCENE)


@pytest.mark.parametrize("name", [*scene_names(), *(f"model:{name}" for name in MODELS)])
def test_ready_questions_are_those_whose_parameter_the_model_has(name):
    spec = find_scene(name).spec
    ready = ready_for(spec)
    parameters = MODELS[spec.model].parameters.model_fields
    for one in ready:
        assert one.question.parameter in parameters
        assert question_of(one.question.to_values(), spec) == one.question


def test_the_four_lessons_each_have_a_question():
    specs = map(preset_spec, ("vem", "hwvem", "couzin", "active-brownian"))
    names = {spec.model: [one.name for one in ready_for(spec)] for spec in specs}
    assert names == {
        "vem": ["order-against-noise"],
        "hwvem": ["order-against-noise", "who-leads", "beat-the-paper"],
        "couzin": ["order-against-noise", "field-of-view"],
        "active-brownian": [],
    }
