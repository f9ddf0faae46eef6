"""The View tab shows what the scene has, and keeps what was chosen for scenes that have more."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import viser

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.spec import Spec
from app.viewer.lab.panels.flock_view import FlockView
from app.viewer.live.panels.room_panel import CONTROLS
from app.viewer.live.panels.room_panel import room_defaults as usual_of_room
from app.viewer.panels.view import ViewPanel
from app.viewer.run.frame_builder import FrameBuilder
from app.viewer.run.run_preset import drawing_defaults, preset_spec
from app.viewer.scene.shown.control import controls_of
from app.viewer.scene.shown.drawing_style import (
    AGENTS,
    ANIMALS_UP_TO,
    CAMERA,
    NUMBERED_UP_TO,
    TURNS,
    WORLD,
    DrawingStyle,
)
from tests.viewer import fleet
from tests.viewer.live_fleet import live_frame
from tests.viewer.sky import frame, heading
from worlds.world import World

EVERYWHERE = {"colour", "links", "trails", "reach", "agent_size"}
SEEN = controls_of(DrawingStyle)


@pytest.fixture(scope="module")
def server():
    made = viser.ViserServer(port=0, verbose=False)
    yield made
    made.stop()


@pytest.fixture
def view(server):
    return FlockView(server.gui, drawing_defaults(Spec("vem")), lambda *_: None)


def shown(panel: ViewPanel) -> set[str]:
    """The controls that are in sight, by name."""
    there = {name: one for name, one in panel.form.handles.items() if one.visible}
    for name in there:
        assert panel.form.folders[panel.form.controls[name].group].visible
    return set(there)


def plane(**more):
    """Five agents in an empty plane."""
    level = [heading(0.1 * k)[:2] for k in range(5)]
    place = World("wrap", (20.0, 20.0), ("wrap", "wrap"))
    at = np.arange(10.0).reshape(5, 2)
    one = frame([heading(0.0)] * 5, position=at, heading=np.array(level), world=place)
    return replace(one, **more)


@pytest.mark.parametrize("name", MODELS)
def test_every_model_at_home_shows_what_its_scene_has(view, name):
    flock = Flock(preset_spec(name, seed=3))
    rule, world, mission = flock.model.rule, flock.world, flock.world.mission
    count, space = len(flock.ids), flock.world.dim == 3
    view.fit(FrameBuilder(flock, 1).build())
    expected = {
        "wake": space and count <= ANIMALS_UP_TO and rule.form == "birds",
        "form": count <= ANIMALS_UP_TO and flock.model.body.vehicle is None,
        "trail_length": False,
        "zones": bool(rule.zones),
        "labels": count <= NUMBERED_UP_TO,
        "shadows": count <= 2000,
        "mission": mission is not None and bool(mission.path or mission.goal),
        "start": mission is not None and mission.start is not None,
        "fence": flock.model.body.vehicle is not None and world.edges == ("open", "open"),
        "points": rule.sees_points and bool(world.obstacles or "solid" in world.edges),
    }
    assert shown(view) == EVERYWHERE | {one for one, there in expected.items() if there}
    assert EVERYWHERE | set(expected) == set(SEEN)
    assert view.steer.visible == bool(flock.informed.any())
    assert view.form.folders[WORLD].visible == any(
        expected[one] for one, control in SEEN.items() if control.group == WORLD
    )
    offered = set(view.form["colour"].options)
    assert ("layer" in offered) == bool(flock.informed.any())
    assert ("energy saved" in offered) == ("saved" in flock.model.columns)


def test_each_control_stands_in_its_group_and_each_group_once(server, monkeypatch):
    made, add = [], server.gui.add_folder
    monkeypatch.setattr(server.gui, "add_folder", lambda label: made.append(label) or add(label))
    FlockView(server.gui, drawing_defaults(Spec("vem")), lambda *_: None)
    assert made == [AGENTS, WORLD, CAMERA]
    assert {control.group for control in SEEN.values()} == {AGENTS, WORLD}
    assert {control.group for control in CONTROLS.values()} == {"Cars", WORLD}


def test_a_trail_s_length_is_there_with_a_trail_or_a_wake(view):
    sky = frame([heading(0.0)] * 5)
    view.fit(sky)
    assert "trail_length" not in shown(view)
    for name, value, off in (("trails", "line", "off"), ("wake", True, False)):
        view.form[name].value = value
        view.fit(sky)
        assert "trail_length" in shown(view)
        view.form[name].value = off
    view.form["wake"].value = True
    view.fit(plane())
    assert "trail_length" not in shown(view)


def test_what_is_out_of_sight_keeps_its_value_and_is_saved(view):
    view.take({"wake": True, "trail_length": 300})
    view.fit(plane())
    assert not {"wake", "trail_length"} & shown(view)
    assert view.changed_values() == {"wake": True, "trail_length": 300}
    view.fit(frame([heading(0.0)] * 5))
    assert "wake" in shown(view)
    assert view.drawing_style() == DrawingStyle(wake=True, trail_length=300)


def test_numbers_of_many_are_there_once_one_of_them_is_clicked(view):
    many = frame([heading(0.0)] * (NUMBERED_UP_TO + 1))
    view.fit(many)
    assert "labels" not in shown(view)
    view.fit(replace(many, inspected=object()))
    assert "labels" in shown(view)


def test_two_flocks_show_what_either_has(view):
    led = plane(informed=np.arange(5) == 0)
    view.fit(plane(beside=led))
    assert "layer" in view.form["colour"].options
    assert not view.steer.visible  # its handles are in the first room
    view.fit(plane(beside=plane()))
    assert "layer" not in view.form["colour"].options


def test_a_colouring_that_a_flock_lacks_comes_back_with_one_that_has_it(view):
    led = plane(informed=np.arange(5) == 0)
    view.take({"colour": "layer"})
    assert view.drawing_style().colour == "layer"
    view.fit(plane())
    assert view.drawing_style().colour == "heading"
    assert view.changed_values() == {"colour": "layer"}
    view.fit(led)
    assert view.drawing_style().colour == "layer"
    view.form["colour"].value = "speed"
    view.fit(plane())
    view.fit(led)
    assert view.drawing_style().colour == "speed"


def test_a_number_that_a_flock_lacks_comes_back_too(view):
    view.fit(plane(), ("neighbours", "angle"))
    view.form["colour"].value = "angle"
    assert view.drawing_style().measured == "angle"
    view.fit(plane(), ("neighbours",))
    assert view.drawing_style() == DrawingStyle()
    view.fit(plane(), ("neighbours", "angle"))
    assert view.drawing_style().measured == "angle"


def test_the_next_colour_is_one_that_this_flock_has(view):
    view.fit(plane())
    seen = []
    for _ in range(5):
        seen.append(view.drawing_style().colour)
        view.next_colour()
    assert seen == ["heading", "each its own", "group", "speed", "plain"]


def test_browsers_are_told_only_what_changes(view, server, monkeypatch):
    view.fit(plane())
    told = []
    monkeypatch.setattr(server.gui._websock_interface, "queue_message", told.append)
    view.fit(plane(tick=9))
    assert told == []
    view.fit(frame([heading(0.0)] * 5))
    assert told


def test_the_page_of_real_cars_shows_fence_and_car_only_where_they_are(server):
    room = ViewPanel(server.gui, usual_of_room(100.0), CONTROLS, lambda *_: None, "car")
    one = live_frame()
    room.fit(one)
    assert tuple(room.form["colour"].options) == ("each its own", "heading", "speed", "plain")
    assert ("mission" in shown(room)) == (one.world.mission is not None)
    assert "fence" in shown(room)
    closed = World("hall", fleet.AREA.size, ("solid", "solid"))
    room.fit(replace(one, world=closed))
    assert not {"fence", "mission"} & shown(room)


def event(panel: ViewPanel, name: str, value):
    """A person chooses."""
    panel.form[name].value = value
    return SimpleNamespace(target=panel.form[name], client=True)


def test_what_rises_goes_back_some_turns_unless_somebody_has_said_how_far(server):
    cars = FlockView(server.gui, drawing_defaults(preset_spec("squashing-cars")), lambda *_: None)
    asyncio.run(cars.trailed(event(cars, "trails", "rising in time")))
    assert cars.drawing_style().trail_length * 0.01 == pytest.approx(TURNS)
    assert cars.changed_values() == {"trails": "rising in time"}
    asyncio.run(cars.trailed(event(cars, "trails", "line")))
    assert cars.drawing_style().trail_length == DrawingStyle().trail_length
    cars.form["trail_length"].value = 700
    asyncio.run(cars.trailed(event(cars, "trails", "rising in time")))
    assert cars.drawing_style().trail_length == 700
    cars.take({"trails": "rising in time"})
    assert cars.drawing_style().trail_length * 0.01 == pytest.approx(TURNS)
    assert controls_of(DrawingStyle)["trail_length"].high >= cars.usual.rising


def test_few_cars_have_each_its_own_colour_until_somebody_chooses(view):
    assert view.drawing_style().colour == "heading"
    view.set_defaults(drawing_defaults(preset_spec("squashing-cars")))
    assert (view.drawing_style().colour, view.changed_values()) == ("each its own", {})
    view.take({"colour": "speed", "trails": "line"})
    for spec in (
        preset_spec("vem"),
        preset_spec("squashing-cars", agents=40),
        preset_spec("squashing-cars"),
    ):
        view.set_defaults(drawing_defaults(spec))
        assert view.changed_values() == {"colour": "speed", "trails": "line"}
    view.take({})
    view.set_defaults(drawing_defaults(preset_spec("squashing-cars", agents=40)))
    assert view.drawing_style().colour == "heading"
