"""The simulation's thread: commands, pace, errors."""

from __future__ import annotations

import math
import threading
import time
from functools import partial

import numpy as np
import pytest

from agents.flock import Flock
from agents.individuals import each, normal
from agents.kinds import Kind, chase
from app.studies.workers.kernels import single_agent_spec
from app.viewer.lab.panels.inspector import facts
from app.viewer.lab.panels.setup import SetupPanel
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.kernel_compiler import kernel
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_limits import ANSWER
from tests.viewer.stub_flock import StubFlock
from tests.viewer.waiting import until
from worlds.input_error import InputError


@pytest.fixture
def simulate():
    """Makes simulations and closes them."""
    made = []

    def make(build=StubFlock, running=False, speed=math.inf, clock=time.perf_counter, **start):
        simulation = Simulation(
            preset_spec(**start), speed=speed, running=running, build=build, clock=clock
        )
        made.append(simulation)
        assert simulation.ready.wait(60)
        return simulation

    yield make
    for simulation in made:
        simulation.close()
        assert not simulation.thread.is_alive()


def tick(simulation: Simulation) -> int:
    return simulation.frame.tick


def test_a_paused_flock_is_shown_at_tick_0_and_stays_there(simulate):
    simulation = simulate(agents=7)
    time.sleep(0.1)
    assert (simulation.frame.tick, simulation.frame.position.shape) == (0, (7, 2))
    assert not simulation.state.running


def test_go_runs_and_pause_stops(simulate):
    simulation = simulate()
    simulation.go()
    until(lambda: tick(simulation) > 10)
    simulation.pause().result(60)
    until(lambda: not simulation.state.running)
    flock_tick = simulation.run.flock.tick
    time.sleep(0.1)
    assert simulation.run.flock.tick == flock_tick == tick(simulation)


def test_step_runs_just_so_many_ticks_and_pauses(simulate):
    simulation = simulate(running=True, speed=1.0)
    simulation.pause().result(60)
    before = simulation.run.flock.tick
    simulation.step(3).result(60)
    until(lambda: tick(simulation) == before + 3)
    assert not simulation.state.running


def test_reset_gives_the_same_start_and_keeps_the_parameters(simulate):
    simulation = simulate(seed=4)
    first = simulation.frame.position.copy()
    simulation.set("eta", 2.0)
    simulation.step(5).result(60)
    simulation.reset()
    until(lambda: simulation.frame.run == 2)
    assert tick(simulation) == 0
    np.testing.assert_array_equal(simulation.frame.position, first)
    assert simulation.state.values["eta"] == 2.0


def test_a_change_is_noted_at_its_tick_and_told_in_the_spec(simulate):
    simulation = simulate(seed=4)
    simulation.step(5).result(60)
    simulation.set("eta", 2.0).result(60)
    simulation.step(3).result(60)
    assert simulation.readings.conditions.changes() == ["eta 0.5 → 2 at tick 5"]
    first, *_ = simulation.spec().result(60).decode().splitlines()
    assert first == "# Changed while it ran: eta 0.5 → 2 at tick 5. Here are the last values."
    before = simulation.readings
    simulation.reset()
    until(lambda: simulation.frame.run == 2)
    assert simulation.readings.conditions.changes() == []
    words = before.conditions.differences(simulation.readings.conditions)
    assert words == "eta 0.5 → 2 at tick 5"
    with pytest.raises(InputError, match="is outside"):
        simulation.set("eta", 99.0).result(60)
    assert simulation.readings.conditions.changes() == []


def test_setup_builds_another_flock_and_of_many_only_the_last(simulate):
    simulation = simulate()
    for agents in range(2, 30):
        simulation.setup(preset_spec(agents=agents))
    until(lambda: len(simulation.frame.ids) == 29)
    assert simulation.state.agents == 29
    assert simulation.state.run < 29


def test_a_parameter_acts_at_once_and_one_out_of_range_is_refused(simulate):
    simulation = simulate()
    simulation.set("eta", 1.5).result(60)
    assert simulation.run.flock.parameters.eta == 1.5 == simulation.state.values["eta"]
    with pytest.raises(InputError, match=r"eta = 99 is outside \[0, 6.28\]"):
        simulation.set("eta", 99).result(60)
    assert simulation.run.flock.parameters.eta == 1.5
    assert "eta = 99" in simulation.notices.get(timeout=60)
    assert not simulation.state.error


def test_a_control_of_a_model_that_is_gone_sets_nothing(simulate):
    simulation = simulate()
    model = simulation.state.spec.model
    assert simulation.set("gone", 1.0, models=("another", None)).result(60) == 1.0
    assert simulation.set("eta", 1.0, models=(model, "another")).result(60) == 1.0
    assert simulation.run.flock.parameters.eta == 0.5
    simulation.set("eta", 1.0, models=(model, None)).result(60)
    assert simulation.run.flock.parameters.eta == 1.0
    assert simulation.notices.empty()


def test_a_refused_setup_leaves_the_old_flock_running(simulate):
    simulation = simulate(running=True)
    simulation.setup(preset_spec(parameters={"eta": -1.0}))
    assert "eta = -1" in simulation.notices.get(timeout=60)
    before = tick(simulation)
    until(lambda: tick(simulation) > before)
    assert simulation.state.run == 1


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (ArithmeticError("agent 3 has position [nan, 1.0] at tick 5"), "agent 3 has position [nan"),
        (ZeroDivisionError("division by zero"), "division by zero"),
        (IndexError("out of reach"), "IndexError: out of reach"),
    ],
)
def test_a_rule_that_raises_stops_the_run_and_setup_mends_it(simulate, error, words, capfd):
    broken = partial(StubFlock, breaks_at=5, error=error)
    builds = iter([broken, StubFlock])
    simulation = simulate(build=lambda start: next(builds)(start), running=True)
    until(lambda: simulation.state.error)
    assert words in simulation.state.error
    assert words in simulation.notices.get(timeout=60)
    assert not simulation.state.running
    with pytest.raises(InputError, match="press Setup"):
        simulation.go().result(60)
    simulation.setup(preset_spec())
    until(lambda: simulation.state.run == 2)
    simulation.go().result(60)
    until(lambda: tick(simulation) > 20)
    assert not simulation.state.error
    assert ("Traceback" in capfd.readouterr().err) == isinstance(error, IndexError)


def test_a_flock_that_cannot_be_built_stops_nothing(simulate):
    def build(start):
        if start.agents == 13:
            raise MemoryError("too many")
        return StubFlock(start)

    simulation = simulate(build=build)
    simulation.setup(preset_spec(agents=13))
    until(lambda: "MemoryError: too many" in simulation.state.error)
    simulation.setup(preset_spec(agents=14))
    until(lambda: simulation.state.agents == 14 and not simulation.state.error)


def test_slow_motion_keeps_its_pace(simulate):
    now = [1.0]
    simulation = simulate(running=True, speed=256.0, clock=lambda: now[0])

    def ticks_at_rest() -> int:
        for _ in range(3):  # each is answered in another turn of the thread
            simulation.tell(lambda: None).result(60)
        return simulation.run.flock.tick

    first = until(ticks_at_rest)
    for due in (1, 2, 3, 5, 10):
        now[0] = 1.0 + due / 256.0
        until(lambda due=due: simulation.run.flock.tick >= first + due)
        assert ticks_at_rest() == first + due


def test_commands_are_answered_soon_while_it_runs_as_fast_as_it_goes(simulate):
    simulation = simulate(build=partial(StubFlock, cost=0.0005), running=True)
    until(lambda: simulation.run.flock.tick > 200)
    waits = []
    for _ in range(20):
        before = simulation.run.flock.tick
        answer = simulation.tell(lambda: simulation.run.flock.tick)
        waits.append(answer.result(60) - before)
    assert np.median(waits) <= 2.0 * ANSWER / 0.0005, "ticks that go first"


def test_a_slow_pace_does_not_delay_commands(simulate):
    simulation = simulate(running=True, speed=0.001)
    simulation.set("eta", 1.0).result(60)
    simulation.run_at(math.inf).result(60)
    until(lambda: tick(simulation) > 5)


@pytest.mark.parametrize("speed", [0.0, -1.0, math.nan])
def test_an_impossible_pace_is_refused(simulate, speed):
    with pytest.raises(InputError, match="ticks/s"):
        simulate().run_at(speed).result(60)


def test_commands_from_many_threads_are_all_carried_out(simulate):
    simulation = simulate(running=True)
    answers = []

    def shout(number: int) -> None:
        for k in range(20):
            answers.append(simulation.set("eta", (number + k) % 6))
            answers.append(simulation.place(number, np.zeros(2), np.array([0.0, 1.0])))
            answers.append((simulation.toggle, simulation.reset, simulation.step)[k % 3]())
            answers[-1].exception(60)

    threads = [threading.Thread(target=shout, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(answer.exception(60) is None for answer in answers)
    simulation.go().result(60)
    before = simulation.state.run
    simulation.setup(preset_spec(agents=5))
    until(lambda: simulation.frame.run > before and len(simulation.frame.ids) == 5)
    until(lambda: tick(simulation) > 3)


def test_frames_are_copies_that_the_flock_does_not_touch(simulate):
    simulation = simulate()
    frame = simulation.frame
    before = frame.position.copy()
    simulation.run.flock.position[:] = -1.0
    simulation.step().result(60)
    np.testing.assert_array_equal(frame.position, before)


def test_layers_groups_links_and_an_agent_are_in_frames_only_when_wanted(simulate):
    simulation = simulate(agents=3, size=0.5)
    frame = simulation.frame
    assert frame.layer is frame.group is frame.links is frame.inspected is None
    simulation.set_request(FrameRequest(layers=True, groups=True, links=True, row=2))
    frame = until(lambda: simulation.frame if simulation.frame.layer is not None else None)
    assert frame.layer.tolist() == [1, 2, 2]
    assert frame.group.tolist() == [0, 0, 0]
    assert frame.links.tolist() == [[0, 1], [0, 2], [1, 2]]
    assert frame.inspected.row == 2
    assert facts(frame, frame.inspected)["heading"] == "0°"
    simulation.setup(preset_spec(agents=2))
    until(lambda: len(simulation.frame.ids) == 2)
    assert simulation.frame.inspected is None


def test_the_leader_can_be_moved_and_turned(simulate):
    simulation = simulate()
    simulation.place(0, np.array([1.0, 2.0]), np.array([0.0, 1.0])).result(60)
    until(lambda: simulation.frame.position[0].tolist() == [1.0, 2.0])
    assert simulation.frame.heading[0].tolist() == [0.0, 1.0]


def test_spec_and_state_can_be_taken_home_while_it_runs(simulate):
    simulation = simulate(running=True, seed=8)
    assert simulation.spec().result(60) == b"seed = 8\n"
    assert simulation.save().result(60) == b"saved"


def test_nobody_reads_frames_and_it_runs_all_the_same(simulate):
    simulation = simulate(running=True)
    until(lambda: simulation.run.flock.tick > 100)


def test_what_cannot_be_observed_is_told_once_and_the_flock_runs_on(simulate, capfd):
    class Shy(StubFlock):
        def inspect(self, _row):
            raise OverflowError("int too big to convert")

        def observe(self, _name):
            raise KeyError("nothing to see")

    simulation = simulate(build=Shy, running=True)
    simulation.set_request(FrameRequest(row=1))
    before = tick(simulation)
    until(lambda: tick(simulation) > before + 20)
    told = {simulation.notices.get(timeout=60), simulation.notices.get(timeout=60)}
    assert told == {"int too big to convert", "KeyError: 'nothing to see'"}
    assert simulation.notices.empty()
    assert not simulation.state.error
    assert capfd.readouterr().err.count("Traceback") == 2


# Agents that differ.


@pytest.fixture
def vem(simulate):
    """A simulation of a real flock whose agents differ in eta."""
    return simulate(
        Flock, model="vem", agents=20, seed=3, parameters={"eta": normal(0.5, 0.1)}, running=False
    )


def test_sliders_move_the_centre_and_the_spread_of_what_differs(vem):
    first = vem.run.flock.own["eta"].copy()
    assert vem.state.values["eta"] == normal(0.5, 0.1)
    assert vem.move("eta", 0.8).result(60) == normal(0.8, 0.1)
    assert np.allclose(vem.run.flock.own["eta"], first + 0.3)
    assert vem.spread("eta", 0.05).result(60) == normal(0.8, 0.05)
    assert vem.move("v0", 0.04).result(60) == 0.04
    assert vem.spread("eta", 0.0).result(60) == 0.8
    assert vem.run.flock.own == {}
    with pytest.raises(InputError, match="k cannot differ from agent to agent in vem"):
        vem.spread("k", 1.0).result(60)
    assert vem.state.values["k"] == vem.run.flock.k


def test_numbers_that_are_drawn_again_are_said_once_however_often_a_slider_moves(vem):
    while not vem.notices.empty():
        vem.notices.get()
    for mean in (0.15, 0.14, 0.13):
        vem.move("eta", mean).result(60)
        before = vem.frame
        vem.look_again().result(60)
        until(lambda before=before: vem.frame is not before)
    assert vem.state.redrawn["eta", False] == vem.run.flock.redrawn["eta"] > 0
    assert "drawn again" in vem.notices.get()
    assert vem.notices.empty()


def test_a_reset_and_another_seed_keep_what_differs(vem):
    vem.spread("eta", 0.2).result(60)
    own = vem.run.flock.own["eta"].copy()
    run = vem.state.run
    vem.reset()
    until(lambda: vem.state.run > run and not vem.state.busy)
    assert np.array_equal(vem.run.flock.own["eta"], own)
    spec, _ = vem.state.current_specs()
    vem.setup(spec.with_values(seed=9))
    until(lambda: vem.state.run > run + 1 and not vem.state.busy)
    assert vem.state.values["eta"] == normal(0.5, 0.2)
    assert not np.array_equal(vem.run.flock.own["eta"], own)


def test_numbers_by_hand_of_another_number_of_agents_are_refused_in_one_line(simulate):
    simulation = simulate(Flock, model="vem", agents=3, parameters={"eta": [0.1, 0.2, 0.3]})
    assert simulation.state.values["eta"] == each([0.1, 0.2, 0.3])
    spec, _ = simulation.state.current_specs()
    simulation.setup(spec.with_values(agents=5))
    assert "eta has 3 values for 5 agents: one each is needed" in simulation.notices.get(timeout=60)


def test_a_model_that_is_not_taken_over_is_said_with_what_differed(vem):
    state = vem.state
    couzin = preset_spec("couzin", agents=20)
    said = SetupPanel.dropped_differences(state, (couzin, None))
    assert said == "Not taken over into the new run: eta = normal(0.5, 0.1)"
    assert SetupPanel.dropped_differences(state, state.current_specs()) == ""


# Kinds of agents.


@pytest.fixture
def hunt(simulate):
    """A simulation of a real flock that three sharks chase; they take whom they catch."""
    sharks = Kind("shark", 3, v0=0.05, to={"flock": chase(1.5, 2.0, catch=0.3)})
    return simulate(Flock, model="vem", agents=60, seed=3, kinds=[sharks], running=False)


def test_relations_and_numbers_of_a_kind_act_at_once_and_reset_keeps_them(hunt):
    assert hunt.state.kinds.names == ("flock", "shark")
    assert hunt.relate("shark", "flock", "radius", 1.0).result(60) == 1.0
    assert hunt.set_kind("shark", "v0", 0.08).result(60) == 0.08
    assert hunt.paint_kind("shark", "#b03a2e").result(60) == "#b03a2e"
    flock = hunt.run.flock
    assert flock.kinds.of("shark", "flock").radius == 1.0
    assert (flock.own["v0"][flock.rows_of("shark")] == 0.08).all()
    run = hunt.state.run
    hunt.reset()
    until(lambda: hunt.state.run > run and not hunt.state.busy)
    (kind,) = hunt.state.current_specs()[0].kinds
    assert (kind.colour, kind.parameters, kind.to["flock"].radius) == ("#b03a2e", {"v0": 0.08}, 1.0)
    assert hunt.relate("shark", "flock", "deed", "flee").result(60) == "flee"
    assert hunt.state.kinds.of("shark", "flock").catch == 0.0


def test_what_a_kind_cannot_be_is_refused_and_changes_nothing(hunt):
    for wrong, message in (
        (lambda: hunt.set_kind("shark", "v0", 99.0), r"kind shark: v0 = 99\.0 .* is outside"),
        (lambda: hunt.set_kind("whale", "v0", 0.1), "unknown kind 'whale'"),
        (lambda: hunt.relate("shark", "flock", "weight", -1.0), "weight = -1.0 of chase"),
        (lambda: hunt.relate("shark", "flock", "radius", 0.0), "radius = 0 of chase"),
    ):
        with pytest.raises(InputError, match=message):
            wrong().result(60)
    assert hunt.state.kinds.of("shark", "flock") == chase(1.5, 2.0, catch=0.3)


def test_who_is_taken_is_gone_and_looking_back_brings_it_again(hunt):
    hunt.look_again().result(60)
    until(lambda: hunt.state.line is not None)
    hunt.step(30).result(60)
    until(lambda: tick(hunt) == 30 and hunt.readings.tick == 30)
    caught = 63 - len(hunt.frame.ids)
    assert caught > 0
    assert hunt.frame.has_turnover
    assert (hunt.frame.kind == 1).sum() == 3
    assert hunt.readings.values["catches"] == caught
    assert hunt.readings.values.keys() >= {"polarisation", "mean-neighbours"}
    assert hunt.readings.conditions.last.agents == 60
    hunt.set_kind("shark", "v0", 0.1).result(60)
    hunt.time_line.seek(0).result(60)
    until(lambda: tick(hunt) == 0)
    assert len(hunt.frame.ids) == 63
    assert hunt.state.kinds.kind("shark").parameters == {"v0": 0.05}
    hunt.time_line.to_now().result(60)
    until(lambda: tick(hunt) == 30)
    assert hunt.state.kinds.kind("shark").parameters == {"v0": 0.1}
    assert hunt.readings.conditions.changes() == ["v0 of shark 0.05 → 0.1 at tick 30"]


def test_each_kind_is_measured_by_itself_when_it_is_watched(hunt):
    hunt.watch(["polarisation of shark", "kind-distance"]).result(60)
    until(lambda: "polarisation of shark" in hunt.readings.values)
    flock, values = hunt.run.flock, hunt.readings.values
    assert values["polarisation of shark"] == flock.observe("polarisation", kind="shark")
    assert "polarisation of flock" in hunt.readings.offered
    assert values["kind-distance"] > 0.0


def test_another_model_does_not_take_over_kinds(hunt):
    said = SetupPanel.dropped_differences(hunt.state, (preset_spec("couzin"), None))
    assert said == "Not taken over into the new run: kind shark"
    assert SetupPanel.dropped_differences(hunt.state, hunt.state.current_specs()) == ""


def test_one_agent_compiles_what_a_run_of_kinds_calls():
    kind = Kind("shark", 2, to={"flock": chase(1.0, 1.0)})
    complete = preset_spec("vem", agents=9, kinds=[kind])
    assert kernel(Flock(single_agent_spec(Flock(complete)))) == kernel(Flock(complete))
