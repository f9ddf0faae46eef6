"""Steps of lessons: what a file may say of them, what is refused, and that they say what is so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cli.calling import call, refusal

from agents.flock import Flock
from agents.spec import CompleteSpec
from app.viewer.gallery.lessons.lessons import lesson_names
from app.viewer.gallery.saved_scene import SavedScene, pack_scene, unpack_scene
from app.viewer.gallery.scene_collection import find_lesson
from app.viewer.gallery.scene_steps import SceneStep, demand_in_page, step_spec
from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.run_preset import preset_spec
from tests.viewer.waiting import until
from worlds.input_error import InputError

RUN = '[run]\nmodel = "vem"\nagents = 20\n'
PREDICTED = {
    "say": '"Look."',
    "control": '"eta"',
    "ask": '"How much order?"',
    "choices": '["little", "much"]',
    "measure": '"polarisation"',
    "ticks": "9",
    "bounds": "[0.5]",
    "set": "{ eta = 1 }",
}


def scene_text(run: str = RUN, **changes: str) -> str:
    """A scene whose second step has a prediction, with other values in it; without those empty."""
    fields = {key: value for key, value in (PREDICTED | changes).items() if value}
    step = "".join(f"{key} = {value}\n" for key, value in fields.items())
    return f'{run}[[steps]]\nsay = "Begin."\n[[steps]]\n{step}'


def test_a_step_is_read_as_it_stands_and_written_again():
    scene = SavedScene.from_toml(scene_text(), "mine.toml")
    first, second = scene.steps
    assert first == SceneStep(say="Begin.")
    assert first.values() == {"say": "Begin."}
    assert second.values() == {
        "say": "Look.",
        "controls": ["eta"],
        "ask": "How much order?",
        "choices": ["little", "much"],
        "measure": "polarisation",
        "ticks": 9,
        "bounds": [0.5],
        "set": {"eta": 1.0},
    }
    assert second.first_measured_tick == 5
    assert SavedScene.from_toml(scene.to_toml(), "again").steps == scene.steps
    assert unpack_scene(pack_scene(scene)).steps == scene.steps


REFUSED = {
    "no sentence": ({"say": ""}, "step 2 has no say"),
    "a long sentence": ({"say": f'"{"x" * 241}"'}, "at most 240 characters are allowed"),
    "two lines": ({"say": '"a\\nb"'}, "one line of plain text is needed"),
    "another key": ({"hint": '"none"'}, "step 2 has an unknown key 'hint'"),
    "no parameter": ({"control": '"eat"'}, "unknown control 'eat': did you mean 'eta'?"),
    "another model's": ({"control": '"p2"'}, "unknown control 'p2' (known: "),
    "another one set": ({"set": "{ p2 = 1.0 }"}, "unknown parameter 'p2' (known: "),
    "a text set": ({"set": '{ eta = "much" }'}, "set.eta = 'much' is not allowed: a number"),
    "no slider has it": (
        {"set": "{ eta = 7.0 }"},
        "set.eta = 7 is not allowed: its slider goes from 0 to 6.283",
    ),
    "no observable": ({"measure": '"polarization"'}, "did you mean 'polarisation'?"),
    "none of a page": ({"measure": '"fluctuation"'}, "unknown measure 'fluctuation'"),
    "few bounds": (
        {"choices": '["a", "b", "c"]'},
        "bounds = [0.5] is not allowed: 3 choices need 2",
    ),
    "bounds that fall": (
        {"choices": '["a", "b", "c"]', "bounds": "[0.5, 0.4]"},
        "bounds = [0.5, 0.4] is not allowed: each is above the one before",
    ),
    "a bound without end": ({"bounds": "[inf]"}, "a finite number is needed"),
    "one choice": ({"choices": '["a"]', "bounds": "[]"}, "bounds is missing"),
    "the same twice": ({"choices": '["a", "a"]'}, "2 to 4 different answers"),
    "five choices": (
        {"choices": '["a", "b", "c", "d", "e"]', "bounds": "[1, 2, 3, 4]"},
        "at most 4 are allowed, not 5",
    ),
    "a long choice": ({"choices": f'["a", "{"x" * 61}"]'}, "at most 60 characters"),
    "one tick": ({"ticks": "1"}, "ticks = 1 is not allowed: at least 2"),
    "many ticks": ({"ticks": "20001"}, "a number <= 20000 is needed"),
    "part of a tick": ({"ticks": "9.5"}, "a whole number is needed"),
    "no ticks": ({"ticks": ""}, "ticks is missing: ask needs choices, measure, ticks, bounds"),
    "no question": ({"ask": ""}, "choices is given without ask"),
    "a kind where there is none": ({"kind": '"shark"'}, "unknown kind 'shark'"),
    "three controls": (
        {"control": "", "controls": '["eta", "r", "v0"]'},
        "at most 2 are allowed, not 3",
    ),
    "a control twice": ({"control": "", "controls": '["eta", "eta"]'}, "each once"),
    "control and controls": ({"controls": '["r"]'}, "control and controls are both given"),
    "nothing to watch": ({"watch": '"orders"'}, "unknown watch 'orders' (known: "),
    "no such choice": ({"shows": '"some"'}, "shows = 'some' is not allowed: one of"),
    "a reason for nothing": ({"why": '"So it is."'}, "why is given without shows"),
    "later than itself": ({"than": "2"}, "than = 2 is not allowed: an earlier step that measures"),
    "no step before": ({"than": "1"}, "than = 1 is not allowed: an earlier step that measures"),
    "a part of an agent": ({"set": "{ agents = 9.5 }"}, "set.agents = 9.5 is not allowed: a whole"),
    "agents in a world that grows": ({"set": "{ agents = 9 }"}, "needs a size of the run"),
    "a delay before now": ({"set": "{ delay = -1 }"}, "delay = -1"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_wrong_step_is_refused_with_its_number_and_its_file(case):
    changes, why = REFUSED[case]
    with pytest.raises(InputError) as refused:
        SavedScene.from_toml(scene_text(**changes), "mine.toml")
    message = str(refused.value)
    assert why in message
    assert "step 2" in message
    assert message.endswith("mine.toml)")
    assert "\n" not in message


def test_steps_are_a_list_of_few_and_of_one_flock():
    for text, why in (
        (f'steps = "look"\n{RUN}', "steps = 'look' is no list of at most 12 tables (mine.toml)"),
        (RUN + '[[steps]]\nsay = "Look."\n' * 13, "is no list of at most 12 tables (mine.toml)"),
        (f"steps = [1]\n{RUN}", "step 1"),
        (scene_text(f'{RUN}[beside]\nmodel = "ivem"\n'), "steps and beside exclude each other"),
    ):
        with pytest.raises(InputError) as refused:
            SavedScene.from_toml(text, "mine.toml")
        assert why in str(refused.value)


KINDS = """[run]
model = "vem"
agents = 20
size = 5.0
[[run.kinds]]
name = "shark"
agents = 2
parameters = { v0 = 0.05 }
to = { flock = { chase = 2.0, catch = 0.1 } }
"""


def test_a_step_measures_a_kind_and_sets_its_parameters():
    changes = {"kind": '"flock"', "set": '{ eta = 1, "shark.v0" = 0.02 }', "measure": '"catches"'}
    scene = SavedScene.from_toml(scene_text(KINDS, **changes), "mine.toml")
    step = scene.steps[1]
    assert step_spec(scene.spec, step).kinds[0].parameters == {"v0": 0.02}
    assert step_spec(scene.spec, scene.steps[0]).kinds == scene.spec.kinds
    assert "(9 ticks, eta = 1, shark.v0 = 0.02: mean catches of flock of" in step.describe()
    assert SavedScene.from_toml(scene.to_toml(), "again").steps == scene.steps
    assert unpack_scene(pack_scene(scene)).steps == scene.steps
    assert step.page_values()["measure"] == "catches of flock"
    assert "kind" not in step.page_values()
    sliders = [{"name": name, "of": [], "low": 0, "high": 6} for name in ("eta", "shark.v0")]
    manifest = {"parameters": [one | {"slots": []} for one in sliders], "start": None}
    of_kind = [{"name": "polarisation"}, {"name": "catches of flock"}]
    demand_in_page(scene.steps, manifest | {"measures": of_kind}, "mine.toml")
    with pytest.raises(InputError, match=r"unknown measure 'catches of flock' .*\(step 2, mine"):
        demand_in_page(scene.steps, manifest | {"measures": of_kind[:1]}, "mine.toml")


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"kind": '"sharks"'}, "unknown kind 'sharks': did you mean 'shark'?"),
        ({"kind": "3"}, "kind"),
        ({"set": '{ "ray.v0" = 0.1 }'}, "unknown kind 'ray' (known: shark"),
        ({"set": '{ "shark.speed" = 0.1 }'}, "unknown parameter 'speed'"),
        ({"set": '{ "shark.v0" = 9.0 }'}, "set.shark.v0 = 9 is not allowed: its slider goes from"),
        ({"set": '{ "shark.agents" = 3 }'}, "unknown parameter 'agents'"),
        ({"measure": '"binder"'}, "unknown measure 'binder'"),
        ({"measure": '"layers"'}, "unknown measure 'layers'"),
    ],
)
def test_what_is_no_kind_of_the_run_is_refused(changes, why):
    with pytest.raises(InputError) as refused:
        SavedScene.from_toml(scene_text(KINDS, **changes), "mine.toml")
    assert why in str(refused.value)
    assert "step 2" in str(refused.value)


def test_zones_that_change_places_are_refused():
    run = '[run]\nmodel = "safe"\nagents = 9\n'
    changes = {"control": "", "measure": '"polarisation"', "set": "{ d_r = 1.0, d_o = 0.5 }"}
    with pytest.raises(InputError, match=r"zones keep their order \(step 2, mine.toml\)"):
        SavedScene.from_toml(scene_text(run, **changes), "mine.toml")


def test_a_page_refuses_what_its_flock_cannot_do():
    manifest = {
        "parameters": [
            {"name": "eta", "slots": [1], "low": 0.0, "high": 6.0},
            {"name": "r", "slots": [], "low": 0.0, "high": 5.0},
        ],
        "start": None,
        "measures": [{"name": "polarisation"}],
    }
    (_, step) = SavedScene.from_toml(scene_text(), "mine.toml").steps
    demand_in_page([step], manifest, "mine.toml")
    for changed, why in (
        ({"controls": ["r"]}, "r cannot be changed in a page of this flock: steps may have eta"),
        ({"set": {"r": 1.0}}, "r cannot be changed in a page of this flock"),
        ({"set": {"agents": 9}}, "agents cannot be changed in a page of this flock"),
        ({"measure": "consistency"}, "unknown measure 'consistency' (known: polarisation)"),
    ):
        with pytest.raises(InputError) as refused:
            demand_in_page([step.model_copy(update=changed)], manifest, "mine.toml")
        assert why in str(refused.value)
        assert str(refused.value).endswith("(step 1, mine.toml)")


def test_a_wrong_step_of_a_file_ends_the_export(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(scene_text(control='"p2"'))
    for given in (["mine.toml"], ["--scene", "mine.toml"]):
        assert "unknown control 'p2'" in refusal("export", *given, "--quiet")
    assert [file.name for file in tmp_path.iterdir()] == ["mine.toml"]


def test_the_laboratory_keeps_the_steps_of_a_scene_that_it_saves():
    laboratory = Laboratory(preset_spec("vem", agents=20, seed=2), port=0, running=False)
    try:
        assert laboratory.simulation.ready.wait(60)
        scene = find_lesson("order-against-noise")
        small = replace(scene, spec=scene.spec.but(agents=30))
        before = laboratory.simulation.state.run
        laboratory.open(small)
        until(
            lambda: (
                laboratory.simulation.state.run > before and not laboratory.simulation.state.busy
            )
        )
        laboratory.simulation.set("eta", 2.0).result(60)
        saved = laboratory.now("mine")
        assert saved.spec.parameters["eta"] == 2.0
        assert SavedScene.from_toml(saved.to_toml(), "mine").steps == scene.steps
    finally:
        laboratory.close()


def mean_measured(spec: CompleteSpec, step: SceneStep) -> float:
    """The mean of a step's measure over the last half of its run, begun from a scene's or from the
    step's own."""
    flock = Flock(step_spec(spec, step))
    flock.run(step.ticks - len(range(step.ticks // 2, step.ticks)))
    values = []
    for _ in range(step.ticks // 2, step.ticks):
        flock.run(1)
        values.append(flock.observe(step.measure, kind=step.kind or None))
    assert flock.tick == step.ticks
    return float(np.mean(values))


def choices_shown(scene: SavedScene) -> list[str]:
    """What the runs of the steps of a scene show, prediction by prediction."""
    means, shown = {0: 0.0}, []
    for number, step in enumerate(scene.steps, 1):
        if step.ask:
            means[number] = mean_measured(scene.spec, step)
            shown.append(step.choice_of(means[number] - means[step.than]))
    return shown


def claimed(scene: SavedScene) -> list[str]:
    """What a scene says that they show."""
    return [step.shows for step in scene.steps if step.ask]


@pytest.mark.parametrize("name", lesson_names())
class TestStepsOfALesson:
    def test_are_three_to_six_that_speak_to_one_reader(self, name):
        steps = find_lesson(name).steps
        assert 3 <= len(steps) <= 6
        assert all(step.shows for step in steps if step.ask)
        assert not any("class" in step.say or "hand in" in step.say for step in steps)

    def test_show_what_the_lesson_says(self, name):
        scene = find_lesson(name)
        assert choices_shown(scene) == claimed(scene)

    @pytest.mark.exhaustive
    def test_show_the_same_with_every_seed(self, name):
        scene = find_lesson(name)
        for seed in range(1, 4):
            other = replace(scene, spec=scene.spec.with_values(seed=seed))
            assert choices_shown(other) == claimed(scene), seed

    def test_are_listed(self, name):
        lines = " ".join(call("list", name).stdout.split())
        for number, step in enumerate(find_lesson(name).steps, 1):
            assert f"step {number}: {step.say}" in lines
            assert step.ask in lines
