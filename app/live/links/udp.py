"""`udp:HOST:PORT`: one frame per datagram, to one address or, ending in .255, to a network."""

from __future__ import annotations

import socket

from app.live.link_address import LinkAddress
from app.live.links.command_frame import encode
from app.live.links.link import CarLink, LinkLost
from worlds.input_error import InputError

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
