"""The links by name: UDP, a serial port, a dry run, a chain of cars, and a laboratory's own."""

from __future__ import annotations

import runpy
import socket
from collections.abc import Callable
from pathlib import Path

from app.live.device_kinds import FILE, SIMULATED, kind_of
from app.live.link_address import LinkAddress, read_place
from app.live.links.command_frame import PER_CAR, CommandFrame, encode, levels, size
from app.live.links.link import CarLink, LinkLost
from app.live.links.wire import LEAST_BAUD, MOST_BAUD, SerialWire, open_wire
from app.live.links.xbee import open_xbee
from worlds.input_error import InputError, unknown
from worlds.plug_ins import plug_ins

EXAMPLE = "udp:192.168.1.20:5005"


class UdpLink(CarLink):
    """Broadcast frames as datagrams."""

    def __init__(self, name: str, family: int, address: tuple):
        self.name = name
        self.address = address
        self.socket = socket.socket(family, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        self.socket.setblocking(False)

    def send(self, seq: int, mode: int, commands: dict[int, tuple[float, float]]) -> None:
        """See CarLink. That nobody listens cannot be known."""
        frame = encode(seq, mode, commands)
        try:
            self.socket.sendto(frame, self.address)
        except (BlockingIOError, ConnectionRefusedError):
            self.dropped += 1
        except OSError as error:
            raise LinkLost(f"the link {self.name!r} is lost: {error.strerror}") from None

    def close(self) -> None:
        """See CarLink."""
        self.socket.close()


def open_udp(place: LinkAddress) -> UdpLink:
    """A socket for the address. Raises InputError if it is none or cannot be found."""
    place.whole()
    host, colon, port = place.wants("to which address", EXAMPLE).rpartition(":")
    if not colon or not host:
        raise InputError(f"the link {place.text!r} has no port: for example {EXAMPLE}")
    number = place.number("port", port, 1, 65535)
    try:
        addresses = socket.getaddrinfo(host.strip("[]"), number, type=socket.SOCK_DGRAM)
    except OSError as error:
        raise InputError(
            f"the link {place.text!r} leads to no address: {host} cannot be found"
            f" ({error.strerror})"
        ) from None
    family, _, _, _, address = addresses[0]
    return UdpLink(place.text, family, address)


SERIAL_BAUD = 57600


class SerialLink(CarLink):
    """Broadcast frames over a serial port."""

    def __init__(self, wire: SerialWire):
        self.name = wire.name
        self.wire = wire

    def send(self, seq: int, mode: int, commands: dict[int, tuple[float, float]]) -> None:
        """See CarLink."""
        self.dropped += not self.wire.offer(encode(seq, mode, commands))

    def occupies(self, cars: int) -> float:
        """See CarLink."""
        return self.wire.seconds(size(cars))

    def close(self) -> None:
        """See CarLink."""
        self.wire.close()


def open_serial(place: LinkAddress) -> SerialLink:
    """Open the port. Raises InputError."""
    baud = place.whole(baud=(SERIAL_BAUD, LEAST_BAUD, MOST_BAUD))["baud"]
    return SerialLink(open_wire(place, baud))


MOST_EVERY = 100_000


class DryLink(CarLink):
    """Checks what is sent as every link does, keeps the last of it, and sends nothing.

    `every` > 0 prints one frame in that many, beginning with the first.
    """

    def __init__(self, name: str = "dry", every: int = 0):
        self.name = name
        self.every = every
        self.sent = 0
        self.last: CommandFrame | None = None
        """The last frame, its commands as they were given."""

    def send(self, seq: int, mode: int, commands: dict[int, tuple[float, float]]) -> None:
        """See CarLink."""
        frame = encode(seq, mode, commands)
        if self.every and self.sent % self.every == 0:
            print(f"{self.name}: {frame.hex(' ')}")
        self.last = CommandFrame(seq, mode, dict(commands))
        self.sent += 1

    def close(self) -> None:
        """See CarLink."""


def open_dry(place: LinkAddress) -> DryLink:
    """`dry`, or `dry?every=100` to print every hundredth frame."""
    if place.where:
        raise InputError(f"the link {place.text!r} leads nowhere: write dry, not {place.where!r}")
    return DryLink(place.text, place.whole(every=(0, 0, MOST_EVERY))["every"])


CHAIN_BAUD = 9600
"""As in the paper."""


def encode_chain(mode: int, commands: dict[int, tuple[float, float]]) -> bytes:
    """Three bytes per car; throttle 0 unless the mode is RUN. Raises InputError as `encode` does.

    >>> encode_chain(1, {1: (0.0, 1.0), 2: (-1.0, 0.5)}).hex(" ")
    '01 00 7f 02 81 40'
    """
    return bytes(byte & 0xFF for command in levels(mode, commands) for byte in command)


class ChainLink(CarLink):
    """Commands passed on from car to car."""

    def __init__(self, wire: SerialWire):
        self.name = wire.name
        self.wire = wire

    def send(self, seq: int, mode: int, commands: dict[int, tuple[float, float]]) -> None:
        """See CarLink; the chain carries no `seq`, and any mode but RUN as throttle 0."""
        del seq
        self.dropped += not self.wire.offer(encode_chain(mode, commands))

    def occupies(self, cars: int) -> float:
        """See CarLink."""
        return self.wire.seconds(PER_CAR * cars)

    def close(self) -> None:
        """See CarLink."""
        self.wire.close()


def open_chain(place: LinkAddress) -> ChainLink:
    """Open the port that leads to the first car. Raises InputError."""
    baud = place.whole(baud=(CHAIN_BAUD, LEAST_BAUD, MOST_BAUD))["baud"]
    return ChainLink(open_wire(place, baud))


Opener = Callable[[LinkAddress], CarLink]
"""Opens a link; raises InputError if it cannot."""
ENTRY = "open_link"
"""What the file of a link calls its opener."""

BUILT_IN: dict[str, Opener] = {
    "serial": open_serial,
    "xbee": open_xbee,
    "udp": open_udp,
    "chain": open_chain,
    "dry": open_dry,
}


def collect() -> dict[str, Opener]:
    """All kinds of link: the built-in ones, then those of other packages, which replace none."""
    return BUILT_IN | plug_ins("flockscope.links", link_of_entry, BUILT_IN)


def link_of_entry(name: str, thing: object) -> tuple[str, Opener]:
    """The link that an entry point brings. Raises TypeError if it opens nothing."""
    if not callable(thing):
        raise TypeError(f"a function is needed, not {type(thing).__name__}")
    return name, thing


LINKS = collect()


def open_link(text: str, folder: Path | None = None) -> CarLink:
    """Open the link that a text names, as `serial:/dev/ttyUSB0?baud=57600`.

    The kind may be a Python file, as `my_radio.py:/dev/ttyACM0`, looked for in `folder`, the
    working directory if there is none. That runs the file: the text must come from the person who
    runs the laboratory, never from a browser. Raises InputError.
    """
    if kind_of(text) == SIMULATED:
        raise InputError(f"the link {text!r} has cars to reach only where a laboratory is opened")
    place = known_link(text)
    if place.kind.endswith(FILE):
        return load_opener((folder or Path()) / place.kind, text)(place)
    return LINKS[place.kind](place)


def known_link(text: str) -> LinkAddress:
    """The parts of a text. Raises InputError if it is none of a link, or there is no such kind.

    The kind `simulated` is opened together with its source, by
    `app.live.emulation.emulated_cars`.
    """
    place = read_place(text)
    if place.kind not in LINKS and not place.kind.endswith(FILE):
        raise unknown("link", place.kind, (*LINKS, SIMULATED), text)
    return place


def load_opener(file: Path, text: str) -> Opener:
    """The opener in a Python file. Raises InputError if there is none."""
    if not file.is_file():
        raise InputError(f"there is no file {file} (link {text!r})")
    try:
        names = runpy.run_path(str(file))
    except Exception as error:
        raise InputError(f"{file} cannot be run: {type(error).__name__}: {error}") from error
    if not callable(names.get(ENTRY)):
        raise InputError(f"{file} has no function {ENTRY}(place)")
    opener: Opener = names[ENTRY]
    return opener
