"""`xbee:PORT?baud=57600`: frames through an XBee in API mode, broadcast over IEEE 802.15.4.

API mode is what the paper wished for and went without (section IV.A): every car hears the frame
at once, instead of each passing it on to the next.
"""

from __future__ import annotations

import logging
from contextlib import suppress
from typing import Any

from app.live.links.frame import encode, size
from app.live.links.link import CarLink, LinkLost
from app.live.links.wire import LEAST_BAUD, MOST_BAUD, Wire, take_port, why
from app.live.place import Place
from worlds.extra import install
from worlds.refusal import Refusal

BAUD = 57600
API = 9
"""Bytes that the radio's own frame puts around the data: delimiter, length, type, id, address,
options, checksum."""
READ = 0.1
"""Time for which the library's reader waits for a byte, s: closing waits for the reader."""
ANSWER = 2
"""Longest time that the radio may take to answer a question while it is opened, s."""


class XBeeLink(CarLink):
    """Broadcast frames through an XBee that is open; `everyone` is the address of all."""

    def __init__(self, name: str, device: Any, everyone: Any):
        self.name = name
        self.device = device
        self.everyone = everyone
        self.wire = Wire(device.serial_port, name)
        device.serial_port.timeout = READ
        device.serial_port.write_frame = self.write  # the library's own may wait

    def send(self, seq: int, mode: int, commands: dict[int, tuple[float, float]]) -> None:
        """See CarLink."""
        from digi.xbee.exception import XBeeException

        frame = encode(seq, mode, commands)
        try:
            self.device.send_data_async_16(self.everyone, frame)
        except XBeeException as error:
            raise LinkLost(f"the link {self.name!r} is lost: {error}") from None

    def write(self, data: bytearray) -> None:
        """Write what the library has wrapped a frame in."""
        self.dropped += not self.wire.offer(bytes(data))

    def occupies(self, cars: int) -> float:
        """See CarLink."""
        return self.wire.seconds(API + size(cars))

    def close(self) -> None:
        """See CarLink."""
        with suppress(OSError):  # the port may be gone already
            self.wire.drain()
        with suppress(OSError):
            self.device.close()


def open_xbee(place: Place) -> XBeeLink:
    """Open the radio, which takes some seconds if it does not answer.

    Raises Refusal if it is not there, does not answer in API mode, or is of another family than
    IEEE 802.15.4: the others are too slow at sending to all.
    """
    port = take_port(place)
    baud = place.whole(baud=(BAUD, LEAST_BAUD, MOST_BAUD))["baud"]
    try:
        from digi.xbee.devices import Raw802Device
        from digi.xbee.exception import XBeeException
        from digi.xbee.models.address import XBee16BitAddress
    except ImportError:
        raise Refusal(f"the link {place.text!r} needs digi-xbee: {install('live')}") from None
    # The library writes to the log what is raised as well: without a handler, to the terminal.
    logging.getLogger("digi").addHandler(logging.NullHandler())
    device = Raw802Device(port, baud, _sync_ops_timeout=ANSWER)
    try:
        device.open()
    except (OSError, ValueError) as error:
        device.close()
        reason = why(error) if isinstance(error, OSError) else str(error)
        raise Refusal(f"the link {place.text!r} cannot open {port}: {reason}") from None
    except XBeeException as error:
        device.close()
        raise Refusal(
            f"the link {place.text!r}: the radio at {port} is no XBee for IEEE 802.15.4 in API "
            f"mode at {baud} baud ({error})"
        ) from None
    return XBeeLink(place.text, device, XBee16BitAddress.BROADCAST_ADDRESS)
