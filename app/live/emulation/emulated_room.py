"""A room in software: emulated cars at the end of a UDP link, tracked as a real room is.

All but the cars and the cameras is what runs with real ones: the loop, the safety, the frames on
the link, the firmware's watchdog, the tracking in a process of its own.
"""

from __future__ import annotations

import math
import random
import socket
import threading
from dataclasses import dataclass, fields
from itertools import combinations

from app.live.control.pose import Pose, Sighting, seen
from app.live.device_kinds import SIMULATED, kind_of, port_of
from app.live.emulation.emulated_cars import Datagrams, EmulatedCars
from app.live.laboratory.lab_file import Lab, lab_from_toml
from app.live.link_address import LinkAddress
from app.live.links.firmware import Firmware
from app.live.links.link import CarLink
from app.live.links.link_catalogue import open_link, open_udp
from app.live.sources.pose_source import Source
from app.live.sources.simulated_source import SimulatedSource

# Cars that are computed: what emulated firmware drives where there are no real ones.
#
# A bicycle that turns about its rear axle, with a motor that lags and a servo that takes its time:
# the mechanics of the simulated cars, written apart from them, so that one can check the other.
# Cars pass through each other here; `least` tells how near they came.

LONGEST_STEP = 0.02
"""Seconds that are moved in one go."""


@dataclass(frozen=True)
class Mechanics:
    """How cars turn; the defaults are those of `agents.bodies.car`, which takes long to import."""

    circle: float = 0.95
    """Diameter of the turning circle, m."""
    wheel_max: float = 45.0
    """Largest angle of the front wheels, deg."""
    servo: float = 7.0
    """How fast they turn, rad/s."""


@dataclass
class RollingCar:
    """A car as it rolls."""

    x: float
    """Of the middle of its rear axle, m."""
    y: float
    yaw: float
    """rad."""
    top: float
    """Speed at full throttle, m/s."""
    lag: float
    """Time constant of its motor, s."""
    mechanics: Mechanics
    speed: float = 0.0
    """m/s."""
    wheel: float = 0.0
    """Angle of its front wheels, rad."""

    def roll(self, steer: float, throttle: float, seconds: float) -> None:
        """Go on with a command (both in [-1, 1]) for a time."""
        most = math.radians(self.mechanics.wheel_max)
        turn = self.mechanics.servo * seconds
        self.wheel += min(max(steer * most - self.wheel, -turn), turn)
        decay = math.exp(-seconds / self.lag) if self.lag > 0.0 else 0.0
        before = self.speed
        self.speed = self.top * throttle + (self.speed - self.top * throttle) * decay
        distance = 0.5 * (before + self.speed) * seconds
        length = 0.5 * self.mechanics.circle * math.tan(most)
        bend = distance * math.tan(self.wheel) / length
        self.x += distance * math.cos(self.yaw + 0.5 * bend)
        self.y += distance * math.sin(self.yaw + 0.5 * bend)
        self.yaw = math.remainder(self.yaw + bend, 2.0 * math.pi)


class EmulatedPlant:
    """The cars of a laboratory at their start; a plant as `EmulatedCars` wants it."""

    def __init__(self, lab: Lab):
        names = [field.name for field in fields(Mechanics) if field.name in lab.parameters]
        mechanics = Mechanics(**{name: float(lab.parameters[name]) for name in names})
        # The thread of the cars moves them, that of the tracking looks: never at half a step.
        self.lock = threading.Lock()
        self.cars: dict[int, RollingCar] = {}
        self.names = {car.address: name for name, car in lab.cars.items()}
        self.now: float | None = None
        self.least = math.inf
        """The least distance (m) there has been between the middles of two rear axles."""
        for car, at in zip(lab.cars.values(), starts(lab), strict=True):
            self.cars[car.address] = RollingCar(at.x, at.y, at.yaw, car.speed, car.lag, mechanics)

    def __call__(self, now: float, commands: dict[int, tuple[float, float]]) -> None:
        """Move up to `now`, s, with (steer, throttle) by address."""
        with self.lock:
            left = 0.0 if self.now is None else now - self.now
            self.now = now
            while left > 0.0:
                step = min(left, LONGEST_STEP)
                for address, command in commands.items():
                    self.cars[address].roll(*command, step)
                left -= step
            for car, other in combinations(self.cars.values(), 2):
                self.least = min(self.least, math.hypot(car.x - other.x, car.y - other.y))

    def poses(self) -> dict[str, Pose]:
        """Where the cars are, by name."""
        with self.lock:
            return {
                self.names[address]: Pose(car.x, car.y, car.yaw)
                for address, car in self.cars.items()
            }

    def top_speed(self) -> float:
        """The highest speed of any car, m/s."""
        with self.lock:
            return max(abs(car.speed) for car in self.cars.values())


def starts(lab: Lab) -> list[Pose]:
    """Where the emulated cars begin: one behind the other on a ring, noses along it.

    Behind the injected car, where that goes round; else about the middle of the area.
    """
    plan, area = lab.injected, lab.area
    round_about = plan.path == "circle"
    low, high = area.low, area.high
    middle = plan.centre if round_about else (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]))
    ring = 0.8 * plan.radius if round_about else 0.8 * area.distance_inside(*middle)
    way = math.copysign(1.0, plan.speed) if round_about else 1.0
    apart = min(35.0, 300.0 / len(lab.cars))
    places = []
    for k in range(len(lab.cars)):
        angle = math.radians(plan.begins - way * (50.0 + apart * k))
        places.append(
            Pose(
                middle[0] + ring * math.cos(angle),
                middle[1] + ring * math.sin(angle),
                math.remainder(angle + way * 0.5 * math.pi, 2.0 * math.pi),
            )
        )
    return places


NOISE_XY, NOISE_YAW = 0.0005, 0.005
"""Of the tracking, standard deviation: m and rad."""


class EmulatedRoom:
    """Cars that hear a UDP port and move in real time; see `app.live.sources.simulated_source`."""

    def __init__(self, lab: Lab, port: int):
        self.plant = EmulatedPlant(lab)
        self.bodies = {name: car.body or name for name, car in lab.cars.items()}
        self.chance = random.Random(1)
        self.cars = EmulatedCars(Firmware(self.plant.cars), self.plant, Datagrams(port))
        self.cars.thread.start()

    def advance(self, seconds: float) -> None:
        """Nothing: its cars have a clock of their own."""

    def sightings(self) -> tuple[Sighting, ...]:
        """Where the cars are, with the tracking's noise."""
        return tuple(
            seen(self.bodies[name], self.add_tracking_noise(pose))
            for name, pose in self.plant.poses().items()
        )

    def add_tracking_noise(self, pose: Pose) -> Pose:
        """A pose as the tracking has it."""
        gauss = self.chance.gauss
        return Pose(gauss(pose.x, NOISE_XY), gauss(pose.y, NOISE_XY), gauss(pose.yaw, NOISE_YAW))

    def close(self) -> None:
        """Switch the cars off."""
        self.cars.close()


@dataclass(frozen=True)
class RoomBuilder:
    """Makes the room in the process of the tracking."""

    laboratory: str
    """As TOML."""
    port: int

    def __call__(self) -> EmulatedRoom:
        """The room."""
        return EmulatedRoom(lab_from_toml(self.laboratory, "the laboratory"), self.port)


def free_port() -> int:
    """A UDP port of this machine that nobody hears just now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


# Emulated cars: the source that tracks them and the link that leads to them.


def open_emulated(lab: Lab) -> tuple[Source, CarLink]:
    """The source of emulated cars, not yet connected, and the link to them, open.

    With the link `dry` there are cars too, and nothing is sent to them. Raises InputError.
    """
    to_cars = kind_of(lab.link) == SIMULATED
    port = (port_of(lab.link) if to_cars else 0) or free_port()
    link = udp_link(lab.link, port) if to_cars else open_link(lab.link)
    return SimulatedSource(RoomBuilder(lab.to_toml(), port), title="emulated cars"), link


def udp_link(name: str, port: int) -> CarLink:
    """A link to a UDP port of this machine."""
    return open_udp(LinkAddress(name, "udp", f"127.0.0.1:{port}", {}))
