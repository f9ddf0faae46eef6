"""The World tab without a screen: clicks, drags and keys, also in orders that make no sense."""

from __future__ import annotations

import math
import threading

import numpy as np
import pytest

from app.front.controls import set_value
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.setup import describe_differences
from app.viewer.lab.panels.world_panel import BOX, DISC, POLYGON, SELECT
from app.viewer.run.run_preset import preset_spec
from app.viewer.scene.marks.handles import Drag
from tests.viewer.waiting import until
from worlds.world import World

START = preset_spec("vem-a", agents=30, seed=2, size=20.0, world="open")
DOWN = np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def served():
    made = Laboratory(START, port=0, running=False)
    made.simulation.edits.prepare = lambda: None
    assert made.simulation.ready.wait(60)
    yield made
    made.close()


@pytest.fixture
def laboratory(served):
    """A paused flock in an empty world, no tool, no selection, no notice."""
    simulation = served.simulation
    before = simulation.state.run
    served.world.drop_tool()
    served.world.select(0)
    simulation.setup(START)
    until(lambda: simulation.state.run > before and simulation.edits.editor.past == ())
    while not simulation.notices.empty():
        simulation.notices.get()
    served.notices.shown = {}
    return served


def told(laboratory) -> str:
    """A notice that is told now; the drawing thread passes notices on to browsers."""
    return until(lambda: next(iter(laboratory.notices.shown), ""), 60)


def settled(laboratory) -> World:
    """The world after all that was told has been done."""
    laboratory.simulation.edits.change(lambda editor: editor).result(60)
    laboratory.world.refresh()
    return laboratory.simulation.edits.editor.world


def click(laboratory, x: float, y: float) -> None:
    laboratory.clicked(None, np.array([x, y, 50.0]), DOWN)


def placed(laboratory, x: float = 5.0, y: float = 6.0) -> int:
    """Place a disc, select it, and return its key."""
    set_value(laboratory.world.tool, DISC)
    click(laboratory, x, y)
    settled(laboratory)
    set_value(laboratory.world.tool, SELECT)
    click(laboratory, x, y)
    assert laboratory.world.selected
    return laboratory.world.selected


def drag(laboratory, key: int, x: float, done: bool = False, gesture: str = "g") -> None:
    laboratory.world.handle_drag(Drag(key, gesture, (x, 0.0, 0.0), 0.0, done))


def test_a_click_places_what_the_tool_says_with_the_measures_of_the_sliders(laboratory):
    set_value(laboratory.world.tool, DISC)
    set_value(laboratory.world.sliders["radius"], 1.5)
    click(laboratory, 5.0, 6.0)
    set_value(laboratory.world.tool, BOX)
    for name, value in {"width": 4.0, "depth": 2.0, "turn": 90.0}.items():
        set_value(laboratory.world.sliders[name], value)
    click(laboratory, 12.0, 6.0)
    disc, box = settled(laboratory).obstacles
    assert (disc.centre, disc.radius) == ((5.0, 6.0), 1.5)
    assert (box.low, box.high) == ((11.0, 4.0), (13.0, 8.0))
    assert laboratory.selected is None


def test_with_no_tool_a_click_selects_the_obstacle_or_the_agent_or_nothing(laboratory):
    key = placed(laboratory)
    click(laboratory, 15.0, 15.0)
    assert laboratory.world.selected == 0
    click(laboratory, 5.5, 6.0)
    assert laboratory.world.selected == key
    laboratory.clicked(3, np.array([5.5, 6.0, 50.0]), DOWN)
    assert (laboratory.selected, laboratory.world.selected) == (3, 0)
    laboratory.select(None)


def test_a_tool_takes_the_click_even_on_an_agent(laboratory):
    set_value(laboratory.world.tool, DISC)
    laboratory.clicked(3, np.array([5.0, 6.0, 50.0]), DOWN)
    assert len(settled(laboratory).obstacles) == 1
    assert laboratory.selected is None


def test_corners_make_a_polygon_when_the_last_is_clicked_twice_and_undo_takes_one_back(laboratory):
    panel = laboratory.world
    chosen = threading.Event()
    laboratory.simulation.edits.prepare = chosen.set
    set_value(panel.tool, POLYGON)
    assert chosen.wait(60)
    for corner in [(2.0, 2.0), (6.0, 2.0), (9.0, 9.0)]:
        click(laboratory, *corner)
    panel.undo()
    assert panel.corners == [(2.0, 2.0), (6.0, 2.0)]
    click(laboratory, 6.0, 5.0)
    click(laboratory, 6.05, 5.0)
    assert settled(laboratory).obstacles[0].points == ((2.0, 2.0), (6.0, 2.0), (6.0, 5.0))
    assert panel.corners == []


def test_a_drag_moves_and_is_one_step_back(laboratory):
    key = placed(laboratory)
    for x in (1.0, 2.0, 3.0):
        drag(laboratory, key, x)
    drag(laboratory, key, 4.0, done=True)
    assert settled(laboratory).obstacles[0].centre == (9.0, 6.0)
    laboratory.world.undo()
    assert settled(laboratory).obstacles[0].centre == (5.0, 6.0)
    laboratory.world.undo()
    assert settled(laboratory).obstacles == ()
    assert laboratory.world.selected == 0


def test_delete_then_drag_undo_while_dragging_and_setup_while_dragging_do_no_harm(laboratory):
    simulation, panel = laboratory.simulation, laboratory.world
    key = placed(laboratory)
    drag(laboratory, key, 1.0)
    panel.delete()
    drag(laboratory, key, 2.0)
    drag(laboratory, key, 3.0, done=True)
    panel.delete()
    assert settled(laboratory).obstacles == ()
    panel.undo()
    panel.undo()
    drag(laboratory, key, 2.0)
    panel.undo()
    drag(laboratory, key, 3.0, done=True)
    assert settled(laboratory).obstacles[0].centre == (8.0, 6.0)
    drag(laboratory, key, 1.0, gesture="h")
    before = simulation.state.run
    simulation.setup(START)
    drag(laboratory, key, 2.0, gesture="h")
    until(lambda: simulation.state.run > before)
    drag(laboratory, key, 3.0, gesture="h", done=True)
    assert settled(laboratory).obstacles == ()
    assert not laboratory.notices.shown
    assert not simulation.state.error


@pytest.mark.parametrize("by", [math.nan, math.inf, 1e300, -1e9])
def test_a_hostile_drag_moves_nothing_and_its_end_is_told(laboratory, by):
    key = placed(laboratory)
    drag(laboratory, key, by)
    drag(laboratory, key, by, done=True)
    assert settled(laboratory).obstacles[0].centre == (5.0, 6.0)
    assert told(laboratory)


@pytest.mark.parametrize("ray", [(math.nan, 0.0, -1.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)])
def test_a_click_that_does_not_meet_the_floor_places_nothing(laboratory, ray):
    set_value(laboratory.world.tool, DISC)
    laboratory.clicked(None, np.array([5.0, 5.0, 50.0]), np.array(ray))
    assert settled(laboratory).obstacles == ()


def test_the_goal_has_no_handles_where_there_is_none(laboratory):
    assert not laboratory.world.goal.visible
    laboratory.world.handle_drag(Drag(0, "goal", (1.0, 0.0, 0.0), 0.0, True))
    assert "no goal" in told(laboratory)


def test_setup_proposes_the_world_that_was_built_and_reset_keeps_it(laboratory):
    placed(laboratory)
    simulation = laboratory.simulation
    before = simulation.state.run
    laboratory.run.set_up()
    assert "(edited)" in laboratory.setup.world.value
    until(lambda: simulation.state.run > before)
    assert len(simulation.run.flock.world.obstacles) == 1
    state = simulation.state
    assert describe_differences(laboratory.setup.chosen_pairing(), (state.spec, state.beside)) == []
    simulation.edits.change(lambda editor: editor.undo()).result(60)
    until(lambda: "(edited)" not in laboratory.setup.world.value)
