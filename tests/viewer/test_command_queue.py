"""However much a simulation is told, little waits, and a pause comes first."""

from __future__ import annotations

import threading

import pytest

from app.viewer.run.command_queue import MOST, MOST_TICKS, CommandQueue
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from tests.viewer.stub_flock import StubFlock
from tests.viewer.waiting import until
from worlds.input_error import InputError


@pytest.fixture
def held():
    """A simulation whose thread stands in a command until the event is set."""
    simulation = Simulation(preset_spec(), running=False, build=StubFlock)
    assert simulation.ready.wait(60)
    go_on, stands = threading.Event(), threading.Event()

    def stand():
        stands.set()
        go_on.wait(60.0)

    simulation.tell(stand)
    assert stands.wait(60.0)
    yield simulation, go_on
    go_on.set()
    simulation.close()


def test_steps_that_wait_are_one_step_and_not_many_ticks(held):
    simulation, go_on = held
    answers = [simulation.step() for _ in range(10_000)]
    assert len(simulation.commands.waiting) == 1
    go_on.set()
    assert all(answer.exception(60) is None for answer in answers)
    assert simulation.run.flock.tick == MOST_TICKS


def test_two_steps_that_wait_are_two_ticks_and_many_in_one_command_are_all_run(held):
    simulation, go_on = held
    simulation.step()
    answer = simulation.step()
    go_on.set()
    answer.result(60)
    assert simulation.run.flock.tick == 2
    simulation.step(3 * MOST_TICKS).result(60)
    assert simulation.run.flock.tick == 2 + 3 * MOST_TICKS


def test_a_pause_comes_before_all_that_waits_and_leaves_steps_out(held):
    simulation, go_on = held
    order: list[str] = []
    switch = simulation.switch
    simulation.switch = lambda on: (order.append("go" if on else "pause"), switch(on))
    work = [simulation.tell(lambda k=k: order.append(f"work {k}")) for k in range(3)]
    steps = [simulation.step() for _ in range(50)]
    pauses = [simulation.pause() for _ in range(50)]
    go_on.set()
    for answer in (*work, *steps, *pauses):
        assert answer.exception(60) is None
    assert order == ["pause", "work 0", "work 1", "work 2"]
    assert simulation.run.flock.tick == 0


def test_a_pause_holds_though_a_go_waited_before_it(held):
    simulation, go_on = held
    simulation.tell(lambda: None)
    went = simulation.go()
    paused = simulation.pause()
    go_on.set()
    assert went.exception(60) is None
    assert paused.exception(60) is None
    until(lambda: not simulation.commands.waiting)
    simulation.tell(lambda: None).result(60)
    assert not simulation.state.running


def test_toggles_that_wait_go_and_pause_in_turn(held):
    simulation, go_on = held
    simulation.toggle()
    simulation.toggle()
    last = simulation.toggle()
    go_on.set()
    last.result(60)
    until(lambda: not simulation.commands.waiting)
    assert simulation.state.running


def test_values_of_one_parameter_are_one_command_and_the_last_is_taken(held):
    simulation, go_on = held
    answers = [simulation.set("eta", 0.001 * k) for k in range(1000)]
    assert len(simulation.commands.waiting) == 1
    go_on.set()
    assert {answer.result(60) for answer in answers} == {0.999}
    assert simulation.run.flock.parameters.eta == 0.999


def test_resets_and_set_ups_that_wait_are_one(held):
    simulation, go_on = held
    for k in range(100):
        simulation.reset()
        simulation.setup(preset_spec(agents=2 + k))
    assert len(simulation.commands.waiting) == 1
    go_on.set()
    until(lambda: simulation.state.agents == 101, 60)
    assert simulation.state.run == 2


def test_more_than_can_wait_is_refused_and_what_can_be_merged_is_not(held):
    simulation, go_on = held
    answers = [simulation.tell(lambda: None) for _ in range(MOST + 5)]
    refused = [answer for answer in answers if answer.done()]
    assert len(refused) == 5
    with pytest.raises(InputError, match=f"{MOST} commands wait already"):
        refused[0].result()
    assert "too much at once" in simulation.notices.get(timeout=60)
    paused = simulation.pause()
    kept = [simulation.setup(preset_spec(agents=2 + k)) for k in range(9)]
    kept += [simulation.set("eta", 0.1 * k) for k in range(9)]
    kept += [
        simulation.setup(preset_spec(agents=50)),
        simulation.set("eta", 1.0),
        simulation.step(),
    ]
    assert len(simulation.commands.waiting) == MOST + 4
    assert not any(answer.done() for answer in kept)
    go_on.set()
    assert paused.exception(60) is None
    assert all(answer.exception(60) is None for answer in answers[:MOST])


def test_a_drag_is_told_though_too_much_waits(held):
    simulation, go_on = held
    for _ in range(MOST):
        simulation.tell(lambda: None)
    simulation.edits.drag("disc", lambda editor: editor)
    assert list(simulation.edits.drags) == ["disc"]
    go_on.set()
    until(lambda: not simulation.commands.waiting, 60)
    moved = threading.Event()
    simulation.edits.drag("disc", lambda editor: (moved.set(), editor)[1])
    assert moved.wait(60)


def test_whoever_waits_for_a_command_can_be_woken():
    queue = CommandQueue()
    found = []
    thread = threading.Thread(target=lambda: found.append(queue.get(None)))
    thread.start()
    queue.wake()
    thread.join(60)
    assert found[0]() is None
    assert queue.get(0.0) is None
