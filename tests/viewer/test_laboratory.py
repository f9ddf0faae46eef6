"""The laboratory without a screen: a client that speaks viser's language stands for a browser."""

from __future__ import annotations

import math
import random
import threading
import time
from concurrent.futures import Future
from typing import Any

import msgspec
import numpy as np
import pytest
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from agents.catalogue import MODELS
from agents.individuals import normal, uniform
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.laboratory import UNWATCHED, Laboratory
from app.viewer.panels import followed_value
from app.viewer.panels.differences import REPLACED, TITLE
from app.viewer.panels.kinds import ONE
from app.viewer.panels.parameters import parameter_label
from app.viewer.panels.shell import KEYS
from app.viewer.run.run_preset import preset_spec
from app.viewer.scene.drawing import FASTEST, SLOWEST, period
from tests.live.stand_in import CAMERA
from tests.viewer.waiting import COMPILED, until


@pytest.fixture(scope="module")
def laboratory():
    made = Laboratory(preset_spec("vem-a", agents=30, seed=2), port=0, running=False)
    assert made.simulation.ready.wait(60)
    until(lambda: made.parameters.controls.keys() >= made.simulation.state.values.keys() > set())
    yield made
    made.close()


@pytest.fixture
def browser(laboratory):
    """A client that reads all it gets."""
    client = connect(
        laboratory.address.replace("http", "ws"),
        subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None,
    )

    def read() -> None:
        try:
            for _ in client:
                pass
        except ConnectionClosed:
            pass

    threading.Thread(target=read, daemon=True).start()
    client.send(msgspec.msgpack.encode(CAMERA))
    until(lambda: laboratory.browsers() == 1)
    yield client
    client.close()
    until(lambda: laboratory.browsers() == 0)


def say(client: Any, **message: Any) -> None:
    client.send(msgspec.msgpack.encode(message))


def turn(client: Any, control: Any, value: Any) -> None:
    say(client, type="GuiUpdateMessage", uuid=control._impl.uuid, updates={"value": value})


def press(client: Any, button: Any) -> None:
    turn(client, button, True)


SLIDERS = {"weight", "radius", "catch", "own"}


def test_every_parameter_of_the_model_has_a_control_with_its_range(laboratory):
    from agents.catalogue import MODELS
    from agents.models.declare import declared

    controls = laboratory.parameters.controls
    for one in declared(MODELS["vem-a"].parameters):
        if not one.choices:
            assert (controls[one.name].min, controls[one.name].max) == (one.low, one.high)
        assert controls[one.name].label == parameter_label(one)[0]
        assert one.source in controls[one.name].hint


def test_what_a_scene_sets_is_no_change(laboratory):
    panel, state = laboratory.parameters, laboratory.simulation.state
    for eta in (0.7, state.values["eta"]):
        laboratory.open(SavedScene("A scene", state.spec.with_values(parameters={"eta": eta})))
        until(lambda eta=eta: panel.begun["eta"] == eta and panel.last_run is None)
        assert (panel.changed.content, panel.changes, panel.back.visible) == ("", {}, False)
    laboratory.simulation.pause()


def test_what_is_changed_is_listed_and_goes_back(laboratory, browser):
    panel, simulation = laboratory.parameters, laboratory.simulation
    eta = lambda: simulation.run.flock.parameters.eta  # noqa: E731
    assert not panel.back.visible
    for value in (1.4, 1.5):
        turn(browser, panel.controls["eta"], value)
    until(lambda: "<td>Noise η</td><td>0 → 1.5</td>" in panel.changed.content)
    assert panel.back.visible
    turn(browser, panel.back, "All back")
    until(lambda: eta() == 0.0)
    until(lambda: panel.changed.content == "" and panel.controls["eta"].value == 0.0)
    turn(browser, panel.back, "Undo")
    until(lambda: eta() == 1.5)
    turn(browser, panel.back, "Undo")
    until(lambda: eta() == 0.0)
    until(lambda: not panel.back.visible)


def test_what_counts_for_nothing_cannot_be_moved(laboratory, browser):
    controls = laboratory.parameters.controls
    for choice, idle in (("nearest", "r"), ("metric", "k")):
        turn(browser, controls["neighbours"], choice)
        until(
            lambda idle=idle: [one for one in controls if controls[one].disabled] == [idle],
            COMPILED,
        )


def test_a_flock_that_nobody_watches_stands_after_a_while(laboratory):
    laboratory.simulation.go()
    until(lambda: laboratory.simulation.state.running)
    assert not laboratory.rest(), "somebody has just watched it"
    laboratory.watched_at -= UNWATCHED
    assert laboratory.rest()
    until(lambda: not laboratory.simulation.state.running)
    laboratory.watched_at -= UNWATCHED
    assert not laboratory.rest(), "it stands already"


def test_an_answer_to_an_older_value_takes_a_slider_nowhere(laboratory, browser, monkeypatch):
    panel, simulation = laboratory.parameters, laboratory.simulation
    eta, answers = panel.controls["eta"], []

    def asked(*_):
        answers.append(Future())
        return answers[-1]

    monkeypatch.setattr(simulation, "move", asked)
    monkeypatch.setattr(followed_value, "DRAG", 0.0)
    for value in (1.0, 2.0, 3.0):
        turn(browser, eta, value)
    until(lambda: len(answers) == 3)
    answers[0].set_result(2.0)
    answers[1].set_result(2.0)
    time.sleep(0.2)
    assert eta.value == 3.0, "its own answer is still to come"
    answers[2].set_exception(ValueError("refused"))
    until(lambda: eta.value == simulation.state.values["eta"])


def test_a_slider_comes_to_what_the_flock_has(laboratory):
    panel, simulation = laboratory.parameters, laboratory.simulation
    simulation.set("eta", 0.75)
    until(lambda: panel.controls["eta"].value == 0.75)
    answer = Future()
    panel.followed["eta", False].give(1.75, answer)
    time.sleep(0.3)
    assert panel.controls["eta"].value == 1.75, "it is not taken from whoever moves it"
    answer.set_result(1.75)
    until(lambda: panel.controls["eta"].value == 0.75)
    panel.set_parameter("eta", 0.0, False)
    until(lambda: simulation.state.values["eta"] == 0.0)


def test_every_key_has_its_command(laboratory):
    commands = laboratory.server.gui._command_handle_from_uuid.values()
    assert {command.hotkey for command in commands} == set(KEYS)


def test_a_slider_acts_and_a_hostile_value_does_not(laboratory, browser):
    eta = laboratory.parameters.controls["eta"]
    turn(browser, eta, 2.0)
    until(lambda: laboratory.simulation.run.flock.parameters.eta == 2.0)
    for value in (math.nan, "2", None, [1], {"a": 1}):
        turn(browser, eta, value)
    turn(browser, eta, 1e9)
    until(lambda: laboratory.simulation.run.flock.parameters.eta == eta.max)
    assert not laboratory.simulation.state.error


def test_agents_are_coloured_by_any_number_that_they_have(laboratory, browser):
    colour = laboratory.view.form["colour"]
    until(lambda: "neighbours" in colour.options)
    turn(browser, colour, "neighbours")
    until(lambda: laboratory.simulation.frame.measured is not None)
    flock = laboratory.simulation.run.flock
    expected = np.bincount(flock.links().ravel(), minlength=len(flock.ids))
    assert laboratory.simulation.frame.measured.tolist() == expected.tolist()
    laboratory.view.next_colour()
    until(lambda: laboratory.simulation.frame.measured is None)
    assert colour.value == "heading"


def test_a_colouring_that_was_chosen_just_now_is_not_taken_back(laboratory):
    view, colour = laboratory.view, laboratory.view.form["colour"]
    chosen = [one for one in colour.options if one != colour.value]
    for one in [*chosen, "heading"]:
        colour._impl.value = one  # as viser does some time before it calls whoever waits for it
        view.offer(tuple(colour.options))
        assert (colour.value, view.colour) == (one, one)


def test_the_leader_is_steered_within_the_world(laboratory):
    size = laboratory.simulation.frame.size
    laboratory.steer(size * 1.25, np.array([0.0, -3.0]))
    until(lambda: np.allclose(laboratory.simulation.frame.position[0], 0.25 * size))
    assert laboratory.simulation.frame.heading[0].tolist() == [0.0, -1.0]


@pytest.mark.parametrize(
    ("position", "heading"),
    [
        ([math.nan, 0.0], [1.0, 0.0]),
        ([0.0, 0.0], [0.0, 0.0]),
        ([0.0, 0.0], [math.inf, 0.0]),
        ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ([0.0], [1.0, 0.0]),
    ],
)
def test_the_leader_is_not_steered_to_nowhere(laboratory, position, heading):
    flock = laboratory.simulation.run.flock
    before = flock.position.copy(), flock.heading.copy()
    laboratory.steer(np.array(position), np.array(heading))
    laboratory.simulation.spec().result(60)
    np.testing.assert_array_equal(flock.position, before[0])
    np.testing.assert_array_equal(flock.heading, before[1])


def test_what_somebody_chooses_is_measured_and_shown(laboratory, browser):
    simulation, chart = laboratory.simulation, laboratory.plots.charts[2]
    assert "nearest-neighbour" not in simulation.readings.values
    turn(browser, chart.choice, "nearest neighbour")
    until(lambda: "nearest-neighbour" in simulation.readings.values)
    until(lambda: chart.plot.chart.plot.visible and chart.choice.label.startswith("Plot 3: "))
    turn(browser, chart.choice, "anything else")
    turn(browser, laboratory.more.switches["susceptibility"], True)
    until(lambda: "susceptibility" in laboratory.monitors.blocks["more"].content)
    assert chart.names == ("nearest-neighbour",)
    turn(browser, chart.choice, "nothing")
    until(lambda: "nearest-neighbour" not in simulation.readings.values)
    assert not chart.plot.chart.plot.visible


def test_what_no_flock_here_can_do_has_no_panel(laboratory):
    until(lambda: laboratory.plots.offered)
    assert not laboratory.monitors.blocks["crash-count"].visible
    assert not laboratory.crashes.first.list.visible
    assert not laboratory.more.switches["joules-per-metre"].visible
    assert "crashes" not in laboratory.plots.charts[0].choice.options
    assert laboratory.more.switches["correlation-length"].visible


def test_late_messages_and_wind_are_set_up_from_the_panel(laboratory, browser):
    simulation, fields = laboratory.simulation, laboratory.setup.plain
    given = {"delay": 2.0, "lost": 0.5, "wind": 0.01, "wind_heading": 90.0}
    for name, value in given.items():
        uuid = fields[name]._impl.uuid
        say(browser, type="GuiUpdateMessage", uuid=uuid, updates={"value": value})
        until(lambda name=name, value=value: fields[name].value == value)
    simulation.setup(*laboratory.setup.next_pairing(simulation.state))
    until(lambda: simulation.run.flock.options.delay == 2.0, 60)
    assert {name: getattr(simulation.run.flock.spec, name) for name in given} == given
    simulation.setup(preset_spec("vem-a", agents=30, seed=2))
    until(lambda: simulation.run.flock.options.delay == 0.0, 60)


def test_it_survives_a_browser_that_sends_nonsense(laboratory, browser):
    gui = laboratory.server.gui
    chance = random.Random(1)
    values = [math.nan, math.inf, -1, 0, 1e300, "x", None, True, [], {}, b"\xff", 10**12, "Reset"]
    agents = laboratory.setup.agents._impl.uuid
    end = time.monotonic() + 3.0
    while time.monotonic() < end:
        uuid = chance.choice([*gui._gui_input_handle_from_uuid, None, 3, [1]])
        value = chance.choice(values)
        updates = chance.choice([{"value": value}] * 5 + [{"visible": False}, {}, [], None])
        if uuid != agents:
            say(browser, type="GuiUpdateMessage", uuid=uuid, updates=updates)
        time.sleep(0.02)  # as often as a browser may, which is cut off beyond that
    simulation = laboratory.simulation
    before = simulation.state.run
    simulation.setup(preset_spec("vem-a", agents=30))
    until(lambda: simulation.state.run > before, 60)
    simulation.run_at(math.inf)
    simulation.go().result(60)
    until(lambda: simulation.frame.tick > 5)
    assert laboratory.drawing.thread.is_alive()


def test_fewer_frames_for_many_browsers_and_large_flocks():
    assert period(100, 1) == FASTEST
    assert period(1000, 40) == pytest.approx(1000 * 40 * 28 / 16e6)
    assert period(10**6, 10) == SLOWEST


def test_agents_differ_by_a_slider_of_the_spread_and_undo_makes_them_alike(laboratory, browser):
    panel, form, simulation = laboratory.parameters, laboratory.differences, laboratory.simulation
    until(lambda: form.offered and form.slider is not None)
    label = next(label for label, one in form.offered.items() if one.parameter.name == "eta")
    before, panel.past = form.slider, []
    turn(browser, form.which, label)
    until(lambda: form.slider not in (None, before) and form.followed is not None)
    assert form.slider.label.startswith("Spread of η")
    simulation.set("eta", 1.0).result(COMPILED)
    turn(browser, form.slider, 0.2)
    until(lambda: simulation.state.values["eta"] == normal(1.0, 0.2))
    until(lambda: form.folder.label == f"{TITLE}: 1")
    assert "normal(1, 0.2)" in form.said.content
    until(lambda: "own eta" in laboratory.view.form["colour"].options)
    turn(browser, panel.controls["eta"], 1.5)
    until(lambda: simulation.state.values["eta"] == normal(1.5, 0.2))
    until(lambda: "→ normal(1.5, 0.2)" in panel.changed.content)
    assert laboratory.now().spec.individuals == {"eta": normal(1.5, 0.2)}
    simulation.set("eta", uniform(0.5, 1.5)).result(COMPILED)
    until(lambda: "uniform(0.5, 1.5)" in form.said.content)
    assert REPLACED in form.said.content
    while panel.past:  # what follows within a second is one change
        panel.undo()
    until(lambda: simulation.state.values["eta"] == 1.0)
    until(lambda: form.slider.value == 0.0 and form.folder.label == TITLE)
    until(lambda: "own eta" not in laboratory.view.form["colour"].options)


def test_a_predator_is_added_tuned_undone_and_removed(laboratory, browser):
    panel, simulation = laboratory.kinds, laboratory.simulation
    assert ONE in panel.listed.content
    ordinary = simulation.state.agents
    press(browser, panel.predator)
    until(lambda: simulation.state.kinds.names == ("flock", "predator"), COMPILED)
    until(lambda: panel.which.value == "predator" and set(panel.sliders) == SLIDERS, COMPILED)
    relation = simulation.state.kinds.of("predator", "flock")
    assert relation.deed == "chase"
    assert 0.0 < relation.catch < relation.radius
    assert laboratory.now().spec.kinds[0].parameters["v0"] > simulation.state.values["v0"]
    until(lambda: laboratory.view.form["colour"].value == "kind", COMPILED)
    until(lambda: "predator <b>1</b>" in panel.listed.content)
    until(lambda: "polarisation of predator" in laboratory.plots.choices)
    assert "catches" in laboratory.plots.choices
    turn(browser, panel.sliders["weight"], 5.0)
    until(lambda: simulation.state.kinds.of("predator", "flock").weight == 5.0)
    laboratory.parameters.undo()
    until(lambda: simulation.state.kinds.of("predator", "flock") == relation)
    turn(browser, panel.sliders["own"], 0.09)
    until(lambda: simulation.state.kinds.kind("predator").parameters["v0"] == 0.09)
    turn(browser, panel.deed, "flees from")
    until(lambda: set(panel.sliders) == {"weight", "radius", "own"})
    laboratory.parameters.undo()
    until(lambda: simulation.state.kinds.of("predator", "flock") == relation)
    turn(browser, panel.number, 3)
    until(lambda: simulation.state.kinds.kind("predator").agents == 3)
    until(lambda: simulation.state.agents == ordinary + 3)
    assert simulation.state.kinds.kind("predator").parameters["v0"] == 0.09
    turn(browser, panel.new_name, "two words")
    press(browser, panel.add)
    until(lambda: any("kind 'two words' is" in said for said in laboratory.notices.shown))
    turn(browser, panel.new_name, "whale")
    turn(browser, panel.new_deed, "ignores")
    assert {"gregoire-chate", "vicsek1995"} <= set(panel.new_model.options)
    assert not {"couzin", "hwvem"} & set(panel.new_model.options)
    turn(browser, panel.new_model, "gregoire-chate")
    press(browser, panel.add)
    until(lambda: simulation.state.kinds.names == ("flock", "predator", "whale"), COMPILED)
    until(lambda: panel.which.value == "whale")
    until(lambda: "whale <b>2</b>, by gregoire-chate" in panel.listed.content, COMPILED)
    default = MODELS["gregoire-chate"].parameters().v0
    until(lambda: "own" in panel.sliders and panel.sliders["own"].value == default)
    turn(browser, panel.sliders["own"], 0.07)
    until(lambda: simulation.state.kinds.kind("whale").parameters == {"v0": 0.07})
    press(browser, panel.remove)
    until(lambda: simulation.state.kinds.names == ("flock", "predator"))
    seed = simulation.state.spec.seed
    # Another test may have left nonsense in the tab Setup, such as a spacing that nothing fits.
    laboratory.setup.follow(simulation.state.spec, None)
    laboratory.run.set_up()
    until(lambda: simulation.state.spec.seed == seed + 1)
    assert simulation.state.kinds.kind("predator").agents == 3
    until(lambda: panel.which.value == "predator")
    press(browser, panel.remove)
    until(lambda: simulation.state.kinds.names == ("flock",))
    until(lambda: laboratory.view.form["colour"].value == "heading")
    assert ONE in panel.listed.content
