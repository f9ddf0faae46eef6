"""`xbee:PORT?baud=57600`: frames through an XBee in API mode, broadcast over IEEE 802.15.4.

API mode is what the paper wished for and went without (section IV.A): every car hears the frame
at once, instead of each passing it on to the next.

The library looks at the radio while it is opened. Then nothing is read from it any more: anybody on
the channel can have a radio hand over packets, on some of which the library's reader asks back,
waits, closes the port or dies.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

from app.live.link_address import LinkAddress
from app.live.links.command_frame import encode, size
from app.live.links.link import CarLink
from app.live.links.wire import (
    LEAST_BAUD,
    MOST_BAUD,
    SerialWire,
    describe_port_error,
    open_wire,
    take_port,
)
from worlds.input_error import InputError
from worlds.plug_ins import install

BAUD = 57600
API = 9
"""Bytes that the radio's own frame puts around the data: delimiter, length, type, id, address,
options, checksum."""
ANSWER = 2
"""Longest time that the radio may take to answer a question while it is opened, s."""


class XBeeLink(CarLink):
    """Broadcast frames through an XBee; `wrap` puts the radio's own frame around the data."""

    def __init__(self, wire: SerialWire, wrap: Callable[[bytes], bytes]):
        self.name = wire.name
        self.wire = wire
        self.wrap = wrap

    def send(self, seq: int, mode: int, commands: dict[int, tuple[float, float]]) -> None:
        """See CarLink."""
        self.dropped += not self.wire.offer(self.wrap(encode(seq, mode, commands)))

    def occupies(self, cars: int) -> float:
        """See CarLink."""
        return self.wire.seconds(API + size(cars))

    def close(self) -> None:
        """See CarLink."""
        self.wire.close()


def open_xbee(place: LinkAddress) -> XBeeLink:
    """Open the radio, which takes some seconds if it does not answer.

    Raises InputError if it is not there, does not answer in API mode, or is of another family than
    IEEE 802.15.4: the others are too slow at sending to all.
    """
    port = take_port(place)
    baud = place.whole(baud=(BAUD, LEAST_BAUD, MOST_BAUD))["baud"]
    try:
        from digi.xbee.devices import Raw802Device
        from digi.xbee.exception import XBeeException
        from digi.xbee.models.address import XBee16BitAddress
        from digi.xbee.models.mode import OperatingMode
        from digi.xbee.models.options import TransmitOptions
        from digi.xbee.packets.raw import TX16Packet
    except ImportError:
        raise InputError(f"the link {place.text!r} needs digi-xbee: {install('live')}") from None
    # The library writes to the log what is raised as well: without a handler, to the terminal.
    logging.getLogger("digi").addHandler(logging.NullHandler())
    device = Raw802Device(port, baud, _sync_ops_timeout=ANSWER)
    try:
        device.open()
    except (OSError, ValueError) as error:
        device.close()
        reason = describe_port_error(error) if isinstance(error, OSError) else str(error)
        raise InputError(f"the link {place.text!r} cannot open {port}: {reason}") from None
    except XBeeException as error:
        device.close()
        raise InputError(
            f"the link {place.text!r}: the radio at {port} is no XBee for IEEE 802.15.4 in API "
            f"mode at {baud} baud ({error})"
        ) from None
    escaped = device.operating_mode == OperatingMode.ESCAPED_API_MODE
    device.close()

    def wrap(data: bytes) -> bytes:
        """The packet that sends data to all; of number 0, so that the radio reports nothing."""
        everyone, plain = XBee16BitAddress.BROADCAST_ADDRESS, TransmitOptions.NONE.value
        return bytes(TX16Packet(0, everyone, plain, data).output(escaped))

    return XBeeLink(open_wire(place, baud), wrap)
