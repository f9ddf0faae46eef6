"""Check that a policy or a controller that hangs does not hold up the laboratory's flock."""

from __future__ import annotations

import socket
from dataclasses import replace

import pytest

from agents import catalogue, policy_process
from agents.kinds import Kind
from agents.policies import POLICIES
from app.front.notices import Notices
from app.steering.controller_pilot import ControllerAddress, ControllerPilot
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from tests.viewer.waiting import COMPILED, until

POLICY = """
from flockscope import policy

@policy(timeout={timeout})
def steady(seen):
    {body}
    return [[0.0]] * len(seen)
"""


@pytest.fixture
def written(tmp_path):
    """Writes the file of a policy, and reads it; whoever comes next knows none of it."""
    files = dict(catalogue.FILES)
    path = tmp_path / "steady.py"

    def write(body: str, timeout: float):
        path.write_text(POLICY.format(body=body, timeout=timeout), "utf-8")
        return path

    yield write
    POLICIES.clear()
    catalogue.FILES.clear()
    catalogue.FILES.update(files)
    for process in policy_process.PROCESSES.values():
        process.end()
    policy_process.PROCESSES.clear()


def running(kind: Kind, **more) -> Simulation:
    """A flock of the laboratory that runs, once it is compiled."""
    spec = preset_spec("vem", agents=20, seed=2).but(kinds=[kind])
    simulation = Simulation(spec, speed=1000.0, **more)
    until(lambda: simulation.state.compiling is None and simulation.frame is not None, COMPILED)
    return simulation


def test_a_policy_that_hangs_is_told_and_the_flock_runs_on_until_it_is_mended(written):
    path = written("while True: pass", timeout=0.3)
    catalogue.from_file(str(path))
    simulation = running(Kind("robot", 1, policy="steady"))
    line = simulation.notices.get(timeout=COMPILED)
    assert "policy steady of kind robot at tick" in line
    assert "no answer within 0.3 s; its agents follow their rule from now on" in line
    tick = simulation.frame.tick
    until(lambda: simulation.frame.tick > tick + 10)
    assert simulation.state.running
    written("", timeout=60.0)
    assert simulation.take_rule(path).result(COMPILED) == "steady"
    until(lambda: not simulation.run.flock.faults)
    simulation.close()


def test_a_policy_that_nobody_knows_stops_the_flock_in_a_line():
    simulation = running(Kind("robot", 1, policy="elsewhere"))
    until(lambda: simulation.state.error)
    assert simulation.state.error == "unknown policy 'elsewhere': give its file by --rule FILE.py"
    simulation.close()


def test_a_controller_that_is_silent_is_told_and_the_flock_runs_on():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        port = line.getsockname()[1]
        pilot = ControllerPilot(ControllerAddress("robot", "127.0.0.1", port, 0.05))
        simulation = running(Kind("robot", 1, steered=True), pilots=[pilot])
        told = simulation.notices.get(timeout=COMPILED)
        assert f"the controller of kind robot at 127.0.0.1:{port}: no answer within 0.05 s" in told
        tick = simulation.frame.tick
        until(lambda: simulation.frame.tick > tick + 10)
        assert simulation.state.running
        simulation.close()
        pilot.close()


def test_a_run_too_short_for_a_silent_controller_tells_it_when_it_ends():
    """By a run that follows, or with the laboratory; once, not for each run."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        address = ControllerAddress("robot", "127.0.0.1", line.getsockname()[1], 0.01)
        pilot = ControllerPilot(address)
        simulation = running(Kind("robot", 1, steered=True), pilots=[pilot], running=False)
        simulation.step().result(COMPILED)
        assert simulation.notices.empty()
        simulation.reset().result(COMPILED)
        told = simulation.notices.get(timeout=COMPILED)
        assert told.startswith(f"{address}: no answer within 0.01 s at tick 0; it never answered")
        simulation.step().result(COMPILED)
        simulation.reset().result(COMPILED)
        simulation.close()
        pilot.close()
    assert simulation.notices.empty()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        pilot = ControllerPilot(replace(address, port=line.getsockname()[1]))
        simulation = running(Kind("robot", 1, steered=True), pilots=[pilot], running=False)
        simulation.step().result(COMPILED)
        simulation.close()
        pilot.close()
    (told,) = Notices(None, simulation.notices).unshown()
    assert "it never answered" in told
