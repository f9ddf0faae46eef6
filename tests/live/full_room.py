"""A whole laboratory without hardware: an emulated NatNet server, the real library, the loop in its
own process, a pty, emulated firmware, and cars that are computed."""

from __future__ import annotations

import math
import random
import time

from app.live.control.arm import OperatorRequest
from app.live.emulation.emulated_cars import EmulatedCars, Terminal
from app.live.emulation.emulated_room import EmulatedPlant
from app.live.laboratory.lab_file import lab_from_toml
from app.live.links.firmware import Firmware
from app.live.operating.lab_choices import open_driven
from app.live.operating.operator import Operator
from live.natnet_emulator import Body, NatNetEmulator

NOISE_XY, NOISE_YAW = 0.0005, 0.005
STANDS = 0.05
"""m/s below which a car stands."""
LOOKS = 0.05
"""Seconds between two looks at cars on a machine that has time for them."""
TIMEOUT = 60.0
TEXT = """title = "a whole room"
source = "{source}"
link = "{link}"
rule = "squashing"

[area]
low = [-3.05, -3.355]
high = [3.05, 3.355]
fence = 0.5

[injected]
radius = 2.0
speed = 1.1
"""
CAR = """
[cars.{name}]
address = {address}
body = "{name} car"
speed = {speed}
"""


class Air:
    """Between radio and cars: `cut` lets nothing through; bytes are lost or changed by chance."""

    def __init__(self):
        self.cut = False
        self.lost = 0.0
        self.random = random.Random(3)

    def __call__(self, data):
        if self.cut:
            return b""
        made = bytearray()
        for byte in data:
            chance = self.random.random()
            if chance >= self.lost:
                made.append(byte)
            elif chance >= 0.5 * self.lost:
                made.append(self.random.randrange(256))
        return bytes(made)


class FullRoom:
    """Used with `with`; the cars, of `speed` m/s at full throttle, stand until `run`."""

    def __init__(self, *names, recording=None, speed=1.0):
        self.names = names
        self.speed = speed
        self.recording = recording
        self.random = random.Random(1)
        self.air = Air()
        self.firmware = Firmware(range(1, len(names) + 1))

    def __enter__(self):
        terminal = Terminal()
        text = TEXT + "".join(
            CAR.format(name=name, address=k, speed=self.speed)
            for k, name in enumerate(self.names, start=1)
        )
        self.plant = EmulatedPlant(
            lab_from_toml(text.format(source="mock:", link=terminal.link), "room")
        )
        self.server = NatNetEmulator(self.bodies)
        options = "&".join(f"{name}={value}" for name, value in self.server.options.items())
        source = f"optitrack:127.0.0.1?up=y&{options}"
        lab = lab_from_toml(text.format(source=source, link=terminal.link), "room")
        self.cars = EmulatedCars(self.firmware, self.plant, terminal, self.air)
        self.cars.__enter__()
        self.operate(lab)
        return self

    def operate(self, lab):
        """Open the operator."""
        self.operator = Operator(lab, open_driven, self.recording)

    def __exit__(self, *_):
        self.operator.close()
        self.cars.close()
        self.server.close()

    def bodies(self, _seconds):
        """The cars as Motive tells them: y is up."""
        gauss = self.random.gauss
        found = {}
        for name, pose in self.plant.poses().items():
            half = 0.5 * gauss(pose.yaw, NOISE_YAW)
            point = (gauss(pose.x, NOISE_XY), 0.05, -gauss(pose.y, NOISE_XY))
            found[f"{name} car"] = Body(point, (0.0, math.sin(half), 0.0, math.cos(half)))
        return found

    def status(self):
        """The newest look at the loop."""
        return self.operator.status()

    def kinds(self, since=0):
        """The kinds of the events after the first so many."""
        self.status()
        return [event.kind for event in self.operator.events[since:]]

    def until(self, what, within=TIMEOUT):
        """Seconds until something is so; fails if it takes too long."""
        began = time.monotonic()
        while not what():
            events = [event.words for event in self.operator.events[-5:]]
            assert time.monotonic() - began < within, f"did not come about; {events}"
            time.sleep(0.005)
        return time.monotonic() - began

    def run(self):
        """Arm, again if need be, until all cars drive."""
        asked = 0.0

        def drives():
            nonlocal asked
            status = self.status()
            may = status is not None and status.arm == "safe" and not status.reasons
            if may and time.monotonic() - asked > 0.5:
                asked = time.monotonic()
                self.operator.ask(OperatorRequest("arm", "test"))
            speeds = [abs(car.speed) for car in self.plant.cars.values()]
            return min(speeds) > 0.5 * self.speed

        self.until(drives)

    def stops(self):
        """Seconds and metres until all cars stand.

        Firmware and cars are computed in this process: what a busy machine keeps it waiting does
        not count, as a car has a processor of its own.
        """
        before, waited, looked = self.plant.poses(), 0.0, time.monotonic()

        def stand():
            nonlocal waited, looked
            now = time.monotonic()
            waited, looked = waited + max(0.0, now - looked - LOOKS), now
            return self.plant.top_speed() < STANDS * self.speed

        seconds = self.until(stand)
        after = self.plant.poses()
        metres = max(
            math.hypot(after[name].x - at.x, after[name].y - at.y) for name, at in before.items()
        )
        return seconds - waited, metres - self.speed * waited

    def states(self):
        """What the firmware of every car does."""
        return set(self.firmware.states(time.monotonic()).values())

    def lag(self, name):
        """Degrees by which a car is behind the injected one."""
        target, pose = self.status().injected, self.plant.poses()[name]
        lag = math.atan2(target.y, target.x) - math.atan2(pose.y, pose.x)
        return math.degrees(math.remainder(lag, 2.0 * math.pi))
