"""The firmware of a car, for tests and for trying a laboratory out without cars.

`Car` is what the microcontroller of docs/car-firmware.md does with a frame. `Firmware` is several
cars that hear the same stream of bytes.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from app.live.links.command_frame import CommandFrame, Decoder
from app.live.links.link import EMERGENCY, RUN, STOP

WATCHDOG = 0.25
"""Time without a newer command after which a car stops by itself, s."""
COUNT = 65536
"""Sequence numbers start again after so many."""

State = Literal["waiting", "running", "stopped", "lost", "emergency"]


class CarFirmware:
    """One car: takes commands, knows when to stop. No clock of its own, times are s.

    A car that has just been switched on waits for a frame that says stop, so that one that loses
    its battery for a moment does not drive off by itself; neither does one that has made an
    emergency stop.
    """

    def __init__(self, address: int, watchdog: float = WATCHDOG):
        self.address = address
        self.watchdog = watchdog
        self.latched: Literal["waiting", "emergency"] | None = "waiting"
        """Why nothing but a stop is obeyed; None if the car may run."""
        self.mode = STOP
        self.steer = 0.0
        self.throttle = 0.0
        self.seq: int | None = None
        """Of the newest command; None before the first."""
        self.heard = 0.0
        """When that came."""

    def take_frame(self, command: CommandFrame, now: float) -> None:
        """Take what a frame says, if it is for this car and newer than the last.

        Stops are for all cars. An emergency stop is obeyed however old it is. After the watchdog
        has run out any other sequence number counts as newer: the sender may have started again.
        """
        if command.mode == EMERGENCY:
            self.latched = "emergency"
        own_command = command.commands.get(self.address)
        if (own_command is None and command.mode == RUN) or not self.is_newer(command.seq, now):
            return
        self.seq, self.heard, self.mode = command.seq, now, command.mode
        if command.mode == STOP:
            self.latched = None
        if own_command is not None:
            self.steer, self.throttle = own_command

    def is_newer(self, seq: int, now: float) -> bool:
        """Whether a sequence number comes after that of the newest command."""
        if self.seq is None:
            return True
        ahead = (seq - self.seq) % COUNT
        return 0 < ahead < COUNT // 2 or (ahead != 0 and self.is_late(now))

    def is_late(self, now: float) -> bool:
        """Whether the watchdog has run out."""
        return self.seq is None or now - self.heard > self.watchdog

    def state(self, now: float) -> State:
        """What the car does: only when running it drives."""
        if self.latched is not None:
            return self.latched
        if self.is_late(now):
            return "lost"
        return "running" if self.mode == RUN else "stopped"

    def drive(self, now: float) -> tuple[float, float]:
        """(steer, throttle) at servo and motor, in [-1, 1]; throttle 0 unless running."""
        return self.steer, self.throttle if self.state(now) == "running" else 0.0


class Firmware:
    """The cars that listen to one stream of bytes."""

    def __init__(self, addresses: Iterable[int], watchdog: float = WATCHDOG):
        self.cars = {address: CarFirmware(address, watchdog) for address in addresses}
        self.decoder = Decoder()

    def feed(self, data: bytes, now: float) -> None:
        """Take bytes as they come, at time `now`, s."""
        for command in self.decoder.feed(data):
            for car in self.cars.values():
                car.take_frame(command, now)

    def drive(self, now: float) -> dict[int, tuple[float, float]]:
        """(steer, throttle) of every car, by address."""
        return {address: car.drive(now) for address, car in self.cars.items()}

    def states(self, now: float) -> dict[int, State]:
        """What every car does, by address."""
        return {address: car.state(now) for address, car in self.cars.items()}
