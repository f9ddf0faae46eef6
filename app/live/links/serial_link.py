"""`serial:PORT?baud=57600`: frames over a serial port, as to a radio that repeats what it hears."""

from __future__ import annotations

from app.live.link_address import LinkAddress
from app.live.links.command_frame import encode, size
from app.live.links.link import CarLink
from app.live.links.wire import LEAST_BAUD, MOST_BAUD, SerialWire, open_wire

BAUD = 57600


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
    baud = place.whole(baud=(BAUD, LEAST_BAUD, MOST_BAUD))["baud"]
    return SerialLink(open_wire(place, baud))
