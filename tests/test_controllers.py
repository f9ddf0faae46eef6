"""Check controllers in other processes: they steer as they say, and none holds up a run."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from agents.flock import Flock
from agents.kinds import Kind, kind_table
from agents.spec import Spec
from app.cli.main import app
from app.steering.controller_pilot import (
    LONGEST,
    MISSES,
    MOST_AGENTS,
    AnswerError,
    ControllerAddress,
    ControllerPilot,
    open_controllers,
    read_address,
    read_answer,
)
from worlds.input_error import InputError

SCRIPT = Path(__file__).parents[1] / "docs" / "controller.py"


@contextmanager
def controller(answer):
    """A controller on a port of its own: `answer` gives what it sends for what it is told, bytes
    or JSON, or None for nothing. Yields the port."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))

        def serve():
            with suppress(OSError):
                while True:
                    data, sender = line.recvfrom(65535)
                    if data == b"end":
                        return
                    for reply in [answer(json.loads(data))]:
                        if reply is not None:
                            text = reply if isinstance(reply, bytes) else json.dumps(reply).encode()
                            line.sendto(text, sender)

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        port = line.getsockname()[1]
        yield port
        line.sendto(b"end", ("127.0.0.1", port))
        thread.join()


def left(told):
    """Everybody turns to the left by a quarter of half a turn."""
    actions = {str(agent["id"]): [0.25] for agent in told["agents"]}
    return {"tick": told["tick"], "actions": actions}


def steered_flock(port: int, timeout: float = 10.0) -> tuple[Flock, ControllerPilot]:
    """A flock with two robots, without noise, and who asks their controller."""
    spec = Spec("vem", agents=20, seed=2, kinds=[Kind("robot", 2, steered=True)])
    flock = Flock(spec.taking(eta=0.0))
    pilot = ControllerPilot(ControllerAddress("robot", "127.0.0.1", port, timeout))
    flock.pilots = (pilot,)
    flock.tell = (lines := []).append
    flock.lines = lines
    return flock, pilot


def free_flock() -> Flock:
    spec = Spec("vem", agents=20, seed=2, kinds=[Kind("robot", 2, steered=True)])
    return Flock(spec.taking(eta=0.0))


def test_agents_do_what_their_controller_says():
    told = []
    with controller(lambda message: told.append(message) or left(message)) as port:
        flock, pilot = steered_flock(port)
        rows = flock.rows_of("robot")
        before = flock.heading[rows].copy()
        position = flock.position[rows].copy()
        flock.run(3)
        cos, sin = np.cos(0.75 * np.pi), np.sin(0.75 * np.pi)
        assert np.allclose(flock.heading[rows], before @ np.array([[cos, sin], [-sin, cos]]))
        pilot.close()
    assert [message["tick"] for message in told] == [0, 1, 2]
    assert (told[0]["kind"], told[0]["wish"], told[0]["numbers"]) == ("robot", "heading", 1)
    places = {agent["id"]: agent["position"] for agent in told[0]["agents"]}
    for row, place in zip(rows, position, strict=True):
        assert np.allclose(places[int(flock.ids[row])], place, atol=1e-6)
    assert not flock.lines


def test_who_is_told_nothing_follows_its_rule():
    def answer(told):
        first, second = (str(agent["id"]) for agent in told["agents"])
        return {"tick": told["tick"], "actions": {first: None} if first == "21" else {second: None}}

    with controller(answer) as port:
        flock, pilot = steered_flock(port)
        free = free_flock()
        flock.run(3)
        free.run(3)
        assert np.array_equal(flock.position, free.position)
        pilot.close()


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (b"\xff\x00", "an answer that is no JSON"),
        (b"[" * 9000, "an answer that is no JSON"),
        (b" " * (LONGEST + 1), f"an answer of more than {LONGEST} bytes"),
        ([1, 2], "an answer without its tick and actions alone"),
        ({"tick": 5}, "an answer without its tick and actions alone"),
        ({"tick": 5, "actions": {}, "more": 1}, "an answer without its tick and actions alone"),
        ({"tick": 6, "actions": {}}, "an answer to tick 6"),
        ({"tick": 4, "actions": {}}, "an answer to tick 4"),
        ({"tick": True, "actions": {}}, "an answer to tick True"),
        ({"tick": 5, "actions": [0.1]}, "an answer whose actions are no table by identities"),
        ({"tick": 5, "actions": {"1": [0.1]}}, "an answer about agent '1', which it does not"),
        ({"tick": 5, "actions": {"21": [0.1, 0.1]}}, r"with \[0.1, 0.1\] for agent 21: 1 numbers"),
        ({"tick": 5, "actions": {"21": [2.0]}}, r"with \[2.0\] for agent 21"),
        ({"tick": 5, "actions": {"21": ["0.1"]}}, r"with \['0.1'\] for agent 21"),
        (b'{"tick": 5, "actions": {"21": [NaN]}}', r"with \[nan\] for agent 21"),
    ],
)
def test_what_an_answer_may_not_be(answer, told):
    flock = free_flock()
    flock.run(5)
    data = answer if isinstance(answer, bytes) else json.dumps(answer).encode()
    with pytest.raises(AnswerError, match=told):
        read_answer(data, flock, flock.rows_of("robot"), flock.tick)


@pytest.mark.parametrize("answer", [lambda _: None, lambda _: b"{}"])
def test_silence_and_nonsense_are_told_once_and_the_rule_goes_on(answer):
    with controller(answer) as port:
        flock, pilot = steered_flock(port, timeout=0.05)
        free = free_flock()
        flock.run(12)
        free.run(12)
        assert np.array_equal(flock.position, free.position)
        pilot.close()
    (line,) = flock.lines
    assert f"at tick {MISSES - 1}; its agents follow their rule until it answers" in line
    assert flock.faults == (line,)
    assert pilot.waits == MISSES


@pytest.mark.parametrize("ticks", range(1, MISSES + 2))
def test_a_run_of_any_length_tells_once_that_its_controller_never_answered(ticks):
    with controller(lambda _: None) as port:
        flock, pilot = steered_flock(port, timeout=0.01)
        flock.run(ticks)
        flock.end_run()
        flock.end_run()
        pilot.close()
    (line,) = flock.lines
    last = min(ticks, MISSES) - 1
    assert f"the controller of kind robot at 127.0.0.1:{port}: no answer within 0.01 s" in line
    assert f"at tick {last}; " in line
    assert flock.faults == (line,)


def test_a_run_that_is_not_asked_or_was_answered_tells_nothing_at_its_end():
    is_there = threading.Event()
    is_there.set()
    with controller(lambda told: left(told) if is_there.is_set() else None) as port:
        flock, pilot = steered_flock(port)
        flock.end_run()
        flock.run(1)
        is_there.clear()
        pilot.address = ControllerAddress("robot", "127.0.0.1", port, 0.01)
        flock.run(MISSES - 1)
        flock.end_run()
        assert not flock.lines
        flock.run(1)  # of another run, in which nobody has answered
        flock.end_run()
        pilot.close()
    (line,) = flock.lines
    assert "it never answered, its agents followed their rule" in line


@pytest.mark.parametrize("ticks", [1, 2, 5])
def test_a_short_run_of_the_command_line_says_that_its_controller_is_silent(ticks):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        place = f"127.0.0.1:{line.getsockname()[1]}"
        run = ["run", "vem", "--agents", "9", "--ticks", str(ticks), "--quiet", "--json"]
        steer = ["--kind", "robot=2,steered=true", "--steer", f"robot={place}?timeout=0.01"]
        flown = CliRunner().invoke(app, [*run, *steer])
    assert flown.exit_code == 0, flown.output
    told = f"the controller of kind robot at {place}: no answer within 0.01 s"
    (fault,) = json.loads(flown.stdout)["faults"]
    assert fault.startswith(told)
    assert flown.stderr == f"flockscope: {fault}\n"


@pytest.mark.parametrize("late", [1, 3])
def test_a_controller_that_always_answers_another_tick_holds_up_few_ticks(late):
    def answer(told):
        return left(told) | {"tick": told["tick"] - late}

    with controller(answer) as port:
        flock, pilot = steered_flock(port, timeout=0.02)
        flock.run(300)
        assert pilot.waits <= MISSES + 9  # waits after 1, 2, 4, ... ticks
        assert len(flock.lines) == 1
        pilot.close()


def test_a_controller_that_comes_back_steers_again():
    is_there = threading.Event()

    def answer(told):
        return left(told) if is_there.is_set() else None

    with controller(answer) as port:
        flock, pilot = steered_flock(port, timeout=0.02)
        flock.run(MISSES)
        assert pilot.fault
        is_there.set()
        pilot.address = ControllerAddress("robot", "127.0.0.1", port, 10.0)
        for _ in range(10_000):
            flock.run(1)
            if not pilot.fault:
                break
        assert f"answers again at tick {flock.tick - 1}" in flock.lines[-1]
        rows = flock.rows_of("robot")
        before = flock.heading[rows].copy()
        flock.run(1)
        assert not np.allclose(flock.heading[rows], before)
        pilot.close()


def test_a_run_that_begins_again_has_no_pauses_of_the_run_before():
    """They are counted by its ticks, and ticks begin at 0 again."""

    def late(told):
        return left(told) | {"tick": told["tick"] - 1}

    with controller(late) as port:
        flock, pilot = steered_flock(port, timeout=0.01)
        for _ in range(10_000):  # until an answer has come, which a busy machine makes later
            flock.run(1)
            if pilot.pause > 1:
                break
        assert pilot.next_wait > MISSES
        flock.end_run()
        assert (pilot.next_wait, pilot.pause) == (0, 1)
        pilot.close()


def test_nobody_listens_and_others_are_not_heard():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        port = line.getsockname()[1]
        flock, pilot = steered_flock(port, timeout=0.02)
        rows = flock.rows_of("robot")
        told = {"tick": 0, "agents": [{"id": int(flock.ids[row])} for row in rows]}
        own = pilot.socket.getsockname()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.sendto(json.dumps(left(told)).encode(), own)
        flock.run(1)
        assert np.isnan(flock.arrays.wish).all()
    flock.run(MISSES)
    assert pilot.fault
    pilot.close()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("robot", "robot is not KIND=HOST:PORT"),
        ("robot=127.0.0.1", "is not KIND=HOST:PORT"),
        ("robot=127.0.0.1:0", "is not KIND=HOST:PORT"),
        ("robot=127.0.0.1:99999", "is not KIND=HOST:PORT"),
        ("robot=127.0.0.1:91?timeout=0", r"timeout = 0 is not allowed: seconds in \(0, 10\]"),
        ("robot=127.0.0.1:91?timeout=nan", "timeout = nan is not allowed"),
        ("robot=127.0.0.1:91?speed=3", "unknown option 'speed'"),
        ("robot=192.0.2.7:9100", r"192\.0\.2\.7 is another machine.*\?network=true"),
        ("robot=no.such.host.invalid:91", "cannot be found"),
    ],
)
def test_an_address_that_cannot_be_is_refused_in_a_line(text, told):
    with pytest.raises(InputError, match=told):
        read_address(text)


def test_only_steered_kinds_have_a_controller_and_each_has_one():
    kinds = kind_table(
        [Kind("robot", 2, steered=True), Kind("many", MOST_AGENTS + 1, steered=True), Kind("x", 1)],
        {},
    )
    for texts, told in (
        (["x=127.0.0.1:91"], "kind x is not steered"),
        (["y=127.0.0.1:91"], "unknown kind 'y'"),
        (["many=127.0.0.1:91"], "65 agents: a controller steers 64 at most"),
        (["robot=127.0.0.1:91", "robot=127.0.0.1:92"], "kind robot has two controllers"),
    ):
        with pytest.raises(InputError, match=told):
            open_controllers(texts, kinds)
    assert read_address("robot=192.0.2.7:9100?network=true").host == "192.0.2.7"


def test_the_controller_of_the_docs_steers_a_run():
    command = [sys.executable, str(SCRIPT), "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        port = process.stdout.readline().split()[-1]
        run = ["run", "vem", "--agents", "30", "--seed", "1", "--ticks", "20", "--quiet", "--json"]
        kind = ["--kind", "robot=2,steered=true"]
        steer = ["--steer", f"robot=127.0.0.1:{port}?timeout=10"]
        flown = CliRunner().invoke(app, [*run, *kind, *steer])
        free = CliRunner().invoke(app, [*run, *kind])
        process.kill()
    assert flown.exit_code == 0, flown.output
    one, other = json.loads(flown.stdout), json.loads(free.stdout)
    assert "faults" not in one
    assert one["observables"] != other["observables"]
