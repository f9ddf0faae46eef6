"""The lesson in the laboratory: a prediction is fixed by its run, which alone is judged."""

from __future__ import annotations

import asyncio
import math
import re
import threading
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from agents.flock import Flock
from app.front.controls import set_value
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_collection import find_lesson
from app.viewer.gallery.scene_steps import lesson_key, step_spec
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.step_progress import LessonLead
from app.viewer.scene.cameras.viewpoints import MOST
from tests.classroom.test_lesson_steps import mean_measured, scene_text
from tests.viewer.waiting import COMPILED, until

SECOND = """
[[steps]]
say = "And in a smaller flock?"
watch = "mean-neighbours"
ask = "How much more order than in step 2?"
choices = ["less", "more"]
measure = "polarisation"
ticks = 9
bounds = [0.0]
than = 2
set = { eta = 1, agents = 12 }
shows = "less"
why = "Because it is so."
"""
RUN = '[run]\nmodel = "vem"\nagents = 20\nsize = 5.0\nworld = "wrap"\n'


def refreshed(laboratory):
    """Wait until the thread that draws has brought the panels up to date once more."""
    done, panels = threading.Event(), laboratory.drawing.panels

    def once():
        panels()
        done.set()

    laboratory.drawing.panels = once
    laboratory.drawing.show_to_newcomer()
    assert done.wait(COMPILED)
    laboratory.drawing.panels = panels


@pytest.fixture
def laboratory():
    """A laboratory on a lesson, whose flock goes as fast as it can."""
    scene = SavedScene.from_toml("speed = inf\n" + scene_text(RUN) + SECOND, "mine.toml")
    made = Laboratory(opened=scene, port=0, running=False)
    try:
        assert made.simulation.ready.wait(60)
        until(lambda: made.lesson.scene is scene, 30, "the lesson")
        with made.lesson.lock:
            pass  # its controls are made by now
        yield made
    finally:
        made.close()


class Press:
    """A press of a button of a group."""

    client = None

    def __init__(self, value: str = ""):
        self.target = self
        self.value = value


def go_to(laboratory: Laboratory, number: int) -> None:
    """Go on until a step is shown."""
    while laboratory.lesson.number < number:
        asyncio.run(laboratory.lesson.move(Press("Next")))


def run_step(laboratory: Laboratory, choice: int) -> list[str]:
    """Predict a choice and run the step; what the panel then says, without marks."""
    panel = laboratory.lesson
    asyncio.run(panel.choose(choice, Press()))
    asyncio.run(panel.begin(Press()))
    until(lambda: panel.now.trial.is_over, 60, "the run of the step")
    refreshed(laboratory)
    return re.findall(r"<p>(.*?)</p>", panel.verdict.content)


def test_a_step_is_judged_by_the_run_that_a_script_makes(laboratory):
    panel = laboratory.lesson
    scene = panel.scene
    assert panel.folder.visible
    go_to(laboratory, 1)
    assert list(panel.sliders) == ["eta"]
    assert panel.run.disabled
    asyncio.run(panel.begin(Press()))
    assert panel.now.trial is None  # nothing is predicted yet
    told, verdict = run_step(laboratory, 1)
    mean = mean_measured(scene.spec, scene.steps[1])
    shown = scene.steps[1].choice_of(mean)
    assert told == f"Polarisation: {mean:.3f}, the mean of ticks 5 to 9. This run shows “{shown}”."
    assert verdict == f"Your prediction “much” {'holds' if shown == 'much' else 'does not hold'}."
    until(lambda: not laboratory.simulation.state.running, 30, "the flock stands")
    assert laboratory.simulation.run.flock.tick == 9
    assert laboratory.simulation.state.values["eta"] == 1.0
    assert all(button.disabled for button in panel.answers)
    asyncio.run(panel.choose(0, Press()))
    assert panel.now.choice == 1


def test_a_step_is_compared_with_an_earlier_one_once_that_has_run(laboratory):
    panel = laboratory.lesson
    scene = panel.scene
    go_to(laboratory, 2)
    asyncio.run(panel.choose(0, Press()))
    assert panel.lacks(panel.step) == "Run step 2 first."
    asyncio.run(panel.move(Press("Back")))
    run_step(laboratory, 0)
    asyncio.run(panel.move(Press("Next")))
    lines = run_step(laboratory, 0)
    before = mean_measured(scene.spec, scene.steps[1])
    mean = mean_measured(step_spec(scene.spec, scene.steps[2]), scene.steps[2])
    side = "more" if mean >= before else "less"
    assert f", {abs(mean - before):.3f} {side} than in step 2." in lines[0]
    assert f"This run shows “{side}”." in lines[0]
    assert (lines[2:] == ["Because it is so."]) == (side == "less")
    assert laboratory.told_scene() is scene  # though it has fewer agents by now
    assert laboratory.simulation.state.spec.agents == 12


def test_a_run_in_which_a_slider_was_moved_is_not_judged(laboratory):
    panel = laboratory.lesson
    laboratory.simulation.run_at(1.0).result(30)
    go_to(laboratory, 1)
    asyncio.run(panel.choose(0, Press()))
    asyncio.run(panel.begin(Press()))
    trial = panel.now.trial
    until(lambda: laboratory.simulation.run.trial is trial, 30, "the run")
    laboratory.simulation.set("eta", 2.0).result(30)
    assert trial.is_over
    refreshed(laboratory)
    assert "The flock was changed, so this is not the run of this step." in panel.verdict.content


def test_another_run_ends_that_of_a_step(laboratory):
    panel = laboratory.lesson
    laboratory.simulation.run_at(1.0).result(30)
    go_to(laboratory, 1)
    asyncio.run(panel.choose(0, Press()))
    asyncio.run(panel.begin(Press()))
    trial = panel.now.trial
    until(lambda: laboratory.simulation.run.trial is trial, 30, "the run")
    laboratory.simulation.reset().result(30)
    until(lambda: trial.is_over, 30, "the end of the trial")
    assert trial.fault == "Another run was begun"


def test_a_scene_without_steps_has_no_lesson(laboratory):
    plain = SavedScene.from_toml(RUN, "plain.toml")
    laboratory.open(plain)
    until(lambda: laboratory.lesson.scene is plain, 30, "the scene")
    assert not laboratory.lesson.folder.visible


def open_scene(laboratory: Laboratory, scene: SavedScene) -> None:
    """Open a scene, and wait until its lesson is shown."""
    panel = laboratory.lesson
    laboratory.open(scene)
    until(lambda: panel.scene is scene, 30, "the scene")
    with panel.lock:
        pass  # its controls are made by now


OTHER = scene_text(RUN.replace("agents = 20", "agents = 15"))
"""A lesson whose flock is another one than that of `laboratory`."""


def test_cameras_are_pointed_at_the_scene_on_which_it_opens(laboratory):
    until(lambda: laboratory.pointing is None, COMPILED, "the first frame")


def open_at_rest(laboratory: Laboratory) -> None:
    """Open a scene, and wait until nothing more is to come of it."""
    laboratory.open(SavedScene.from_toml(scene_text(RUN), "a.toml"))
    until(lambda: laboratory.pointing is None, COMPILED, "its first frame")


def test_a_lesson_stays_though_the_page_is_refreshed_while_it_is_opened(laboratory):
    open_at_rest(laboratory)
    scene = SavedScene.from_toml(OTHER, "other.toml")
    follow = laboratory.setup.follow

    def held(*arguments):
        for _ in range(2):
            refreshed(laboratory)  # as when a browser comes, amid the opening
        follow(*arguments)

    laboratory.setup.follow = held
    laboratory.open(scene)
    until(lambda: laboratory.simulation.state.spec is scene.spec, COMPILED, "its flock")
    refreshed(laboratory)
    assert laboratory.told_scene() is scene
    assert laboratory.lesson.scene is scene
    assert laboratory.lesson.folder.visible


def test_a_lesson_stays_that_is_opened_while_another_flock_is_built(laboratory):
    open_at_rest(laboratory)
    simulation = laboratory.simulation
    first, scene = (SavedScene.from_toml(text, "a.toml") for text in (scene_text(RUN), OTHER))
    is_building, may_build, may_obey = (threading.Event() for _ in range(3))
    build, obey = simulation.building.flock, simulation.carry_out_commands

    def held_build(*arguments):
        simulation.building.flock = build
        is_building.set()
        assert may_build.wait(COMPILED)
        return build(*arguments)

    def held_obey():
        assert may_obey.wait(COMPILED)
        obey()

    simulation.building.flock = held_build
    laboratory.open(first)
    assert is_building.wait(COMPILED)
    laboratory.open(scene)
    simulation.carry_out_commands = held_obey
    may_build.set()
    until(lambda: simulation.state.spec is first.spec, COMPILED, "the flock of the first")
    for _ in range(3):
        refreshed(laboratory)
    assert laboratory.lesson.scene is scene
    may_obey.set()
    until(lambda: simulation.state.spec is scene.spec, COMPILED, "the flock of the second")
    refreshed(laboratory)
    assert laboratory.lesson.scene is scene


def lead(laboratory: Laboratory, step: int, **choices: int) -> None:
    """Lead the laboratory to a step of its lesson, 0 for no more; `_2=1`: predicted before."""
    made = {int(name[1:]): choice for name, choice in choices.items()}
    laboratory.lead(LessonLead(lesson_key(laboratory.lesson.steps), step, choices=made))


def has_moves(laboratory: Laboratory) -> bool:
    """Whether the panel has Back and Next; else it says who leads."""
    last = laboratory.lesson.made[-1]
    return hasattr(last, "options")


def says_who_leads(laboratory: Laboratory) -> bool:
    """Whether the panel says that the teacher leads."""
    contents = [getattr(control, "content", "") for control in laboratory.lesson.made]
    return any("Your teacher leads: all see this step." in content for content in contents)


def test_who_is_led_sees_the_step_of_the_class_and_goes_nowhere_else(laboratory):
    panel = laboratory.lesson
    assert (has_moves(laboratory), says_who_leads(laboratory)) == (True, False)
    lead(laboratory, 2)
    assert (panel.number, has_moves(laboratory), says_who_leads(laboratory)) == (1, False, True)
    assert "Step 2 of 3" in panel.made[0].content
    asyncio.run(panel.move(Press("Next")))
    assert panel.number == 1
    refreshed(laboratory)
    again = replace(panel.scene, speed=100.0)
    open_scene(laboratory, again)
    assert (panel.number, says_who_leads(laboratory)) == (1, True)
    lead(laboratory, 0)
    assert (panel.number, has_moves(laboratory), says_who_leads(laboratory)) == (1, True, False)
    asyncio.run(panel.move(Press("Next")))
    assert panel.number == 2


def test_another_lesson_than_that_of_the_class_is_not_led(laboratory):
    panel = laboratory.lesson
    lead(laboratory, 2)
    other = SavedScene.from_toml(scene_text(RUN), "other.toml")
    open_scene(laboratory, other)
    assert (panel.number, panel.led, has_moves(laboratory)) == (0, 0, True)
    plain = SavedScene.from_toml(RUN, "plain.toml")
    open_scene(laboratory, plain)
    laboratory.lead(LessonLead("", 1))
    assert (panel.led, panel.made) == (0, [])


def test_who_is_led_runs_the_step_that_it_is_compared_with_first(laboratory):
    panel = laboratory.lesson
    lead(laboratory, 3)
    asyncio.run(panel.choose(0, Press()))
    assert (panel.run.label, panel.run.disabled) == ("Run step 2 first", False)
    asyncio.run(panel.begin(Press()))
    until(lambda: panel.progress[1].trial.is_over, 60, "the run of step 2")
    refreshed(laboratory)
    assert panel.predictions()[2] == ()  # nothing was predicted of it
    assert (panel.run.label, panel.now.is_fixed) == ("Run it", False)
    lines = run_step(laboratory, 0)
    shown = panel.predictions()[2][0][2]
    assert panel.predictions()[2] == ((3, 0, shown),)
    assert f"This run shows “{panel.step.choices[shown]}”." in lines[0]
    lead(laboratory, 2)
    assert panel.verdict.content.count("<p>") == 1  # what it showed, and of no prediction


def test_predictions_are_told_with_what_runs_have_shown(laboratory):
    panel = laboratory.lesson
    go_to(laboratory, 1)
    asyncio.run(panel.choose(1, Press()))
    assert panel.predictions() == (lesson_key(panel.steps), 0, ())  # it may still be changed
    run_step(laboratory, 1)
    step, mean = panel.step, mean_measured(panel.scene.spec, panel.step)
    assert panel.predictions()[2] == ((2, 1, step.choices.index(step.choice_of(mean))),)


def test_what_was_predicted_in_a_class_stays_where_its_lesson_is_opened_anew(laboratory):
    panel = laboratory.lesson
    lead(laboratory, 3, _2=1)
    lead(laboratory, 2)
    assert (panel.now.choice, panel.now.is_fixed, panel.run.label) == (1, True, "Run it again")
    asyncio.run(panel.choose(0, Press()))
    assert panel.predictions()[2] == ((2, 1, None),)
    again = replace(panel.scene, speed=100.0)
    open_scene(laboratory, again)
    assert panel.predictions()[2] == ((2, 1, None),)


def test_another_lesson_of_the_class_begins_anew_though_it_was_opened_before(laboratory):
    panel = laboratory.lesson
    go_to(laboratory, 1)
    run_step(laboratory, 1)
    laboratory.lead(LessonLead(panel.lesson, 2, turn=1))
    assert panel.predictions() == (panel.lesson, 1, ())
    assert (panel.now.choice, panel.run.label) == (-1, "Run it")


def write_step(laboratory: Laboratory, **values: Any) -> None:
    """Fill in the form, and add the step."""
    form = laboratory.lesson_form
    for name, value in values.items():
        set_value(getattr(form, name), value)
    asyncio.run(form.press_button(Press("Add step")))


def test_a_teacher_writes_a_lesson_that_is_saved_and_opened_again(laboratory):
    laboratory.open(SavedScene.from_toml(RUN, "plain.toml"))
    until(lambda: not laboratory.lesson.steps, 30, "the scene")
    laboratory.simulation.set("eta", 2.0).result(60)
    refreshed(laboratory)
    set_value(laboratory.lesson_form.controls[0], "Noise")
    write_step(laboratory, say="Press Go.", picture="order")
    assert laboratory.lesson_form.picture.value == "none"
    write_step(laboratory, say="Look.", ask="How much?", choices="little / much", bounds="0.5")
    compared = {"than": 2, "agents": 10, "shows": "more", "why": "Fewer are as many."}
    write_step(
        laboratory, say="Now ten.", ask="More?", choices="less / more", bounds="0", **compared
    )
    assert (laboratory.lesson_form.than.value, laboratory.lesson_form.why.value) == (0, "")
    refreshed(laboratory)
    assert laboratory.lesson.folder.visible
    saved = SavedScene.from_toml(laboratory.now("mine").to_toml(), "mine.toml")
    first, second, third = saved.steps
    assert first.values() == {"say": "Press Go.", "picture": "order", "controls": ["eta"]}
    assert second.choices == ["little", "much"]
    assert second.set == {"eta": 2.0}
    assert {name: getattr(third, name) for name in ("than", "shows", "why")} == {
        name: compared[name] for name in ("than", "shows", "why")
    }
    assert third.set == {"eta": 2.0, "agents": 10.0}
    laboratory.open(saved)
    until(lambda: laboratory.lesson.scene is saved, 30, "the lesson")
    go_to(laboratory, 1)
    assert len(run_step(laboratory, 0)) == 2
    asyncio.run(laboratory.lesson_form.press_button(Press("Remove last")))
    asyncio.run(laboratory.lesson_form.press_button(Press("Remove last")))
    refreshed(laboratory)
    assert laboratory.lesson.steps == (first,)


def test_a_step_that_is_not_sound_is_refused_in_a_line(laboratory):
    steps = laboratory.lesson.steps
    told = []
    laboratory.lesson_form.tell = told.append
    write_step(laboratory, say="Look.", ask="How much?", choices="a / b", bounds="half")
    write_step(laboratory, say="Look.", ask="How much?", choices="a", bounds="0.5")
    assert told[0] == "bounds = 'half' is no number (the form)"
    assert told[1].startswith("step 4: choices = ['a'] is not allowed")
    refreshed(laboratory)
    assert laboratory.lesson.steps == steps


def test_a_scene_as_fast_as_it_goes_opens_in_a_laboratory_that_runs(laboratory):
    laboratory.run.pace(10.0)
    laboratory.open(replace(laboratory.lesson.scene, title="Again, and fast"))
    until(lambda: laboratory.lesson.scene.title == "Again, and fast", 30)
    until(lambda: math.isinf(laboratory.simulation.state.speed), 30)


def test_a_lesson_opens_on_the_charts_that_its_file_names():
    scene = find_lesson("fast-and-slow")
    assert "fast-in-front" in scene.plots  # as observables are called: the charts write it apart
    made = Laboratory(opened=scene, port=0, running=False)
    try:
        plotted = [(name,) for name in scene.plots]
        until(lambda: [one.names for one in made.plots.charts[:2]] == plotted, 30, "charts")
        assert made.now().plots[:2] == ("fast in front", "polarisation")
        made.plot_first("angular-momentum")
        first = made.plots.charts[0]
        until(lambda: first.names == ("angular-momentum",), COMPILED, "the chart")
    finally:
        made.close()


def test_the_fast_and_the_slow_stay_in_the_picture():
    """The camera shows a flock that is spread over `MOST` sides of its world."""
    scene = find_lesson("fast-and-slow")
    step = next(step for step in scene.steps if step.ask)
    flock = Flock(step_spec(scene.spec, step))
    widest = 0.0
    while flock.tick < step.ticks:
        flock.run(50)
        low, high = np.quantile(flock.position, (0.02, 0.98), axis=0)
        widest = max(widest, float(np.max(high - low)))
    assert MOST - 2.0 < widest / max(flock.world.size) < MOST - 0.5
