"""A room in software: emulated cars at the end of a UDP link, tracked as a real room is.

All but the cars and the cameras is what runs with real ones: the loop, the safety, the frames on
the link, the firmware's watchdog, the tracking in a process of its own.
"""

from __future__ import annotations

import random
import socket
from dataclasses import dataclass

from app.live.control.pose import Pose, Sighting, seen
from app.live.emulation.emulated_cars import Datagrams, EmulatedCars
from app.live.emulation.plant import EmulatedPlant
from app.live.laboratory.lab_file import Lab, lab_from_toml
from app.live.links.firmware import Firmware

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
            seen(self.bodies[name], self.shaken(pose)) for name, pose in self.plant.poses().items()
        )

    def shaken(self, pose: Pose) -> Pose:
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
