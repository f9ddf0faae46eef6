"""Who plays a kind, and sends by hand what their page has no controls for."""

from __future__ import annotations

import json
import random
import threading
from contextlib import contextmanager
from dataclasses import replace
from typing import Any
from urllib.parse import quote, urlencode

import msgspec
import numpy as np
import pytest
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from agents.kinds import Kind, chase, kind_table
from app.front import controls
from app.viewer.gallery.saved_scene import SavedScene, pack_scene
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.inspector import LOOKING
from app.viewer.lab.panels.world_panel import BOX, DISC, NONE, SELECT
from app.viewer.run.allowance import Allowance
from app.viewer.run.played_kind import PlayedKind, with_kinds_apart
from app.viewer.run.run_preset import preset_spec
from app.viewer.scene.marks.handles import Drag
from tests.live.stand_in import CAMERA
from tests.viewer.http_client import ask
from tests.viewer.waiting import COMPILED, until
from worlds.obstacles import Disc
from worlds.world import World

PILLAR = Disc(centre=(6.0, 6.0), radius=0.5)
WORLD = World("pond", (8.0, 8.0), ("wrap", "wrap"), obstacles=(PILLAR,))
SHARK = Kind("shark", 2, v0=0.05, steered=True, to={"flock": chase(2.0, 1.5, catch=0.1)})
WHALE = Kind("whale", 1, steered=True)
SPEC = with_kinds_apart(preset_spec("vem-a", agents=12, seed=4, world=WORLD, kinds=[SHARK, WHALE]))
SCENE = SavedScene("Hunt", SPEC)
MARKED = {"X-Flockscope": "scene"}
REFUSED = "you play shark: {} cannot be changed here"
DOWN = np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory):
    """Of a student of a class who plays the sharks."""
    made = Laboratory(
        port=0,
        running=False,
        results=tmp_path_factory.mktemp("results"),
        opened=SCENE,
        allowance=Allowance(),
        played="shark",
    )
    assert made.simulation.ready.wait(COMPILED)
    until(lambda: made.simulation.state.compiling is None, COMPILED)
    until(lambda: made.kinds.sliders and made.simulation.frame is not None)
    yield made
    made.close()


@contextmanager
def page(laboratory):
    """A line to the laboratory by which anything can be sent."""
    line = connect(
        laboratory.address.replace("http", "ws"),
        subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None,
    )

    def read() -> None:
        try:
            for _ in line:
                pass
        except ConnectionClosed:
            pass

    threading.Thread(target=read, daemon=True).start()
    line.send(msgspec.msgpack.encode(CAMERA))
    until(lambda: laboratory.browsers() == 1)
    yield line
    line.close()
    until(lambda: laboratory.browsers() == 0)


@pytest.fixture
def eve(laboratory):
    """Who sends it, to a run as it was begun, of which nothing has been refused yet."""
    simulation = laboratory.simulation
    run = simulation.state.run
    simulation.setup(SPEC).result(COMPILED)
    until(lambda: simulation.state.run > run and not simulation.state.busy)
    while not simulation.notices.empty():
        simulation.notices.get()
    laboratory.notices.shown = {}
    with page(laboratory) as line:
        yield line


def send(line: Any, control: Any, value: Any) -> None:
    """What a page sends of a control that is turned, or pressed."""
    message = {"type": "GuiUpdateMessage", "uuid": control._impl.uuid, "updates": {"value": value}}
    line.send(msgspec.msgpack.encode(message))


def told(laboratory, what: str) -> None:
    """Wait until every browser is told that this cannot be changed."""
    until(lambda: REFUSED.format(what) in laboratory.notices.shown, what=what)


def demand_unchanged(laboratory) -> None:
    """The run is that of the class, but for the sharks' own numbers and the seed."""
    simulation = laboratory.simulation
    simulation.tell(lambda: None).result(COMPILED)  # all that was sent has been done
    role, state = PlayedKind("shark", SPEC), simulation.state
    role.demand_run(state.current_specs()[0], state.beside)
    role.demand_run(laboratory.now().spec, laboratory.now().beside)
    assert simulation.run.flock.world == simulation.edits.editor.world == WORLD
    kinds = kind_table(state.kinds.kinds, state.kinds.to)
    assert kinds.kind("whale") == kind_table(SPEC.kinds, SPEC.to).kind("whale")


WAYS = {
    "a disc": lambda eve, world: send(eve, world.tool, DISC),
    "a box": lambda eve, world: send(eve, world.tool, BOX),
    "all obstacles": lambda eve, world: send(eve, world.clear, True),
    "undo": lambda eve, world: send(eve, world.acts, "Undo"),
    "redo": lambda eve, world: send(eve, world.acts, "Redo"),
    "a polygon": lambda eve, world: send(eve, world.close, "Close"),
}


@pytest.mark.parametrize("way", WAYS)
def test_no_control_of_the_world_that_is_hidden_changes_it(laboratory, eve, way):
    world = laboratory.world
    hidden = (world.tool, world.which, world.acts, world.clear, world.opening, world.goal)
    until(lambda: not any(one.visible for one in (*hidden, *world.sliders.values())))
    assert world.save.visible
    assert REFUSED.format("the world") in world.note.content
    WAYS[way](eve, world)
    told(laboratory, "the world")
    demand_unchanged(laboratory)
    until(lambda: world.tool.value == SELECT)


@pytest.mark.usefixtures("eve")
@pytest.mark.parametrize("thing", [0, 1])
@pytest.mark.parametrize("done", [False, True])
def test_no_handle_is_dragged_that_somebody_had_before(laboratory, thing, done):
    """Of an obstacle, or of the goal; nor what only a step of a drag would change."""
    key = laboratory.simulation.edits.editor.newest_key if thing else 0
    laboratory.world.handle_drag(Drag(key, f"g{thing}{done}", (0.5, 0.5, 0.0), 10.0, done))
    told(laboratory, "the world")
    demand_unchanged(laboratory)


@pytest.mark.usefixtures("eve")
def test_a_click_with_a_tool_from_before_changes_nothing(laboratory):
    laboratory.world.tool._impl.value = DISC
    laboratory.world.handle_click(np.array([2.0, 2.0, 50.0]), DOWN)
    told(laboratory, "the world")
    demand_unchanged(laboratory)


def test_a_selected_obstacle_is_selected_no_more(laboratory, eve):
    world = laboratory.world
    label = next(one for one in world.which.options if one != NONE)
    send(eve, world.which, label)
    send(eve, world.sliders["radius"], 2.0)
    laboratory.clicked(None, np.array([6.0, 6.0, 50.0]), DOWN)
    until(lambda: laboratory.world.selected == 0)
    demand_unchanged(laboratory)


@pytest.mark.usefixtures("eve")
@pytest.mark.parametrize("name", ["mine.toml", "mine.svg", "nonsense.dxf"])
def test_no_layout_is_opened_and_none_is_read(laboratory, name):
    content = WORLD.to_toml().encode() if name == "mine.toml" else b"<svg/>"
    laboratory.world.questions.open_layout(None, name, content)
    told(laboratory, "the world")
    demand_unchanged(laboratory)


def test_no_agent_is_dragged_about(laboratory, eve):
    """The information agent has handles in the laboratory; in a role it has none."""
    flock = laboratory.simulation.run.flock
    before = flock.position.copy()
    send(eve, laboratory.view.steer, True)
    laboratory.steer(np.array([1.0, 1.0]), np.array([0.0, 1.0]))
    told(laboratory, "the place of an agent")
    until(lambda: not laboratory.view.steer.value)
    np.testing.assert_array_equal(flock.position, before)
    assert not laboratory.view.steer.visible


@pytest.mark.usefixtures("eve")
@pytest.mark.parametrize(("kind", "status"), [("shark", 200), ("whale", 400)])
def test_only_agents_of_the_own_kind_are_steered_by_hand(laboratory, kind, status):
    simulation = laboratory.simulation
    until(lambda: simulation.frame.run == simulation.state.run)
    frame = simulation.frame
    row = int(np.flatnonzero(frame.kind == frame.kinds.names.index(kind))[0])
    asked = {"who": "0123456789abcdef" * 2, "n": 1, "agent": int(frame.ids[row])}
    asked |= {"run": frame.run, "turn": "1.0", "push": "0.0", "climb": "0.0"}
    answer = ask(laboratory.port, f"/steer?{urlencode(asked)}", MARKED)
    assert answer.status == status
    assert bool(simulation.hands.hands) == (status == 200)
    if status == 400:
        assert answer.text.strip() == REFUSED.format("the steering of whale")
    laboratory.select(row)
    card = laboratory.inspector
    until(lambda: f' {frame.ids[row]}" data-at=' in card.head.content)
    until(lambda: LOOKING not in card.head.content, COMPILED)
    until(lambda: ("data-steer" in card.head.content) == (status == 200), COMPILED)
    assert card.steer.visible == (status == 200)
    laboratory.select(None)


def others() -> dict[str, SavedScene]:
    """Scenes that differ from the class's by one thing that the teacher decides."""
    shark, whale = SPEC.kinds
    to = {"flock": replace(shark.to["flock"], power=2.0)}
    painted = Kind("shark", 2, steered=True, colour="#123456", parameters=shark.parameters)
    changes: dict[str, dict[str, Any]] = {
        "world": {"world": "wrap"},
        "agents": {"agents": 13},
        "delay": {"delay": 2.0},
        "the number of whale": {"kinds": [shark, Kind("whale", 2, steered=True)]},
        "what shark does about flock": {"kinds": [replace(shark, to=to), whale]},
        "the colour of shark": {"kinds": [replace(painted, to=shark.to), whale]},
    }
    return {name: SavedScene("x", SPEC.with_values(**change)) for name, change in changes.items()}


@pytest.mark.usefixtures("eve")
@pytest.mark.parametrize("what", others())
def test_no_scene_of_an_address_is_opened(laboratory, what):
    """As the gallery opens it, and as a page does that somebody has been sent."""
    packed = quote(pack_scene(others()[what]))
    for more in ("&sure=1", "&sure=1&new=1"):
        answer = ask(laboratory.port, f"/open?scene={packed}{more}", MARKED)
        assert (answer.status, answer.text.strip()) == (400, REFUSED.format(what))
    demand_unchanged(laboratory)


@pytest.mark.usefixtures("eve")
@pytest.mark.parametrize("scene", ["model%3Acouzin", "world%3Aobstacles", "lesson%3Awho-leads"])
def test_no_scene_of_the_gallery_is_opened(laboratory, scene):
    answer = ask(laboratory.port, f"/open?scene={scene}&sure=1", MARKED)
    assert answer.status == 400
    assert answer.text.startswith("you play shark: ")
    demand_unchanged(laboratory)


def test_setup_takes_another_seed_whatever_its_hidden_controls_are_given(laboratory, eve):
    setup, simulation = laboratory.setup, laboratory.simulation
    hidden = (setup.model, setup.beside, setup.agents, setup.world, setup.dim, setup.size)
    fields = (*hidden, setup.conditions, *setup.plain.values())
    until(lambda: not any(control.visible for control in fields))
    assert setup.seed.visible
    assert setup.new_seed.visible
    send(eve, setup.agents, 40)
    until(lambda: setup.agents.value == 40)
    send(eve, laboratory.run.actions, "Setup")
    told(laboratory, "agents")
    demand_unchanged(laboratory)
    send(eve, setup.agents, 12)
    until(lambda: setup.agents.value == 12)
    run = simulation.state.run
    send(eve, laboratory.run.actions, "Setup")
    until(lambda: simulation.state.run > run)
    demand_unchanged(laboratory)


def test_nothing_that_a_page_can_send_changes_what_the_teacher_decides(
    laboratory, eve, count, monkeypatch
):
    """Every control of the page with values that it takes, in random order."""
    monkeypatch.setattr(controls, "PRESSES", (1e6, 1e6))
    handles = laboratory.server.gui._gui_input_handle_from_uuid
    chance = random.Random(7)
    sent = 0
    for uuid in chance.sample(list(handles), len(handles)):
        control = handles.get(uuid)
        if control is None or control in (laboratory.run.switch, laboratory.world.save):
            continue
        for value in values_of(control, chance):
            message = {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}}
            eve.send(msgspec.msgpack.encode(message))
            sent += 1
    speed = laboratory.run.speed
    last = next(one for one in speed.options if one != speed.value)
    until(lambda: send(eve, speed, last) or speed.value == last)  # all before it have come too
    assert sent > 100
    until(lambda: not laboratory.simulation.state.busy)
    demand_unchanged(laboratory)
    count(messages=sent)


def values_of(control: Any, chance: random.Random) -> list[Any]:
    """Some values that a control takes."""
    if hasattr(control, "options"):
        return [chance.choice(control.options) if control.options else ""]
    if isinstance(control, viser.GuiButtonHandle):
        return [True]
    if isinstance(control.value, bool):
        return [not control.value]
    if isinstance(control.value, int | float) and hasattr(control, "min"):
        return [control.min, control.max]
    return [json.dumps(chance.random())]
