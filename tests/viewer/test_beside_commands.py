"""Two models side by side under the simulation's commands, and what happens when one fails."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from agents.spec import Spec
from app.viewer.editing.editor import disc
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from tests.viewer.stub_flock import StubFlock, timed_stub
from tests.viewer.waiting import until
from worlds.input_error import InputError


@pytest.fixture
def simulate():
    """Makes simulations of two flocks and closes them."""
    made = []

    def make(spec: Spec, beside: Spec, **more) -> Simulation:
        simulation = Simulation(spec, beside, running=False, **more)
        made.append(simulation)
        assert simulation.ready.wait(60)
        return simulation

    yield make
    for simulation in made:
        simulation.close()
        assert not simulation.thread.is_alive()


def test_step_set_reset_and_setup_act_on_both(simulate):
    simulation = simulate(preset_spec("hwvem", agents=12, seed=4), Spec("vem-a"))
    begun = simulation.frame.position.copy()
    assert np.array_equal(simulation.frame.beside.position, begun)
    simulation.set("eta", 1.5).result(60)
    simulation.step(4).result(60)
    until(lambda: simulation.frame.tick == simulation.frame.beside.tick == 4)
    assert not np.array_equal(simulation.frame.beside.position, simulation.frame.position)
    simulation.reset()
    until(lambda: simulation.frame.run == 2)
    frame = simulation.frame
    assert frame.tick == frame.beside.tick == 0
    assert np.array_equal(frame.position, begun)
    assert np.array_equal(frame.beside.position, begun)
    assert [one.values["eta"] for one in simulation.run.both] == [1.5, 1.5]
    simulation.setup(simulation.state.spec)
    until(lambda: simulation.frame.run == 3)
    assert simulation.frame.beside is None
    assert simulation.readings_beside is None
    assert simulation.frame.title == ""


def test_reset_keeps_what_only_the_second_has(simulate):
    simulation = simulate(preset_spec("boundary-points", agents=6), Spec("olfati-saber"))
    simulation.set("d_beta", 2.5, beside=True).result(60)
    assert simulation.state.beside_values["d_beta"] == 2.5
    simulation.reset()
    until(lambda: simulation.frame.run == 2)
    assert simulation.run.second.flock.parameters.d_beta == 2.5


def test_a_second_flock_that_cannot_be_built_leaves_the_old_ones(simulate):
    simulation = simulate(preset_spec("hwvem", agents=12), Spec("vem-a"))
    simulation.setup(simulation.state.spec.but(dim=3), Spec("ivem"))
    notice = simulation.notices.get(timeout=60)
    assert notice.startswith("Improved Vicsek model: dim = 3")
    simulation.step().result(60)
    until(lambda: simulation.frame.beside.tick == 1)
    assert simulation.state.run == 1


def test_an_edit_of_the_world_is_one_of_both(simulate):
    simulation = simulate(preset_spec("hwvem-nav", world="obstacles", agents=9), Spec("vem-a-nav"))
    simulation.edits.change(lambda editor: editor.add(disc((44.0, 20.0), 2.0))).result(60)
    first, second = (one.flock for one in simulation.run.both)
    assert first.world is second.world is simulation.edits.editor.world
    assert len(first.world.obstacles) == 13
    spot = first.position[3].copy()
    change: Callable = lambda editor: editor.add(disc(tuple(spot), 0.4))  # noqa: E731
    simulation.edits.change(change).result(60)
    assert np.array_equal(first.position, second.position)
    assert np.linalg.norm(first.position[3] - spot) > 0.4
    simulation.reset()
    until(lambda: simulation.frame.run == 2, 60)
    assert len(simulation.frame.beside.world.obstacles) == 14


def broken_beside(_first, _beside: Spec, error: Exception) -> StubFlock:
    return timed_stub(breaks_at=5, error=error)


@pytest.mark.parametrize(
    ("error", "words", "told"),
    [
        (ArithmeticError("agent 3 is lost"), "Stub: agent 3 is lost", False),
        (IndexError("out of reach"), "Stub: IndexError: out of reach", True),
    ],
)
def test_a_broken_second_flock_is_named_and_stops_both(simulate, error, words, told, capfd):
    simulation = simulate(
        preset_spec(agents=8),
        Spec("vem"),
        speed=200.0,
        build=lambda _start: timed_stub(),
        build_beside=partial(broken_beside, error=error),
    )
    simulation.go()
    until(lambda: simulation.state.error)
    assert simulation.state.error == words
    assert simulation.notices.get(timeout=60) == words
    assert not simulation.state.running
    with pytest.raises(InputError, match="press Setup"):
        simulation.go().result(60)
    assert ("Traceback" in capfd.readouterr().err) == told
