"""A NatNet server on loopback, as Motive is one: rigid bodies, versions 3.1 and 4.0.

It answers a client on the command port (connect, model definitions) and then sends frames to the
data port of that client's machine, until it is closed. The bytes follow what NatNet's own samples
unpack; little-endian, every message led by its number and its length.
"""

from __future__ import annotations

import random
import socket
import struct
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import NamedTuple

CONNECT, SERVER_INFO = 0, 1
REQUEST_MODEL, MODEL = 4, 5
FRAME = 7
TICKS_PER_SECOND = 10_000_000
MULTICAST = (239, 255, 42, 99)
MARKERS = ((0.05, 0.02, 0.0), (-0.05, 0.02, 0.03), (-0.05, 0.02, -0.03))
"""Of every body, in metres about its middle."""

Version = tuple[int, int]


class Body(NamedTuple):
    """A rigid body as the stream has it, in the axes and the unit of the tracking system."""

    point: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    """x, y, z, w."""
    tracked: bool = True


def message(number: int, payload: bytes) -> bytes:
    """A message as it goes into one datagram."""
    return struct.pack("<HH", number, len(payload)) + payload


def word(text: str) -> bytes:
    """A text that ends with a zero byte."""
    return text.encode() + b"\0"


def server_info(version: Version, data_port: int, multicast: bool) -> bytes:
    """Who the server is, and where it sends frames to."""
    return message(
        SERVER_INFO,
        b"Motive".ljust(256, b"\0")
        + bytes((3, 1, 0, 0))
        + bytes((*version, 0, 0))
        + struct.pack("<QHB4B", TICKS_PER_SECOND, data_port, multicast, *MULTICAST),
    )


def model_definitions(names: list[str], version: Version) -> bytes:
    """Which rigid bodies there are: the stream itself has only their numbers, from 1."""
    payload = struct.pack("<i", 2 * len(names))
    for name in names:
        markers = b"".join(word(f"{name}_{k}") for k, _ in enumerate(MARKERS))
        payload += struct.pack("<i", 0) + word(name) + struct.pack("<i", len(MARKERS)) + markers
    for number, name in enumerate(names, start=1):
        payload += struct.pack("<i", 1) + word(name) + struct.pack("<ii3f", number, -1, 0, 0, 0)
        payload += struct.pack("<i", len(MARKERS))
        payload += b"".join(struct.pack("<3f", *marker) for marker in MARKERS)
        payload += struct.pack(f"<{len(MARKERS)}i", *range(1, len(MARKERS) + 1))
        if version[0] >= 4:
            payload += b"".join(word(f"{name}_{k}") for k, _ in enumerate(MARKERS))
    return message(MODEL, payload)


def frame_of_data(number: int, seconds: float, bodies: Mapping[str, Body]) -> bytes:
    """One frame: marker sets, rigid bodies, labelled markers, times."""
    about = [
        (name, tuple(tuple(map(sum, zip(body.point, marker, strict=True))) for marker in MARKERS))
        for name, body in bodies.items()
    ]
    payload = struct.pack("<ii", number, len(bodies))
    for name, markers in about:
        payload += word(name) + struct.pack("<i", len(markers))
        payload += b"".join(struct.pack("<3f", *marker) for marker in markers)
    payload += struct.pack("<ii", 0, len(bodies))  # no other markers
    for which, body in enumerate(bodies.values(), start=1):
        payload += struct.pack("<i7f", which, *body.point, *body.quaternion)
        payload += struct.pack("<fh", 0.0002, body.tracked)
    payload += struct.pack("<i", 0)  # no skeletons
    payload += struct.pack("<i", sum(len(markers) for _, markers in about))
    for which, (_, markers) in enumerate(about, start=1):
        for k, marker in enumerate(markers, start=1):
            payload += struct.pack("<i3ffhf", which << 16 | k, *marker, 0.014, 0, 0.0002)
    payload += struct.pack("<ii", 0, 0)  # no force plates, no devices
    ticks = int(seconds * TICKS_PER_SECOND)
    payload += struct.pack("<IIdQQQhi", 0, 0, seconds, ticks, ticks, ticks, 0, 0)
    return message(FRAME, payload)


class NatNetEmulator:
    """A running server; `where(seconds)` tells the bodies at a time since its start.

    `mute`: does not answer, as a server that is down. `stop()` ends the frames, `go()` resumes
    them. `drop(name)` loses one body, `find(name)` finds it again. `freeze(noise)` repeats the
    bodies as they stand, shaken by `noise` (standard deviation, in the stream's unit), `thaw()`
    ends that. `intrude(datagram)` is a stranger on the network, who sends to the data port too;
    `sent` are the newest frames, for one who has listened.
    """

    def __init__(
        self,
        where: Callable[[float], Mapping[str, Body]],
        rate: float = 100.0,
        version: Version = (3, 1),
        multicast: bool = False,
        mute: bool = False,
        seed: int = 1,
    ) -> None:
        self.where = where
        self.rate = rate
        self.version = version
        self.multicast = multicast
        self.mute = mute
        self.data_port = free_port()
        self.frames_sent = 0
        self.sent: deque[bytes] = deque(maxlen=200)
        self.requests: list[int] = []
        self._random = random.Random(seed)
        self._lost: set[str] = set()
        self._frozen: tuple[Mapping[str, Body], float] | None = None
        self._flowing = threading.Event()
        self._flowing.set()
        self._closed = threading.Event()
        self._clients: set[str] = set()
        self._command = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._command.bind(("127.0.0.1", 0))
        self._command.settimeout(0.05)
        self.command_port = self._command.getsockname()[1]
        self._data = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._data.setsockopt(
            socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1")
        )
        self._began = time.monotonic()
        self._threads = [threading.Thread(target=self._answer), threading.Thread(target=self._send)]
        for thread in self._threads:
            thread.start()

    @property
    def options(self) -> dict[str, str]:
        """What a client of the `motioncapture` library must be told beside the address."""
        return {"port_command": str(self.command_port), "interface_ip": "127.0.0.1"}

    def stop(self) -> None:
        self._flowing.clear()

    def go(self) -> None:
        self._flowing.set()

    def drop(self, name: str) -> None:
        self._lost.add(name)

    def find(self, name: str) -> None:
        self._lost.discard(name)

    def freeze(self, noise: float) -> None:
        self._frozen = (self.where(time.monotonic() - self._began), noise)

    def thaw(self) -> None:
        self._frozen = None

    def intrude(self, datagram: bytes) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.sendto(datagram, ("127.0.0.1", self.data_port))

    def close(self) -> None:
        self._closed.set()
        for thread in self._threads:
            thread.join()
        self._command.close()
        self._data.close()

    def __enter__(self) -> NatNetEmulator:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _answer(self) -> None:
        while not self._closed.is_set():
            try:
                asked, client = self._command.recvfrom(2048)
            except TimeoutError:
                continue
            (number,) = struct.unpack_from("<H", asked)
            self.requests.append(number)
            if self.mute:
                continue
            if number == CONNECT:
                self._clients.add(client[0])
                info = server_info(self.version, self.data_port, self.multicast)
                self._command.sendto(info, client)
            elif number == REQUEST_MODEL:
                names = list(self.where(0.0))
                self._command.sendto(model_definitions(names, self.version), client)

    def _send(self) -> None:
        number = 0
        while not self._closed.wait(max(0.0, self._began + number / self.rate - time.monotonic())):
            if self._flowing.is_set():
                frame = frame_of_data(number, number / self.rate, self._bodies(number / self.rate))
                hosts = {".".join(map(str, MULTICAST))} if self.multicast else set(self._clients)
                for host in hosts:
                    self._data.sendto(frame, (host, self.data_port))
                self.frames_sent += bool(hosts)
                self.sent.append(frame)
            number += 1

    def _bodies(self, seconds: float) -> dict[str, Body]:
        frozen = self._frozen
        bodies = self.where(seconds) if frozen is None else self._shaken(*frozen)
        return {
            name: body._replace(tracked=body.tracked and name not in self._lost)
            for name, body in bodies.items()
        }

    def _shaken(self, bodies: Mapping[str, Body], noise: float) -> dict[str, Body]:
        return {
            name: body._replace(point=tuple(self._random.gauss(x, noise) for x in body.point))
            for name, body in bodies.items()
        }


def free_port() -> int:
    """A UDP port that nobody uses just now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]
