"""The loop in its own process: whoever dies, the last that the cars hear is a stop."""

from __future__ import annotations

import math
import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import closing, suppress
from pathlib import Path

import pytest

from app.live.control.arm import OperatorRequest
from app.live.links.command_frame import Decoder
from app.live.links.link import EMERGENCY, RUN, STOP
from app.live.operating.operator import Operator
from app.live.recording.recording_replay import read, replay
from app.viewer.live.room_replay import is_finished
from live.rooms import LAB, Steady, crawling, lab, named, refusing
from tests.viewer.waiting import until as wait_until
from worlds.input_error import InputError

ROOT = Path(__file__).parents[2]
TIMEOUT = 30.0


class Cars:
    """The far end of a UDP link: all frames that came, with their times."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.05)
        self.decoder = Decoder()
        self.heard = []

    @property
    def text(self):
        """The room's laboratory, with its link to here."""
        port = self.socket.getsockname()[1]
        return LAB.replace('link = "dry"', f'link = "udp:127.0.0.1:{port}"')

    def listen(self, until, within=TIMEOUT):
        """Hear until something is so; fails if that takes too long."""
        ends = time.monotonic() + within
        while not until():
            assert time.monotonic() < ends, "this did not come about"
            try:
                data = self.socket.recv(2048)
            except TimeoutError:
                continue
            self.heard += self.decoder.feed(data)

    def silence(self, seconds=0.3):
        """Hear until nothing comes any more for a while; the modes of all that came."""
        last = time.monotonic()
        before = len(self.heard)
        while time.monotonic() - last < seconds:
            with suppress(TimeoutError):
                self.heard += self.decoder.feed(self.socket.recv(2048))
            if len(self.heard) != before:
                before, last = len(self.heard), time.monotonic()
        return [command.mode for command in self.heard]

    def mode(self):
        return self.heard[-1].mode if self.heard else None


@pytest.fixture
def cars():
    one = Cars()
    yield one
    one.socket.close()


@pytest.fixture
def operator(cars):
    one = Operator(lab(cars.text), crawling)
    yield one
    one.close()


def arm(operator, cars):
    cars.listen(lambda: cars.mode() == STOP)
    operator.ask(OperatorRequest("arm", "test"))
    cars.listen(lambda: cars.mode() == RUN)


def wait_for(what):
    ends = time.monotonic() + TIMEOUT
    while not what():
        assert time.monotonic() < ends, "this did not come about"
        time.sleep(0.01)


def test_the_operator_arms_stops_and_leaves(operator, cars):
    arm(operator, cars)
    wait_for(lambda: operator.status() is not None and operator.status().mode == RUN)
    assert {car.state for car in operator.status().cars} == {"tracked"}
    assert cars.heard[-1].commands[1][1] == pytest.approx(0.1, abs=0.005)
    operator.ask(OperatorRequest("emergency", "browser 1"))
    cars.listen(lambda: cars.mode() == EMERGENCY)
    operator.ask(OperatorRequest("arm", "browser 1"))
    wait_for(lambda: operator.status() and "refused" in [event.kind for event in operator.events])
    assert cars.mode() == EMERGENCY
    operator.ask(OperatorRequest("reset", "test"))
    cars.listen(lambda: cars.mode() == STOP)
    wait_for(lambda: operator.status() and len(operator.events) == 6)
    assert [(event.kind, event.cause) for event in operator.events] == [
        ("arm", "test"),
        ("run", ""),
        ("emergency", "browser 1"),
        ("stop", ""),
        ("refused", "browser 1"),
        ("reset", "test"),
    ]
    operator.close()
    assert not operator.alive
    assert cars.silence()[-5:] == [STOP] * 5


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_to_the_loop_stops_the_cars(operator, cars, number):
    arm(operator, cars)
    os.kill(operator.process.pid, number)
    assert cars.silence()[-5:] == [STOP] * 5
    wait_for(lambda: not operator.alive)


def test_a_killed_loop_says_nothing_more_and_the_operator_knows(operator, cars):
    arm(operator, cars)
    operator.process.kill()
    wait_for(lambda: not operator.alive)
    assert cars.silence()[-1] == RUN
    operator.status()
    assert operator.trouble == "the control loop is gone: the cars stop themselves"
    operator.status()


PROGRAM = """
import sys, time
sys.path[:0] = {path!r}
from live.rooms import crawling, lab
from app.live.control.arm import OperatorRequest
from app.live.operating.operator import Operator

if __name__ == "__main__":
    operator = Operator(lab(open({file!r}).read()), crawling)
    operator.status()
    time.sleep(0.3)
    operator.ask(OperatorRequest("arm", "test"))
    while True:
        time.sleep(0.01)
        operator.status()
"""


@pytest.fixture
def other(cars, tmp_path):
    """An operator in a process of its own, armed, that can be stopped and killed."""
    (tmp_path / "lab.toml").write_text(cars.text)
    path = [str(ROOT), str(ROOT / "tests")]
    script = tmp_path / "drives.py"
    script.write_text(PROGRAM.format(path=path, file=str(tmp_path / "lab.toml")))
    process = subprocess.Popen([sys.executable, str(script)], cwd=ROOT)
    cars.listen(lambda: cars.mode() == RUN)
    yield process
    process.kill()
    process.wait()


def test_a_killed_operator_stops_the_cars(other, cars):
    other.kill()
    other.wait()
    assert cars.silence()[-5:] == [STOP] * 5


def test_an_operator_that_hangs_does_not_hold_the_loop_up(other, cars):
    os.kill(other.pid, signal.SIGSTOP)
    try:
        heard = len(cars.heard)
        cars.listen(lambda: len(cars.heard) > heard + 100)
        assert {command.mode for command in cars.heard[heard:]} == {RUN}
        numbers = [command.seq for command in cars.heard[heard:]]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
        cars.listen(lambda: cars.mode() == STOP)  # for nobody could stop them there
    finally:
        os.kill(other.pid, signal.SIGCONT)


MOCK = "mock:?frequency=100&rigid_bodies=red(0,0,0,1,0,0,0);blue body(0,1,0,1,0,0,0)"


def test_a_source_whose_process_is_killed_stops_the_cars_and_is_in_the_log(cars):
    operator = Operator(lab(cars.text.replace("mock:", MOCK)), named)
    try:
        wait_for(
            lambda: (
                operator.status()
                and {car.tracking for car in operator.status().cars} == {"tracked"}
            )
        )
        arm(operator, cars)
        (source,) = children(operator.process.pid)
        os.kill(source, signal.SIGKILL)
        cars.listen(lambda: cars.mode() == STOP)
        # The first status that comes may be from before the arming, and safe.
        wait_for(lambda: operator.status() and of_source(operator))
        assert "its process was killed (SIGKILL)" in of_source(operator)[0]
        wait_for(lambda: operator.status().arm == "safe")
    finally:
        operator.close()


def of_source(operator):
    """What the events so far say of the source."""
    return [event.words for event in operator.events if event.kind == "source"]


def children(pid):
    """The processes that a process has begun, without multiprocessing's own tracker."""
    found = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [
        int(one)
        for one in found
        if b"resource_tracker" not in Path(f"/proc/{one}/cmdline").read_bytes()
    ]


def test_what_cannot_begin_is_refused_in_one_line():
    with pytest.raises(InputError, match="unknown link 'dri': did you mean 'dry'"):
        Operator(lab(), refusing)


def test_a_recording_is_finished_when_the_operator_closes(cars, tmp_path):
    operator = Operator(lab(cars.text), crawling, tmp_path / "run")
    arm(operator, cars)
    operator.close()
    recorded = read(tmp_path / "run")
    kinds = [event["kind"] for event in recorded.events()]
    assert kinds == ["arm", "run", "hold", "stop", "end"]
    modes = [tick.mode for tick in recorded.ticks()]
    assert modes[-6:] == [RUN] + [STOP] * 5
    begun = modes.index(RUN)
    assert set(modes[begun:-5]) == {RUN}


def happened(operator, kind, count):
    """Wait until there have been so many events of a kind; the last of them."""
    ends = time.monotonic() + TIMEOUT
    while len(found := [event for event in operator.events if event.kind == kind]) < count:
        assert time.monotonic() < ends, f"{kind} did not happen"
        operator.status()
        time.sleep(0.01)
    return found[-1]


def test_a_recording_begins_and_ends_while_the_cars_drive(cars, tmp_path):
    with closing(Operator(lab(cars.text), crawling)) as operator:
        arm(operator, cars)
        for number in (1, 2):
            folder = tmp_path / "shelf" / str(number)
            operator.record(folder, "browser 3")
            begun = happened(operator, "record", 2 * number - 1)
            assert (begun.note, begun.cause) == (str(folder), "browser 3")
            operator.record(tmp_path / "other", "browser 3")
            assert "recorded already" in happened(operator, "recording", number).words
            heard = len(cars.heard)
            cars.listen(lambda heard=heard: len(cars.heard) > heard + 30)
            operator.record(None, "browser 3")
            assert happened(operator, "record", 2 * number).note == ""
            wait_until(lambda folder=folder: is_finished(folder))
        assert {command.mode for command in cars.heard[heard:]} == {RUN}
        ticks = [[one.number for one in read(tmp_path / "shelf" / n).ticks()] for n in ("1", "2")]
        assert 1 < ticks[0][0] < ticks[0][-1] < ticks[1][0]
        assert all(one == list(range(one[0], one[-1] + 1)) for one in ticks)
        assert not (tmp_path / "other").exists()
    with pytest.raises(InputError, match="it was begun at tick"):
        replay(tmp_path / "shelf" / "1", lambda _: Steady())


@pytest.fixture
def software():
    """The room of the tests in software, on a port that is known."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    text = LAB.replace('"mock:"', '"simulated"').replace('"dry"', f'"simulated?port={port}"')
    one = Operator(lab(text), named)
    one.port = port
    yield one
    one.close()


def tracked(operator):
    status = operator.status()
    return status is not None and {car.tracking for car in status.cars} == {"tracked"}


def taken(port):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return True
        return False


def test_a_room_in_software_is_seen_and_its_cars_obey(software):
    wait_for(lambda: tracked(software))
    assert taken(software.port)
    begun = {car.name: car.pose for car in software.status().cars}
    software.ask(OperatorRequest("arm", "test"))
    wait_for(lambda: software.status().mode == RUN)

    def gone():
        return [
            math.hypot(car.pose.x - begun[car.name].x, car.pose.y - begun[car.name].y)
            for car in software.status().cars
        ]

    wait_for(lambda: min(gone()) > 0.1)
    software.close()
    assert not taken(software.port)


def test_a_room_in_software_is_seen_with_a_dry_link_too():
    dry = Operator(lab(LAB.replace('"mock:"', '"simulated"')), named)
    try:
        wait_for(lambda: tracked(dry))
        assert dry.status().troubles == {}
    finally:
        dry.close()
