"""Lessons: each opens, suits forty flocks at once, asks its question first, and says what is so."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest
from cli.calling import call

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.observables.catalogue import OBSERVABLES
from app.classroom.collect.hand_in import hand_in
from app.classroom.collect.question_choices import ready_for
from app.classroom.question_service import QuestionService
from app.cli.classroom import open_class
from app.viewer.gallery.lessons.lessons import lesson_names, lesson_of
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_collection import find_lesson
from worlds.input_error import InputError

SEEDS = range(1, 6)


def asked(name):
    """The question that is offered first for a lesson."""
    return ready_for(find_lesson(name).spec, name, find_lesson(name).steps)[0].question


def results(name, value, seeds=SEEDS, **others):
    """What students with these seeds would hand in for a value."""
    question, scene = asked(name), find_lesson(name).spec
    made = []
    for seed in seeds:
        spec = question.with_value(scene.but(seed=seed), value)
        spec = spec.but(parameters={**spec.parameters, **others})
        made.append(hand_in(question, "A", spec, scene).result)
    return made


@pytest.mark.parametrize("name", lesson_names())
class TestALesson:
    def test_is_a_scene_with_words_that_comes_back_from_its_text(self, name):
        scene = find_lesson(name)
        assert scene.title
        assert scene.watch
        assert scene.tries
        assert scene.camera
        assert SavedScene.from_toml(scene.to_toml(), name) == scene
        assert all(one in OBSERVABLES for one in scene.plots)

    def test_is_small_enough_for_forty_flocks_at_once(self, name):
        spec = find_lesson(name).spec
        assert spec.agents <= 300
        Flock(spec).run(1)
        began = time.process_time()
        Flock(spec).run(1)
        assert time.process_time() - began < 1.0

    def test_is_what_a_class_opens_on_with_its_question_first(self, name, tmp_path):
        made = open_class(name, 40, 2)
        assert made.title == find_lesson(name).title
        (first, *_) = QuestionService(tmp_path).choices(made.scene)["ready"]
        assert first["name"] == name
        again = SavedScene.from_toml(made.scene.to_toml(), "the teacher's run")
        assert lesson_of(again) == name

    def test_has_a_question_whose_run_is_made_soon(self, name):
        question, scene = asked(name), find_lesson(name).spec
        assert question.parameter in MODELS[scene.model].parameters.model_fields
        for value in question.values[-1:] or [5.0]:
            spec = question.with_value(scene, value)
            hand_in(question, "A", spec, scene)
            began = time.process_time()
            assert hand_in(question, "A", spec, scene).result is not None
            assert time.process_time() - began < 2.0

    def test_is_listed(self, name):
        told = json.loads(call("list", name, "--json").stdout)["lesson"]
        assert told["question"] == asked(name).title
        shown = call("list", name).stdout
        assert f"flockscope class {name}" in shown


def test_a_scene_of_the_gallery_is_no_lesson_but_may_be_opened():
    assert lesson_of(find_lesson("mill")) == ""
    with pytest.raises(InputError, match="unknown lesson or scene 'who-lead'"):
        find_lesson("who-lead")


def test_order_is_lost_with_noise():
    values = asked("order-against-noise").values
    assert len(values) == 11
    means = [np.mean(results("order-against-noise", value, range(1, 4))) for value in values]
    assert means[0] > 0.99
    assert means[-1] < 0.1
    assert all(one > other for one, other in zip(means[:-1], means[2:], strict=False))


def test_the_others_follow_several_times_as_late_where_all_neighbours_count_alike():
    alike, nearer = results("who-leads", 1.0), results("who-leads", 5.0)
    assert min(alike) > max(nearer)
    assert np.mean(alike) > 4 * np.mean(nearer)
    assert 10 < np.mean(nearer) < 16
    assert np.mean(results("who-leads", 50.0)) == pytest.approx(np.mean(nearer), rel=0.1)


def test_word_runs_outward_layer_by_layer():
    flock = Flock(find_lesson("who-leads").spec)
    (leader,) = np.flatnonzero(flock.informed)
    layer = flock.snapshot().layers()
    flock.run(5)
    alike = flock.heading @ flock.heading[leader] > 0.9
    near, far = alike[(layer > 1) & (layer <= 4)].mean(), alike[layer >= 8].mean()
    assert near > 0.9
    assert far < near - 0.3


def test_fish_that_see_almost_all_round_swim_in_a_ring_and_others_do_not():
    ring = results("field-of-view", 270.0)
    assert min(ring) > 0.5
    for narrow in (60.0, 120.0, 180.0):
        assert np.mean(results("field-of-view", narrow)) < 0.2
    assert find_lesson("field-of-view").spec.parameters["alpha"] == 270.0
    assert results("field-of-view", 120.0, [find_lesson("field-of-view").spec.seed])[0] < 0.2


def test_the_papers_weights_take_about_ten_ticks_and_can_be_beaten():
    papers = results("beat-the-paper", 5.0)
    assert find_lesson("beat-the-paper").spec.parameters["p2"] == 5.0
    assert all(9 <= one <= 12 for one in papers)
    assert np.mean(results("beat-the-paper", 20.0)) < 0.9 * np.mean(papers)
    assert np.mean(results("beat-the-paper", 20.0, p1=0.0)) < 0.9 * np.mean(papers)
    assert np.mean(results("beat-the-paper", 1.5)) > 1.5 * np.mean(papers)


def test_a_student_may_choose_both_weights_and_hand_in_often():
    question = asked("beat-the-paper")
    assert (question.parameter, question.free, question.values) == ("p2", ["p1"], [])
    assert question.counts == "all"
