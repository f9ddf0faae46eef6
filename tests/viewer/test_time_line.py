"""Time lines: recordings that are played, live runs that are looked back at and gone on from."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from agents.flock import Flock
from agents.recordings.recorder import Recorder
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.run_panel import describe_time_line
from app.viewer.measuring.time_series import TimeSeries
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from app.viewer.run.stored_flock import read_stored
from app.viewer.run.time_line import CheckpointHistory, RunCheckpoint
from tests.viewer.waiting import until
from worlds.input_error import InputError
from worlds.obstacles import Disc

RUN = {"model": "vem", "agents": 30, "seed": 4, "eta": 0.3}
EVERY, FRAMES = 5, 9


@pytest.fixture
def simulate():
    """Makes paused simulations of small compiled flocks, and closes them."""
    made = []

    def make(**more) -> Simulation:
        spec = preset_spec("vem", agents=30, seed=4, parameters={"eta": 0.3})
        simulation = Simulation(**{"spec": spec, "speed": math.inf, "running": False, **more})
        made.append(simulation)
        until(lambda: simulation.frame and simulation.state.compiling is None, 60)
        return simulation

    yield make
    for simulation in made:
        simulation.close()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A recording of nine frames, five ticks apart, and the positions in it by tick."""
    path = tmp_path_factory.mktemp("recorded") / "flight.parquet"
    flock, there = Flock("vem", agents=30, rng=4, eta=0.3), {}
    with Recorder(path, flock) as recorder:
        for _ in range(FRAMES):
            recorder.write()
            there[flock.tick] = flock.position.copy()
            flock.run(EVERY)
    return path, there


@pytest.fixture
def played(simulate, recorded):
    """A simulation that plays it, paused at its beginning."""
    opened = read_stored("flight.parquet", path=recorded[0])
    return simulate(spec=opened.spec, stored=opened)


def shown(simulation: Simulation, tick: int) -> None:
    until(lambda: simulation.frame.tick == tick, what=f"{simulation.frame.tick} is not {tick}")


def seek(simulation: Simulation, tick: int) -> None:
    simulation.time_line.seek(tick).result(60)


# Recordings.


def test_a_recording_is_played_to_its_end_and_stops_there(played, recorded):
    there = recorded[1]
    assert played.frame.tick == 0
    played.go()
    shown(played, 40)
    until(lambda: not played.state.running)
    assert np.array_equal(played.frame.position, there[40])
    assert played.state.line.recording == "flight.parquet"
    assert (played.state.line.first, played.state.line.last) == (0, 40)


def test_go_at_the_end_begins_again(played):
    seek(played, 40)
    played.run_at(20.0)
    played.go()
    until(lambda: played.state.running and played.frame.tick < 40)


def test_a_recording_keeps_the_pace_of_its_ticks(played):
    played.run_at(2.0)
    played.go()
    until(lambda: played.run.clock == 2)
    assert played.frame.tick == 0
    played.pause().result(60)


@pytest.mark.parametrize(("tick", "is_shown"), [(17, 15), (15, 15), (-3, 0), (900, 40)])
def test_any_tick_can_be_sought_and_the_last_recorded_one_is_shown(
    played, recorded, tick, is_shown
):
    seek(played, tick)
    shown(played, is_shown)
    assert np.array_equal(played.frame.position, recorded[1][is_shown])
    until(lambda: played.state.line.at == is_shown)
    said = describe_time_line(played.state.line, played.frame)
    assert ("Tick 17 is not kept" in said) == (tick == 17)


def test_step_shows_the_next_recorded_tick(played):
    seek(played, 10)
    played.step().result(60)
    shown(played, 15)
    played.step(90).result(60)
    shown(played, 40)


def test_nothing_can_be_changed_in_a_recording(played):
    for command in (
        lambda: played.set("eta", 0.1),
        lambda: played.place(0, np.zeros(2), np.array([1.0, 0.0])),
        lambda: played.edits.change(lambda editor: editor.add(Disc(centre=(9.0, 9.0), radius=0.1))),
    ):
        with pytest.raises(InputError, match=r"flight\.parquet is a recording"):
            command().result(60)


def test_what_is_measured_of_a_recording_is_that_of_the_tick(played):
    flock = Flock("vem", agents=30, rng=4, eta=0.3)
    flock.run(25)
    seek(played, 25)
    until(lambda: played.readings.tick == 25)
    assert played.readings.values["polarisation"] == flock.observe("polarisation")
    seek(played, 10)
    until(lambda: played.readings.tick == 10)
    assert played.readings.series("polarisation").arrays()[0].max() == 10


def test_an_agent_of_a_recording_is_looked_at_from_close(played):
    flock = Flock("vem", agents=30, rng=4, eta=0.3)
    flock.run(15)
    played.set_request(FrameRequest(row=3, links=True)).result(60)
    seek(played, 15)

    def seen():
        played.look_again().result(60)
        return played.frame.tick == 15 and played.frame.inspected

    there, here = until(seen, 120), flock.inspect(3)
    assert there.id == here.id
    assert np.array_equal(there.neighbours, here.neighbours)
    assert np.array_equal(there.weights, here.weights)
    until(lambda: np.array_equal(played.frame.links, flock.links()))


def test_a_recording_is_gone_on_from_to_the_bit(played, recorded):
    seek(played, 20)
    played.time_line.go_on().result(60)
    until(lambda: played.state.line is not None and not played.state.line.recording, 60)
    until(lambda: played.state.compiling is None, 60)
    played.step(10).result(60)
    shown(played, 30)
    assert np.array_equal(played.frame.position, recorded[1][30])


def test_a_laboratory_opens_on_a_recording(recorded):
    opened = read_stored("flight.parquet", path=recorded[0])
    laboratory = Laboratory(opened=opened, port=0, running=False)
    simulation = laboratory.simulation
    until(lambda: simulation.state.line and simulation.state.line.recording == "flight.parquet")
    assert simulation.state.speed == EVERY * 15.0
    laboratory.run.set_up()
    until(lambda: simulation.state.run == 2 and not simulation.state.busy, 60)
    assert simulation.state.stored is None
    assert (simulation.state.spec.model, simulation.state.spec.agents) == ("vem", 30)
    laboratory.close()


# Live runs.


def test_a_state_is_begun_again_with_parameters_and_world_as_they_are(simulate, tmp_path):
    flock = Flock("vem", agents=30, rng=4, eta=0.3)
    flock.run(12)
    flock.save(tmp_path / "state.parquet")
    opened = read_stored("state.parquet", path=tmp_path / "state.parquet")
    live = simulate(spec=opened.spec, stored=opened)
    assert live.frame.tick == 12
    live.set("eta", 1.0).result(60)
    live.edits.change(lambda editor: editor.add(Disc(centre=(1.2, 1.2), radius=0.1))).result(60)
    live.reset()
    until(lambda: live.state.run == 2 and live.frame.run == 2, 60)
    assert (live.frame.tick, live.state.values["eta"]) == (12, 1.0)
    assert len(live.frame.world.obstacles) == len(live.run.flock.world.obstacles) == 1


def test_what_is_gone_on_from_comes_to_the_same_bits(simulate):
    live = simulate()
    for _ in range(8):
        live.step(5).result(60)
        live.look_again().result(60)
        until(lambda: live.state.line.last == live.run.flock.tick)
    shown(live, 40)
    first = live.frame.position.copy()
    seek(live, 12)
    until(lambda: live.state.line.looks_back)
    then = live.frame.tick
    assert 0 <= then <= 12
    assert live.state.line.last == 40
    live.time_line.go_on().result(60)
    until(lambda: live.state.line.last == then)
    live.step(40 - then).result(60)
    shown(live, 40)
    assert np.array_equal(live.frame.position, first)


def test_back_to_now_is_as_if_nobody_had_looked_back(simulate):
    live = simulate()
    live.step(30).result(60)
    shown(live, 30)
    now, values = live.frame.position.copy(), live.readings.series("polarisation").arrays()
    seek(live, 0)
    shown(live, 0)
    live.time_line.to_now().result(60)
    shown(live, 30)
    assert not live.state.line.looks_back
    assert np.array_equal(live.frame.position, now)
    assert np.array_equal(live.readings.series("polarisation").arrays()[0], values[0])


def test_go_while_looking_back_goes_on_from_there(simulate):
    live = simulate()
    live.step(30).result(60)
    shown(live, 30)
    seek(live, 0)
    live.step(3).result(60)
    shown(live, 3)
    assert live.state.line.last == 3
    assert live.readings.series("polarisation").arrays()[0].max() <= 3


def test_parameters_are_those_of_the_tick_that_is_gone_on_from(simulate):
    live = simulate()
    live.set("eta", 1.5).result(60)
    live.step(20).result(60)
    shown(live, 20)
    live.set("eta", 0.2).result(60)
    until(lambda: live.time_line.history.moments[-1].snapshots[0].parameters.eta == 0.2)
    live.step(20).result(60)
    shown(live, 40)
    seek(live, 0)
    assert live.state.values["eta"] == 1.5
    with pytest.raises(InputError, match="you look back at tick"):
        live.set("eta", 0.9).result(60)
    live.time_line.to_now().result(60)
    assert live.state.values["eta"] == 0.2
    assert live.readings.conditions.changes() == ["eta 1.5 → 0.2 at tick 20"]
    seek(live, 0)
    live.time_line.go_on().result(60)
    assert live.readings.conditions.changes() == []
    assert live.run.flock.parameters.eta == live.state.values["eta"] == 1.5


def test_two_flocks_go_back_together(simulate):
    live = simulate(beside=preset_spec("hwvem"))
    live.step(20).result(60)
    shown(live, 20)
    first = live.frame.beside.position.copy()
    seek(live, 0)
    shown(live, 0)
    assert live.frame.beside.tick == 0
    live.step(20).result(60)
    shown(live, 20)
    assert np.array_equal(live.frame.beside.position, first)


def moment(tick: int, numbers: int = 100) -> RunCheckpoint:
    snapshot = SimpleNamespace(tick=tick, arrays=(np.zeros(numbers),))
    return RunCheckpoint((snapshot,), ((0.0, 0.0),), 0.0, preset_spec(), None)


def test_a_history_is_bounded_and_denser_towards_now():
    history = CheckpointHistory(memory=50 * 800)
    for tick in range(3000):
        history.note(moment(tick))
        assert history.size == sum(one.size for one in history.moments) <= 50 * 800
    ticks = [one.tick for one in history.moments]
    assert (ticks[0], ticks[-1], len(ticks)) == (0, 2999, 50)
    gaps = np.diff(ticks)
    assert gaps[-5:].max() <= 2 < 100 < gaps.max()
    assert history.last_before(2999).tick == 2999
    assert history.last_before(-1).tick == 0


def test_a_moment_at_the_same_tick_takes_the_place_of_the_one_before():
    history = CheckpointHistory()
    for tick in (0, 4, 4, 2):
        history.note(moment(tick))
    assert [one.tick for one in history.moments] == [0, 2]


def test_a_series_that_is_cut_goes_on():
    series = TimeSeries()
    for tick in range(2000):
        series.add(tick, tick)
    series.cut(700)
    series.add(900, 5.0)
    times, values = series.arrays()
    assert (times.max(), values[-1]) == (900, 5.0)
    assert (np.diff(times) > 0).all()
    assert series.arrays(50)[0].tolist() == [900]
