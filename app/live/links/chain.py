"""`chain:PORT?baud=9600`: the chain of addresses of Jacobs et al., figure 6, for cars that have it.

Every command is three bytes: address, steer, throttle. A car that reads an address other than its
own passes the command on to the next car. There is no sync, no check, no sequence and no mode:
one lost byte shifts all that follow, and only the car itself can stop when nothing comes.
"""

from __future__ import annotations

from app.live.link_address import LinkAddress
from app.live.links.command_frame import PER_CAR, levels
from app.live.links.link import CarLink
from app.live.links.wire import LEAST_BAUD, MOST_BAUD, SerialWire, open_wire

BAUD = 9600
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
    baud = place.whole(baud=(BAUD, LEAST_BAUD, MOST_BAUD))["baud"]
    return ChainLink(open_wire(place, baud))
