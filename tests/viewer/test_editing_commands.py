"""Changes of the world as a running simulation carries them out."""

from __future__ import annotations

import threading
from concurrent.futures import wait

import numpy as np
import pytest

from agents.spec import Spec
from app.viewer.editing.editor import Editor, disc, polygon
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from tests.viewer.stub_flock import StubFlock
from tests.viewer.waiting import until
from worlds.input_error import InputError
from worlds.obstacles import rectangle
from worlds.queries.clearance import clearance
from worlds.world import World

START = preset_spec(agents=300, size=10.0)
"""So many that their distances are not watched."""


class Walker(StubFlock):
    """The stub, in a world that can be changed."""

    loop = None

    def __init__(self, start: Spec, **more):
        super().__init__(start, **more)
        if isinstance(start.world, World):
            self.world = start.world

    def change_world(self, world: World) -> None:
        if world.dim != self.world.dim:
            raise InputError("another dimension")
        self.world = world


@pytest.fixture
def simulation():
    made = Simulation(START, speed=200.0, running=False, build=Walker)
    assert made.ready.wait(60)
    yield made
    made.close()
    assert not made.thread.is_alive()


def add(simulation: Simulation, at=(5.0, 5.0), radius=2.0) -> int:
    simulation.edits.change(lambda editor: editor.add(disc(at, radius))).result(60)
    return simulation.edits.editor.newest_key


def test_an_obstacle_is_there_at_once_and_agents_under_it_come_out(simulation):
    flock = simulation.run.flock
    before = flock.position.copy()
    add(simulation)
    assert flock.world is simulation.edits.editor.world
    until(lambda: simulation.frame.world is flock.world)
    inside = np.linalg.norm(before - 5.0, axis=1) < 1.99
    assert inside.any()
    assert (clearance(flock.world, flock.position) > 0.0).all()
    np.testing.assert_array_equal(flock.position[~inside], before[~inside])
    assert simulation.state.run == 1


def test_undo_gives_the_very_world_back_that_setup_made(simulation):
    plain = simulation.run.flock.world
    add(simulation)
    assert isinstance(simulation.state.spec.world, World)
    simulation.edits.change(Editor.undo).result(60)
    assert simulation.run.flock.world is plain
    assert simulation.state.spec == START


def test_reset_keeps_the_world_that_was_built_and_its_history(simulation):
    add(simulation)
    world = simulation.edits.editor.world
    simulation.reset()
    until(lambda: simulation.state.run == 2)
    assert simulation.run.flock.world is world
    simulation.edits.change(Editor.undo).result(60)
    assert simulation.run.flock.world.obstacles == ()
    simulation.reset()
    until(lambda: simulation.state.run == 3)
    simulation.edits.change(Editor.redo).result(60)
    assert len(simulation.run.flock.world.obstacles) == 1


def test_what_is_refused_is_told_and_changes_nothing(simulation):
    add(simulation)
    world, editor = simulation.run.flock.world, simulation.edits.editor
    with pytest.raises(InputError, match="crosses itself"):
        simulation.edits.change(lambda e: e.add(polygon([(0, 0), (4, 4), (4, 0), (0, 4)]))).result(
            60
        )
    assert "crosses itself" in simulation.notices.get(timeout=60)
    assert simulation.run.flock.world is world
    assert simulation.edits.editor is editor


def test_a_world_without_room_for_the_agents_is_refused(simulation):
    room = World("room", (10.0, 10.0), ("solid", "solid"))
    simulation.setup(START.but(world=room))
    until(lambda: simulation.state.run == 2)
    flock = simulation.run.flock
    before = flock.position.copy()
    with pytest.raises(InputError, match="no free place would be left"):
        simulation.edits.change(lambda e: e.add(rectangle((5, 5), 20.0, 20.0))).result(60)
    assert flock.world is room
    np.testing.assert_array_equal(flock.position, before)


def test_of_a_drag_only_the_newest_change_is_carried_out(simulation):
    key = add(simulation, (2.0, 2.0), 0.5)
    made, hold = [], threading.Event()
    simulation.tell(lambda: hold.wait(60))

    def to(x: float):
        def change(editor: Editor) -> Editor:
            made.append(x)
            return editor.move(key, (x, 0.0), gesture="drag")

        return change

    for x in range(1, 7):
        simulation.edits.drag("drag", to(float(x)))
    hold.set()
    simulation.edits.change(lambda editor: editor).result(60)
    assert made == [6.0]
    assert simulation.edits.editor.now.obstacle(key).centre == (8.0, 2.0)


def test_a_drag_over_what_cannot_be_is_silent_and_its_end_is_not(simulation):
    key = add(simulation, (2.0, 2.0), 0.5)
    simulation.edits.drag("drag", lambda editor: editor.move(key, (1e6, 0.0), gesture="drag"))
    simulation.edits.change(lambda editor: editor).result(60)
    assert simulation.notices.empty()
    simulation.edits.change(lambda editor: editor.move(key, (1e6, 0.0), gesture="drag"))
    assert "too far away" in simulation.notices.get(timeout=60)


def test_a_drag_goes_on_over_a_setup_without_harm(simulation):
    key = add(simulation, (2.0, 2.0), 0.5)
    simulation.edits.drag("drag", lambda editor: editor.move(key, (1.0, 0.0), gesture="drag"))
    simulation.setup(preset_spec(agents=5, size=7.0))
    until(lambda: simulation.state.run == 2)
    simulation.edits.drag("drag", lambda editor: editor.move(key, (2.0, 0.0), gesture="drag"))
    simulation.edits.change(lambda editor: editor).result(60)
    assert simulation.run.flock.world.obstacles == ()
    assert simulation.edits.editor.past == ()
    assert not simulation.state.error


def test_the_leader_is_never_put_into_an_obstacle(simulation):
    add(simulation)
    simulation.place(0, np.array([5.5, 5.0]), np.array([1.0, 0.0])).result(60)
    np.testing.assert_allclose(simulation.run.flock.position[0], [7.01, 5.0], atol=0.05)


def test_a_layout_is_saved_and_opened_again(simulation):
    add(simulation)
    world, content = simulation.edits.editor.world, simulation.edits.layout().result(60)
    simulation.edits.change(Editor.clear).result(60)
    simulation.edits.open_layout("mine.toml", content).result(60)
    until(lambda: simulation.state.run == 2)
    opened = simulation.run.flock.world
    assert (opened.obstacles, opened.size) == (world.obstacles, world.size)
    assert opened.name == "mine"
    assert simulation.edits.editor.past == ()
    assert len(simulation.run.flock.ids) == 300


def test_a_file_that_is_refused_changes_nothing(simulation):
    add(simulation)
    editor = simulation.edits.editor
    with pytest.raises(InputError):
        simulation.edits.open_layout("mine.toml", b"size = ").result(60)
    assert "mine.toml is not TOML" in simulation.notices.get(timeout=60)
    assert (simulation.state.run, simulation.edits.editor) == (1, editor)


def test_a_world_in_which_the_flock_cannot_be_leaves_the_old_one(simulation):
    def build(start: Spec) -> Walker:
        if isinstance(start.world, World) and start.world.dim == 3:
            raise InputError("dim = 3 is not allowed: hwvem is defined in 2-D")
        return Walker(start)

    simulation.building.build = build
    world = World("tall", (5.0, 5.0, 5.0), ("open",) * 3)
    simulation.edits.open_layout("tall.toml", world.to_toml().encode())
    assert "dim = 3" in simulation.notices.get(timeout=60)
    until(lambda: simulation.next is None)
    assert simulation.state.spec == START
    assert simulation.run.flock.world.dim == 2


def test_several_people_at_once_leave_a_sound_world_and_a_running_flock(simulation):
    simulation.go()

    def play(number: int) -> None:
        chance = np.random.default_rng(number)
        for _ in range(60):
            key = simulation.edits.editor.newest_key - int(chance.integers(-2, 9))
            x, y = chance.uniform(0, 10, 2)
            gesture = f"{number} {chance.integers(3)}"
            match chance.integers(7):
                case 0 | 1:
                    simulation.edits.change(lambda e, at=(x, y): e.add(disc(at, 0.4)))
                case 2:
                    simulation.edits.drag(
                        gesture, lambda e, k=key, g=gesture: e.move(k, (0.1, 0), 5, g)
                    )
                case 3:
                    simulation.edits.change(lambda e, k=key: e.delete(k))
                case 4:
                    simulation.edits.change(Editor.undo)
                case 5:
                    simulation.edits.change(Editor.redo)
                case 6:
                    simulation.reset()
            wait([simulation.look_again()], 30)

    threads = [threading.Thread(target=play, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    simulation.edits.change(lambda editor: editor).result(60)
    until(lambda: simulation.next is None)
    assert not simulation.state.error
    flock = simulation.run.flock
    assert flock.world == simulation.edits.editor.world
    before = flock.tick
    until(lambda: simulation.run.flock.tick > before or simulation.run.flock is not flock)
    told = set()
    while not simulation.notices.empty():
        told.add(simulation.notices.get())
    assert {line for line in told if "does not exist any more" not in line} == set()
