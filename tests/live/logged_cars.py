"""Cars that keep a log of their own, driven in circles from an operator in another process.

The cars are emulated firmware on a datagram port; where they are is sent, without noise, to
another port that the loop reads.
"""

from __future__ import annotations

import json
import math
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from app.live.emulation.emulated_cars import Datagrams, EmulatedCars
from app.live.emulation.emulated_room import EmulatedPlant
from app.live.laboratory.lab_file import lab_from_toml
from app.live.links.firmware import Firmware
from app.live.links.link import RUN

ROOT = Path(__file__).parents[2]
BEGINS = 90.0
"""Seconds until the cars drive, on a machine that is very busy."""
TIMEOUT = 60.0
STANDS = 0.05
"""m/s below which a car stands."""
ROOM = """title = "a room with a log"
source = "mock:{poses}"
link = "{link}"
rule = "none"

[area]
low = [-3.05, -3.355]
high = [3.05, 3.355]

[cars.red]
address = 1

[cars.blue]
address = 2
"""


class Heard(NamedTuple):
    """A frame as the cars took it."""

    time: float
    """When it came, by which the firmware's watchdog counts, `time.monotonic()`, s."""
    seq: int
    mode: int
    commands: dict[int, tuple[float, float]]


class LoggedFirmware(Firmware):
    """Firmware that writes down every frame that it hears, and when what a car does changes."""

    def __init__(self, addresses):
        super().__init__(addresses)
        self.heard: list[Heard] = []
        self.changes: dict[int, list[tuple[float, str]]] = {one: [] for one in addresses}
        """Time and state, by address."""
        self.now = 0.0
        decode = self.decoder.feed

        def feed(data):
            found = decode(data)
            self.heard += [Heard(self.now, one.seq, one.mode, dict(one.commands)) for one in found]
            return found

        self.decoder.feed = feed

    def feed(self, data, now):
        self.now = now
        super().feed(data, now)

    def drive(self, now):
        for address, state in self.states(now).items():
            changes = self.changes[address]
            if not changes or changes[-1][1] != state:
                changes.append((now, state))
        return super().drive(now)


PROGRAM = """
import sys, time
sys.path[:0] = {path!r}
from pathlib import Path
from live import told_poses as ends
from app.live.control.arm import OperatorRequest
from app.live.operating.operator import Operator
from app.live.laboratory.lab_file import read_lab

if __name__ == "__main__":
    operator = Operator(read_lab({file!r}), ends.{opener}, Path({folder!r}))
    print(operator.process.pid, flush=True)
    asked = 0.0
    while not operator.trouble:
        status, now = operator.status(), time.monotonic()
        if status is not None and status.arm == "safe" and not status.reasons:
            if now - asked > 0.5 and not Path({settled!r}).exists():
                operator.ask(OperatorRequest("arm", "test"))
                asked = now
        time.sleep(0.02)
    print(operator.trouble, flush=True)
"""
"""Arms, again if a busy machine had the cars held; once `settled` is there, they stay held."""


class LoggedRoom:
    """Used with `with`; `process` is the operator's, `loop` the id of the loop's. The cars drive.

    `opener` is one of `live.told_poses`. With `once`, cars that are held after that stay so.
    """

    def __init__(self, folder, opener="circling", once=True):
        self.folder = folder
        self.recording = folder / "run"
        self.settled = folder / "settled"
        self.opener = opener
        self.once = once
        self.firmware = LoggedFirmware((1, 2))
        self.over = threading.Event()

    def __enter__(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        air = Datagrams()
        text = ROOM.format(poses=self.port, link=air.link)
        self.plant = EmulatedPlant(lab_from_toml(text, "room"))
        self.cars = EmulatedCars(self.firmware, self.plant, air)
        self.cars.__enter__()
        self.tracking = threading.Thread(target=self.track, daemon=True)
        self.tracking.start()
        try:
            self.operate(text)
            self.until(self.drive, BEGINS)
            if self.once:
                self.settled.touch()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        self.close()
        self.over.set()
        self.tracking.join()
        self.cars.close()

    def track(self):
        """Tell where the cars are, a hundred times a second."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            while not self.over.wait(0.01):
                poses = {n: (p.x, p.y, p.yaw) for n, p in self.plant.poses().items()}
                told = json.dumps([time.monotonic(), poses]).encode()
                with suppress(OSError):
                    out.sendto(told, ("127.0.0.1", self.port))

    def operate(self, text):
        """Open an operator in a process of its own."""
        file = self.folder / "lab.toml"
        file.write_text(text, encoding="utf-8")
        script = self.folder / "drives.py"
        path = [str(ROOT), str(ROOT / "tests")]
        folder = str(self.recording)
        script.write_text(
            PROGRAM.format(
                path=path,
                file=str(file),
                folder=folder,
                opener=self.opener,
                settled=str(self.settled),
            )
        )
        self.process = subprocess.Popen(
            [sys.executable, str(script)],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        assert self.process.stdout is not None
        self.loop = int(self.process.stdout.readline())

    def until(self, what, within=TIMEOUT):
        """Wait until something is so; fails if it takes too long."""
        ends = time.monotonic() + within
        while not what():
            assert time.monotonic() < ends, f"did not come about; {self.heard[-1:]}"
            time.sleep(0.005)

    def drive(self):
        """Whether all cars do, and have for a while been told to."""
        speeds = [abs(car.speed) for car in self.plant.cars.values()]
        return min(speeds) > 0.7 and [one.mode for one in self.heard[-100:]] == [RUN] * 100

    @property
    def heard(self):
        """What the cars have heard."""
        return self.firmware.heard

    def silence(self, seconds=0.7):
        """Wait until the cars hear nothing any more; the modes of all that they have heard."""
        self.until(lambda: time.monotonic() - self.heard[-1].time > seconds)
        return [one.mode for one in self.heard]

    def stand(self):
        """Wait until all cars stand."""
        self.until(lambda: self.plant.top_speed() < STANDS)

    def states(self):
        """What the firmware of every car does."""
        return set(self.firmware.states(time.monotonic()).values())

    def closest(self):
        """The least distance that there has been between the cars, m."""
        assert math.isfinite(self.plant.least)
        return self.plant.least

    def close(self):
        """End the operator's process, whatever state it is in."""
        if not hasattr(self, "process"):
            return
        with suppress(ProcessLookupError):
            self.process.kill()
        self.process.wait()
        self.process.stdout.close()
