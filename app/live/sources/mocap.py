"""Motion capture through the `motioncapture` package (libmotioncapture): one file, five systems.

The library tells neither time nor frame number, has no timeout, and holds the interpreter while it
connects; the `Feed` therefore runs it in a child process and gives it up. A body that it does not
track is missing from its frames. Where it falls behind it gives the newest frame only.
"""

from __future__ import annotations

import ipaddress
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count
from typing import Any

from app.live.control.pose import MocapFrame, Sighting
from app.live.sources.axes import Axes
from app.live.sources.source_address import AXES, Address
from worlds.input_error import InputError, unknown
from worlds.plug_ins import demand


@dataclass(frozen=True, slots=True)
class System:
    """What the library wants to know of one motion-capture system, and how it gives positions."""

    up: str
    options: tuple[str, ...] = ()
    """Options beyond the host, by the library's names."""
    fixed: bool = False
    """Whether the library itself gives metres with z up, so that there is nothing to declare."""
    numeric: bool = False
    """Whether it wants the address of the host in numbers."""


SYSTEMS = {
    "vicon": System("z", fixed=True),
    "optitrack": System("y", ("port_command", "interface_ip"), numeric=True),
    "qualisys": System("z", ("port",)),
    "vrpn": System("z"),
    "mock": System("z", ("rigid_bodies", "frequency")),
}

HIDDEN = "Unknown rigid body!"
"""What the library raises for the whole frame when a Vicon subject is hidden: none is told then."""
LARGEST = {"port": 65535, "port_command": 65535, "frequency": 1000}
"""The options that are whole numbers from 1."""


@dataclass(frozen=True)
class MotionCapture:
    """A motion-capture system on the network.

    Raises InputError for an unknown system, a host or options that it cannot have.
    """

    name: str
    host: str
    axes: Axes = field(default_factory=Axes)
    options: Mapping[str, str] = field(default_factory=dict)
    longest_gap: float = 10.0
    """Once the other end has hung up, as a server does that is begun anew, the library waits for
    ever, some of it with a whole core; after cameras that were only paused nothing is lost."""

    def __post_init__(self) -> None:
        if self.name not in SYSTEMS:
            raise unknown("motion-capture system", self.name, SYSTEMS)
        system = SYSTEMS[self.name]
        for option, value in self.options.items():
            if option not in system.options:
                raise unknown(f"option of {self.name}", option, system.options)
            if option in LARGEST and not _is_whole_number(value, LARGEST[option]):
                raise InputError(f"{option} = {value} is no whole number in [1, {LARGEST[option]}]")
        if system.fixed and (self.axes.up, self.axes.unit) != ("z", "m"):
            raise InputError(f"{self.name} is given in metres with z up, not with {self.axes}")
        if not self.host and self.name != "mock":
            raise InputError(f"{self.name} has no host: write {self.name}:HOST")
        if system.numeric:
            try:
                ipaddress.IPv4Address(self.host)
            except ValueError:
                raise InputError(
                    f"host = {self.host} is not a numeric address such as 192.168.1.5, "
                    f"which {self.name} wants"
                ) from None

    def describe(self) -> str:
        """What it is in a few words."""
        return f"{self.name} at {self.host or 'this machine'} ({self.axes})"

    def frames(self, stop: threading.Event) -> Iterator[MocapFrame]:
        """Connect and give frames as they come; see `Source.frames`.

        Raises InputError if the package is missing, RuntimeError if the system cannot be used.
        """
        demand("motioncapture", self.name, "live")
        import motioncapture

        system = motioncapture.connect(self.name, {"hostname": self.host, **self.options})
        return self._received(system, stop)

    def _received(self, system: Any, stop: threading.Event) -> Iterator[MocapFrame]:
        for number in count():
            if stop.is_set():
                return
            system.waitForNextFrame()
            received = time.monotonic()
            bodies = _bodies(system)
            yield MocapFrame(
                number,
                received,
                tuple(self._sighting(name, bodies[name]) for name in sorted(bodies)),
            )

    def _sighting(self, name: str, body: Any) -> Sighting:
        turn = body.rotation
        return self.axes.sighting(name, body.position, (turn.x, turn.y, turn.z, turn.w))


def _bodies(system: Any) -> Mapping[str, Any]:
    """The bodies of the frame that has come, by name; none where the library cannot tell."""
    try:
        return system.rigidBodies
    except RuntimeError as error:
        if str(error) != HIDDEN:
            raise
        return {}


def _is_whole_number(word: str, largest: int) -> bool:
    return word.isascii() and word.isdigit() and 1 <= int(word) <= largest


def open_mocap(address: Address) -> MotionCapture:
    """The motion-capture system that an address names."""
    if address.kind not in SYSTEMS:
        raise unknown("motion-capture system", address.kind, SYSTEMS)
    system = SYSTEMS[address.kind]
    address.known((*AXES, *system.options))
    demand("motioncapture", address.kind, "live")
    options = {name: value for name, value in address.options if name not in AXES}
    try:
        return MotionCapture(address.kind, address.place, address.axes(system.up), options)
    except InputError as refused:
        raise InputError(f"{refused} ({address.text})") from None
