"""A VRPN server on loopback: enough of version 07.35 for the library to see its trackers.

A client asks by a datagram that names its own TCP port; the server connects to that. Both send a
cookie; then come messages: length, time, sender, type, number, payload padded to 8 bytes, all
big-endian. Names of senders and types are messages too, of types below 0.
"""

from __future__ import annotations

import math
import socket
import struct
import threading
from itertools import count

COOKIE = b"vrpn: ver. 07.35  0".ljust(24, b"\0")
NAMES_SENDER, NAMES_TYPE = -1, -2
POSE = "vrpn_Tracker Pos_Quat"
HEAD = 24

Body = tuple[tuple[float, float, float], tuple[float, float, float, float]]
"""Position, m, and quaternion x, y, z, w."""


def message(kind: int, sender: int, payload: bytes, length: int | None = None) -> bytes:
    """A message; `length` says another length than it has."""
    told = HEAD + len(payload) if length is None else length
    padded = payload + b"\0" * (-len(payload) % 8)
    return struct.pack(">iiiiii", told, 1, 0, sender, kind, 0) + padded


def naming(kind: int, number: int, name: str) -> bytes:
    """That a sender or a type of a number is called so."""
    text = name.encode() + b"\0"
    return message(kind, number, struct.pack(">i", len(text)) + text)


def pose(sender: int, body: Body) -> bytes:
    """The pose of a tracker's sensor 0."""
    return message(0, sender, struct.pack(">ii7d", 0, 0, *body[0], *body[1]))


class VrpnEmulator:
    """A running server whose trackers stand, shaken by 0.3 mm, by name.

    `say` sends anything in between; `greeting` is sent instead of the cookie.
    """

    def __init__(
        self, bodies: dict[str, Body], greeting: bytes = COOKIE, rate: float = 100.0
    ) -> None:
        self.bodies = bodies
        self.greeting = greeting
        self.rate = rate
        self.flowing = threading.Event()
        self.flowing.set()
        self.closed = threading.Event()
        self.lost = threading.Event()
        """That a client has gone."""
        self.extra: list[bytes] = []
        self.lock = threading.Lock()
        self.asked = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.asked.bind(("127.0.0.1", 0))
        self.asked.settimeout(0.05)
        self.thread = threading.Thread(target=self.run)

    @property
    def host(self) -> str:
        return f"127.0.0.1:{self.asked.getsockname()[1]}"

    def __enter__(self) -> VrpnEmulator:
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.closed.set()
        self.thread.join()
        self.asked.close()

    def say(self, data: bytes) -> None:
        with self.lock:
            self.extra.append(data)

    def run(self) -> None:
        while not self.closed.is_set():
            try:
                words = self.asked.recv(256).rstrip(b"\0").split()
                line = socket.create_connection(("127.0.0.1", int(words[1])), 1.0)
            except (TimeoutError, OSError, IndexError, ValueError):
                continue
            with line:
                try:
                    self.serve(line)
                except OSError:
                    self.lost.set()

    def serve(self, line: socket.socket) -> None:
        line.settimeout(1.0)
        line.sendall(self.greeting)
        line.sendall(naming(NAMES_TYPE, 0, POSE))
        for number, name in enumerate(self.bodies):
            line.sendall(naming(NAMES_SENDER, number, name))
        line.setblocking(False)
        for number in count():
            if self.closed.wait(1.0 / self.rate):
                return
            self.drain(line)
            with self.lock:
                data, self.extra = b"".join(self.extra), []
            if self.flowing.is_set():
                data += b"".join(
                    pose(k, ((x + 0.0003 * math.sin(12.9898 * number), y, z), turn))
                    for k, ((x, y, z), turn) in enumerate(self.bodies.values())
                )
            line.settimeout(1.0)
            line.sendall(data)
            line.setblocking(False)

    def drain(self, line: socket.socket) -> None:
        try:
            if not line.recv(65536):
                raise ConnectionResetError
        except BlockingIOError:
            pass
