"""A preview moves until its run is compiled, which repeats it from tick 0 and takes over."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import viser

from agents.flock import Flock
from app.viewer.lab.panels.run_panel import TimeLinePanel, status
from app.viewer.run.kernel_compiler import KernelCompiler, last_duration, remember
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import TimeLineState
from tests.viewer.stub_flock import StubCompiling, StubFlock
from tests.viewer.waiting import until
from worlds.input_error import InputError


class Uncompiled(StubFlock):
    """The stub before it is compiled; a preview of it is one that needs no compiler."""

    def __init__(self, start, interpret=False, **more):
        super().__init__(start, **more)
        self.is_compiled = interpret
        self.advanced: list[int] = []

    def advance(self, ticks: int) -> None:
        self.advanced.append(self.tick)
        super().advance(ticks)


@pytest.fixture
def simulate():
    """Makes simulations whose flock is not compiled, and closes them."""
    made = []

    def make(build=Uncompiled, running=True, speed=200.0, **start) -> Simulation:
        simulation = Simulation(
            preset_spec(**start), speed=speed, running=running, build=build, compiling=StubCompiling
        )
        made.append(simulation)
        until(lambda: simulation.frame)
        return simulation

    yield make
    for simulation in made:
        simulation.close()
        assert simulation.compiling.closed


def test_a_preview_moves_says_so_and_is_not_measured(simulate):
    simulation = simulate(agents=5)
    until(lambda: simulation.frame.tick > 5)
    assert simulation.state.preview
    assert simulation.run.flock.is_compiled
    assert not simulation.ready.is_set()
    assert simulation.readings.values == {}
    shown = status(simulation.state)
    assert "<b>preview</b>" in shown
    assert "Preview</b> until compiled: about 8 s more" in shown


def test_the_time_line_stands_at_the_tick_of_a_preview_and_not_of_the_run_before():
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        panel = TimeLinePanel(server.gui, SimpleNamespace(time_line=None))
        panel.refresh(SimpleNamespace(line=TimeLineState(0, 174, 174)), SimpleNamespace(tick=174))
        until(lambda: (panel.slider.value, panel.slider.max) == (174, 174))
        panel.refresh(SimpleNamespace(line=None), SimpleNamespace(tick=3))
        until(lambda: panel.slider.value == 3)
        assert (panel.slider.max, panel.slider.disabled) == (3, True)
    finally:
        server.stop()


def test_the_compiled_run_repeats_it_from_tick_0_and_goes_on_from_the_tick_on_screen(simulate):
    simulation = simulate(agents=5, running=False)
    preview, coming = simulation.run, simulation.preview.coming
    simulation.step(7).result(60)
    until(lambda: simulation.frame.tick == 7)
    seen = simulation.frame
    simulation.compiling.ready.set_result(None)
    until(lambda: simulation.state.compiling is None)
    assert not simulation.state.preview
    assert simulation.run is coming
    assert coming.flock.advanced == list(range(7))
    until(lambda: simulation.readings is coming.readings)
    np.testing.assert_array_equal(simulation.frame.position, seen.position)
    assert (simulation.frame.tick, simulation.frame.run) == (7, seen.run)
    assert preview.readings.values == {}
    ticks, _ = simulation.readings.series("polarisation").arrays()
    assert list(ticks) == list(range(1, 8))
    assert "<b>paused</b>" in status(simulation.state)


def test_what_is_changed_on_the_way_is_changed_again_at_the_same_tick(simulate):
    simulation = simulate(agents=5, running=False, seed=3)
    coming = simulation.preview.coming.flock
    simulation.step(3).result(60)
    simulation.set("eta", 1.25).result(60)
    simulation.step(2).result(60)
    simulation.place(1, np.array([0.5, 0.5]), np.array([0.0, 1.0])).result(60)
    simulation.step(4).result(60)
    until(lambda: simulation.frame.tick == 9)
    seen = simulation.frame
    assert (coming.tick, coming.parameters.eta) == (0, 0.5)
    simulation.compiling.ready.set_result(None)
    until(lambda: simulation.state.compiling is None)
    assert (coming.tick, coming.parameters.eta, simulation.state.values["eta"]) == (9, 1.25, 1.25)
    np.testing.assert_array_equal(coming.position, seen.position)
    np.testing.assert_array_equal(coming.heading, seen.heading)
    told = simulation.readings.conditions.changes()
    assert told == ["eta 0.5 → 1.25 at tick 3", "agents moved by hand at tick 5"]


def test_what_is_saved_is_only_ever_the_compiled_run(simulate):
    simulation = simulate(agents=5)
    with pytest.raises(
        InputError, match="this is a preview, and what is saved is the compiled run"
    ):
        simulation.save().result(60)
    simulation.compiling.ready.set_result(None)
    until(lambda: simulation.state.compiling is None)
    assert simulation.save().result(60) == b"saved"


def test_of_a_large_flock_so_many_move_as_plain_python_can_and_the_page_says_how_many(
    simulate, monkeypatch
):
    """They are the first ones; when it is compiled all are there, at the same tick."""
    monkeypatch.setattr(
        "app.viewer.run.simulation_thread.SimulationThread.measure_tick",
        lambda _self, _spec, _beside, agents: 1e-3 * agents,
    )
    simulation = simulate(agents=1001, size=20.0, speed=200.0)
    until(lambda: simulation.frame.tick > 5)
    some = len(simulation.frame.position)
    assert 100 < some < 1001
    assert simulation.state.preview
    assert f"Preview</b> of {some} of 1\u202f001 agents until compiled" in status(simulation.state)
    shown = simulation.state.run
    simulation.compiling.ready.set_result(None)
    until(lambda: len(simulation.frame.position) == 1001)
    assert simulation.frame.run == simulation.state.run == shown + 1
    assert simulation.frame.tick > 5
    assert "agents until" not in status(simulation.state)


def test_a_flock_of_which_not_a_few_can_move_stands_and_the_page_says_for_how_long(
    simulate, monkeypatch
):
    monkeypatch.setattr(
        "app.viewer.run.simulation_thread.SimulationThread.measure_tick", lambda *_: 9.0
    )
    simulation = simulate(agents=301, size=20.0)
    assert not simulation.state.preview
    with pytest.raises(InputError, match=r"stands until it is compiled \(about 8 s more\)"):
        simulation.step().result(60)
    simulation.go().result(60)
    simulation.set("eta", 1.0).result(60)
    until(lambda: simulation.frame is not None and not simulation.stale)
    assert simulation.run.flock.tick == 0
    assert simulation.readings.values == {}, "what measures is compiled with the flock"
    assert "Waiting</b> until compiled" in status(simulation.state)
    simulation.compiling.ready.set_result(None)
    until(lambda: simulation.frame.tick > 3)
    assert simulation.run.flock.parameters.eta == 1.0


def test_a_preview_whose_ticks_take_too_long_stands(simulate, monkeypatch):
    monkeypatch.setattr("app.viewer.run.kernel_compiler.SLOWEST", -1.0)
    simulation = simulate(agents=5)
    until(lambda: simulation.waits_for_compiler)
    assert not simulation.state.preview
    tick = simulation.run.flock.tick
    time.sleep(0.1)
    assert simulation.run.flock.tick == tick
    simulation.compiling.ready.set_result(None)
    until(lambda: simulation.frame.tick > tick)


def test_the_same_kernel_goes_on_compiling_over_a_reset_and_another_one_is_begun_afresh(simulate):
    simulation = simulate(agents=5)
    first = simulation.compiling
    simulation.reset().result(60)
    until(lambda: simulation.state.run == 2)
    assert simulation.compiling is first
    first.covers = lambda _: False
    simulation.reset().result(60)
    until(lambda: simulation.state.run == 3)
    assert simulation.compiling is not first
    assert first.closed


def test_a_change_in_the_very_moment_when_it_is_compiled_begins_no_other_compile(simulate):
    simulation = simulate(agents=5, running=False)
    first = simulation.compiling

    def change() -> None:
        first.ready.set_result(None)
        simulation.set_now("eta", 1.5, False, None)

    simulation.tell(change).result(60)
    until(lambda: simulation.state.compiling is None)
    assert simulation.compiling is first
    assert simulation.run.flock.parameters.eta == 1.5


def test_a_model_that_cannot_be_compiled_stops_the_run_and_says_why(simulate):
    simulation = simulate(agents=5)
    simulation.compiling.ready.set_exception(InputError("rule 'x', decide, line 3: no"))
    until(lambda: simulation.state.error)
    assert simulation.state.error == "rule 'x', decide, line 3: no"
    assert simulation.state.compiling is None
    assert not simulation.state.running


def test_what_it_took_last_is_kept_beside_the_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("FLOCKSCOPE_CACHE", str(tmp_path))
    assert last_duration("vem-2d-synchronous") is None
    remember(["vem-2d-synchronous", "ivem-2d-synchronous"], 9.0)
    assert last_duration("vem-2d-synchronous") == last_duration("ivem-2d-synchronous") == 4.5
    (tmp_path / "seconds" / "vem-2d-synchronous").write_text("soon")
    assert last_duration("vem-2d-synchronous") is None


COLD = """
import time
import numpy as np
from agents.flock import Flock
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import TimeLineState

spec = preset_spec("vem", agents=20, seed=5)
simulation = Simulation(spec, speed=100.0)
seen = set()
while not simulation.ready.is_set():
    if simulation.frame is not None and simulation.frame.tick > 3:
        seen.add(simulation.state.preview)
    time.sleep(0.01)
simulation.pause().result(60)
ours, flock = simulation.run.flock, Flock(spec)
flock.run(ours.tick)
print(True in seen, ours.interpret, np.array_equal(ours.position, flock.position))
print(sum(flock.loop.advance.stats.cache_misses.values()), simulation.state.error)
simulation.close()
"""


def test_a_run_is_compiled_in_another_process_while_its_preview_moves(tmp_path):
    made = subprocess.run(
        [sys.executable, "-c", COLD],
        env=os.environ | {"FLOCKSCOPE_CACHE": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert made.stdout.split() == ["True", "False", "True", "0"], made.stderr
    assert last_known(tmp_path) > 0.0


def last_known(cache) -> float:
    return float((cache / "seconds" / "vem-2d-synchronous").read_text())


def test_a_preview_is_the_compiled_run_up_to_rounding():
    preview, compiled = (
        Flock(preset_spec("vem", agents=20, seed=5), interpret=plain) for plain in (True, False)
    )
    preview.run(20)
    compiled.run(20)
    np.testing.assert_allclose(preview.position, compiled.position, atol=1e-9)


PARENT = """
import sys, time
from agents.flock import Flock
from app.viewer.run.kernel_compiler import KernelCompiler
made = KernelCompiler([Flock("guarded", rng=1)])
while made.child is None or made.child.pid is None:
    time.sleep(0.01)
print(made.child.pid, flush=True)
time.sleep(100)
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_the_process_that_compiles_ends_with_the_one_that_began_it(tmp_path, number):
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT],
        env=os.environ | {"FLOCKSCOPE_CACHE": str(tmp_path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    child = int(parent.stdout.readline())
    time.sleep(4.0)  # until it compiles
    os.kill(child, 0)
    parent.send_signal(number)
    parent.wait(60)
    until(lambda: is_gone(child), 60, "the process is gone")
    assert not list(tmp_path.rglob("advance*.nb?")), "nothing is half written"


def is_gone(process: int) -> bool:
    """Whether there is no such process; one that is dead and that nobody buries is none."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    listed = Path(f"/proc/{process}/stat")
    return listed.exists() and ") Z " in listed.read_text()


def test_a_compile_that_is_closed_is_never_ready(tmp_path, monkeypatch):
    monkeypatch.setenv("FLOCKSCOPE_CACHE", str(tmp_path))
    made = KernelCompiler([Flock("hwvem", agents=3, rng=1, activation="random")])
    child = until(lambda: made.child is not None and made.child.pid and made.child)
    made.close()
    assert child.exit_code < 0
    time.sleep(0.2)
    assert not made.ready.done()
    assert not made.covers([])
