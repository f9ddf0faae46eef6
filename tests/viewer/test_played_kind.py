"""Somebody plays a kind of agents: its numbers change, whatever page asks, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from agents.flock import Flock
from agents.individuals import normal
from agents.kinds import Kind, chase, flee, kind_table
from app.viewer.editing.editor import Editor, disc
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.played_kind import PlayedKind, with_kinds_apart
from app.viewer.run.run_preset import preset_spec
from tests.viewer.waiting import until
from worlds.input_error import InputError

SHARK = Kind("shark", 2, v0=0.05, to={"flock": chase(2.0, 1.5, catch=0.1)})
WHALE = Kind("whale", 1)
SPEC = with_kinds_apart(
    preset_spec("vem", agents=12, seed=4, size=4.0, kinds=[SHARK, WHALE], parameters={"eta": 0.4})
)


def test_kinds_apart_have_numbers_of_their_own_and_the_bits_of_before():
    """What all share by default, and whom the chased flee from, is written out."""
    shared = preset_spec(
        "vem", agents=30, seed=4, size=3.0, kinds=[SHARK, WHALE], parameters={"eta": normal(1, 0.2)}
    )
    apart = with_kinds_apart(shared)
    table = kind_table(apart.kinds, apart.to)
    assert table.kind("whale").parameters == {"r": 1.0, "eta": normal(1, 0.2), "v0": 0.03}
    assert table.kind("shark").parameters["v0"] == 0.05
    assert apart.to == {"shark": flee(2.0, 1.5)}
    flocks = [Flock(spec.but(individuals=spec.individuals)) for spec in (shared, apart)]
    for flock in flocks:
        flock.run(15)
    np.testing.assert_array_equal(flocks[0].position, flocks[1].position)
    assert with_kinds_apart(apart) == apart


def test_a_kind_by_a_model_of_its_own_shares_nothing_and_keeps_its_model():
    loner = Kind("loner", 2, model="gregoire-chate")
    spec = preset_spec("vem", agents=12, seed=4, size=4.0, kinds=[loner, SHARK])
    apart = with_kinds_apart(spec)
    assert apart.kinds[0].parameters == {}
    role = PlayedKind("shark", apart)
    role.demand_run(apart, None)
    own = PlayedKind("loner", apart)
    kind = apart.kinds[0]
    own.demand_run(apart.but(kinds=[kind.with_parameters({"v0": 0.05}), apart.kinds[1]]), None)
    with pytest.raises(InputError, match="you play loner: dt of loner cannot be changed here"):
        own.demand_run(apart.but(kinds=[kind.with_parameters({"dt": 1.0}), apart.kinds[1]]), None)
    with pytest.raises(InputError, match="the model of loner cannot be changed here"):
        role.demand_run(apart.but(kinds=[Kind("loner", 2), apart.kinds[1]]), None)


@pytest.mark.parametrize(
    ("played", "changes", "refused"),
    [
        ("shark", {"seed": 9}, ""),
        ("shark", {"parameters": {"eta": 1.0}}, "eta"),
        ("flock", {"parameters": {"eta": 1.0}}, ""),
        ("flock", {"parameters": {"eta": normal(1, 0.1)}}, ""),
        ("flock", {"parameters": {"k": 3}}, "k"),
        ("shark", {"agents": 13}, "agents"),
        ("flock", {"agents": 13}, "agents"),
        ("shark", {"size": 5.0}, "size"),
        ("shark", {"size": None}, "size"),
        ("shark", {"world": "wrap"}, ""),
        ("shark", {"world": "obstacles"}, "world"),
        ("shark", {"noise": "vectorial"}, "noise"),
        ("shark", {"delay": 1.0}, "delay"),
        ("shark", {"kinds": SPEC.kinds[:1]}, "the number of whale"),
        ("shark", {"kinds": [], "to": {}}, "the number of shark"),
        ("shark", {"to": {"shark": flee(9.0)}}, "what flock does about shark"),
        ("flock", {"to": {"shark": flee(9.0)}}, ""),
        ("flock", {"to": {"shark": flee(2.0, 1.5, power=2.0)}}, "what flock does about shark"),
        ("flock", {"to": {"shark": chase(9.0)}}, "what flock does about shark"),
    ],
)
def test_a_run_may_differ_by_what_is_played_and_its_seed(played, changes, refused):
    role, spec = PlayedKind(played, SPEC), SPEC.but(**changes)
    if not refused:
        role.demand_run(spec, None)
        return
    with pytest.raises(InputError, match=f"you play {played}: {refused} cannot be changed here"):
        role.demand_run(spec, None)


def test_another_model_or_one_beside_it_is_refused():
    role = PlayedKind("shark", SPEC)
    with pytest.raises(InputError, match="you play shark: the model beside cannot"):
        role.demand_run(SPEC, preset_spec("couzin"))
    other = preset_spec("couzin", agents=12, seed=4, size=4.0, dim=2)
    with pytest.raises(InputError, match=r"you play shark: .* cannot be changed here"):
        role.demand_run(other, None)
    with pytest.raises(InputError, match=r"unknown kind 'prey-eater'.*known: flock, shark, whale"):
        PlayedKind("prey-eater", SPEC)


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    scene = SavedScene("Hunt", SPEC)
    results = tmp_path_factory.mktemp("results")
    made = Laboratory(port=0, running=False, results=results, opened=scene, played="shark")
    assert made.simulation.ready.wait(60)
    until(lambda: made.parameters.controls and made.kinds.sliders)
    yield made
    made.close()


def test_only_the_sliders_of_the_kind_that_is_played_are_there(played):
    panel = played.kinds
    until(lambda: "You are: shark" in panel.listed.content and not panel.predator.visible)
    until(lambda: {"weight", "radius", "catch", "own"} == {*panel.sliders})
    assert panel.which.value == "shark"
    hidden = (panel.predator, panel.form, panel.which, panel.number, panel.remove, panel.deed)
    assert not any(control.visible for control in (*hidden, played.parameters.folder))
    assert not any(control.visible for control in played.parameters.controls.values())
    assert panel.parameter.visible


@pytest.mark.parametrize(
    ("command", "refused"),
    [
        (lambda it: it.set_kind("shark", "v0", 0.06), ""),
        (lambda it: it.relate("shark", "flock", "weight", 3.0), ""),
        (lambda it: it.set_kind("whale", "v0", 0.06), "v0 of whale"),
        (lambda it: it.set_kind("whale", "v0", None), "v0 of whale"),
        (lambda it: it.relate("flock", "shark", "weight", 3.0), "what flock does about shark"),
        (lambda it: it.relate("shark", "flock", "deed", "ignore"), "what shark does about flock"),
        (lambda it: it.paint_kind("whale", "#123456"), "the colour of whale"),
        (lambda it: it.paint_kind("shark", "#123456"), "the colour of shark"),
        (lambda it: it.edits.change(Editor.clear), "the world"),
        (lambda it: it.edits.change(lambda editor: editor.add(disc((2, 2), 0.1))), "the world"),
        (lambda it: it.edits.open_layout("pond.toml", b"nonsense"), "the world"),
        (lambda it: it.place(0, np.ones(2), np.array([1.0, 0.0])), "the place of an agent"),
        (lambda it: it.set("eta", 3.0), "eta"),
        (lambda it: it.move("v0", 0.1), "v0"),
        (lambda it: it.spread("v0", 0.01), "v0"),
        (lambda it: it.setup(SPEC.with_values(agents=40)), "agents"),
    ],
)
def test_whatever_asks_the_simulation_changes_nothing_else(played, command, refused):
    """Commands are what every control, key and message of a browser comes to."""
    state = played.simulation.state
    answer = command(played.simulation)
    if not refused:
        answer.result(60)
        return
    with pytest.raises(InputError, match=f"you play shark: {refused} cannot be changed here"):
        answer.result(60)
    assert (played.simulation.state.values, played.simulation.state.kinds) == (
        state.values,
        state.kinds,
    )


def test_another_scene_is_refused_before_anything_is_changed(played):
    """What is handed in is the scene that runs, not one that was asked for."""
    other = SavedScene("Other", preset_spec("vem", agents=50))
    with pytest.raises(InputError, match="you play shark: "):
        played.open(other)
    assert played.now().spec.agents == 12
    assert played.now().title == "Hunt"


def test_reset_and_another_seed_begin_anew_with_what_was_set(played):
    played.simulation.set_kind("shark", "eta", 1.5).result(60)
    run = played.simulation.state.run
    spec, _ = played.simulation.state.current_specs()
    played.simulation.setup(spec.with_values(seed=77)).result(60)
    until(lambda: played.simulation.state.run > run and not played.simulation.state.busy)
    state = played.simulation.state
    assert (state.spec.seed, state.kinds.kind("shark").parameters["eta"]) == (77, 1.5)
    run = state.run
    played.simulation.reset().result(60)
    until(lambda: played.simulation.state.run > run and not played.simulation.state.busy)
    run = played.simulation.state.run
    played.run.set_up()  # the button Setup
    until(lambda: played.simulation.state.run > run and not played.simulation.state.busy)
    state = played.simulation.state
    assert (state.spec.agents, state.kinds.kind("shark").parameters["eta"]) == (12, 1.5)


def test_who_plays_the_ordinary_agents_has_their_sliders_and_no_others(played):
    played.open_played(SavedScene("Hunt", SPEC), "flock")
    until(lambda: played.simulation.state.spec.seed == 4 and not played.simulation.state.busy)
    until(lambda: (one := played.parameters.controls.get("eta")) and one.visible)
    until(lambda: (one := played.parameters.controls.get("k")) and not one.visible)
    until(lambda: played.kinds.which.value == "flock" and not played.kinds.own_place.visible)
    whale = played.simulation.state.kinds.kind("whale")
    played.simulation.move("v0", 0.04).result(60)
    assert played.simulation.state.values["v0"] == 0.04
    assert played.simulation.state.kinds.kind("whale") == whale
    with pytest.raises(InputError, match="you play flock: k cannot be changed here"):
        played.simulation.move("k", 3).result(60)
    played.open_played(SavedScene("Hunt", SPEC), "")
    until(lambda: (one := played.parameters.controls.get("k")) and one.visible)
    played.simulation.set("k", 3).result(60)


def test_who_plays_nothing_any_more_has_the_world_and_its_tools_again(played):
    played.open_played(SavedScene("Hunt", SPEC), "shark")
    tools = (played.world.tool, played.world.clear, played.world.opening, played.setup.agents)
    until(lambda: not any(control.visible for control in tools))
    with pytest.raises(InputError, match="you play shark: the world cannot be changed here"):
        played.simulation.edits.change(Editor.clear).result(60)
    played.open_played(SavedScene("Hunt", SPEC), "")
    until(lambda: all(control.visible for control in tools))
    until(lambda: not played.simulation.state.busy)
    played.simulation.edits.change(lambda editor: editor.add(disc((2, 2), 0.1))).result(60)
    assert len(played.simulation.run.flock.world.obstacles) == 1
