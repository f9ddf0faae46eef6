"""A Qualisys Track Manager on loopback: enough of its real-time protocol 1.19 for the library.

A client connects by TCP, sets the version, asks for the bodies' names and then has frames sent to
its UDP port, 6734 with this library. Little-endian; every packet is led by its size and its type.
"""

from __future__ import annotations

import math
import socket
import struct
import threading
from collections.abc import Callable

COMMAND, XML, DATA, EVENT = 1, 2, 3, 6
EULER = 6
"""The component: bodies as positions and Euler angles."""
CLIENT_PORT = 6734

Body = tuple[float, float, float, float]
"""x, y, z in mm, and the turn about z in degrees."""


def packet(kind: int, payload: bytes) -> bytes:
    """A packet; its size counts its own head."""
    return struct.pack("<II", 8 + len(payload), kind) + payload


def names_in_xml(names: list[str]) -> bytes:
    """The answer to `GetParameters 6D`."""
    bodies = "".join(
        f"<Body><Name>{name}</Name><RGBColor>255</RGBColor>"
        "<Point><X>0</X><Y>0</Y><Z>0</Z></Point></Body>"
        for name in names
    )
    return (
        f"<QTM_Parameters_Ver_1.19><The_6D><Bodies>{len(names)}</Bodies>{bodies}"
        "<Euler><First>Roll</First><Second>Pitch</Second><Third>Yaw</Third></Euler>"
        "</The_6D></QTM_Parameters_Ver_1.19>"
    ).encode()


def frame(number: int, bodies: list[Body], count: int | None = None) -> bytes:
    """A data packet with the bodies; `count` says another number of them."""
    told = len(bodies) if count is None else count
    rows = b"".join(struct.pack("<6f", x, y, z, 0.0, 0.0, turn) for x, y, z, turn in bodies)
    component = struct.pack("<IIIHH", 16 + len(rows), EULER, told, 0, 0) + rows
    return packet(DATA, struct.pack("<QII", 10_000 * number, number, 1) + component)


def frame_of(packed: bytes) -> bytes:
    """A data packet of one component that is anything."""
    return packet(DATA, struct.pack("<QII", 0, 1, 1) + packed)


class QualisysEmulator:
    """A running server whose bodies stand, shaken by 0.3 mm; `bodies` are by name.

    `answer(command)` may give other bytes than the emulator would, for one command; None: its own.
    `forge(datagram)` sends anything to the client's port, as a stranger would, who knows it.
    """

    def __init__(
        self,
        bodies: dict[str, Body],
        answer: Callable[[str], bytes | None] = lambda _: None,
        rate: float = 100.0,
    ) -> None:
        self.bodies = bodies
        self.answer = answer
        self.rate = rate
        self.frames_sent = 0
        self.flowing = threading.Event()
        self.flowing.set()
        self.closed = threading.Event()
        self.streaming = threading.Event()
        self.door = socket.create_server(("127.0.0.1", 0))
        self.door.settimeout(0.05)
        self.udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.threads = [threading.Thread(target=self.listen), threading.Thread(target=self.send)]

    @property
    def options(self) -> dict[str, str]:
        """What the library must be told: it adds 1 to the port, for little-endian."""
        return {"port": str(self.door.getsockname()[1] - 1)}

    def __enter__(self) -> QualisysEmulator:
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.closed.set()
        for thread in self.threads:
            thread.join()
        self.door.close()
        self.udp.close()

    def forge(self, datagram: bytes) -> None:
        self.udp.sendto(datagram, ("127.0.0.1", CLIENT_PORT))

    def listen(self) -> None:
        while not self.closed.is_set():
            try:
                line, _ = self.door.accept()
            except TimeoutError:
                continue
            with line:
                line.settimeout(0.05)
                self.attend(line)
            self.streaming.clear()

    def attend(self, line: socket.socket) -> None:
        line.sendall(self.answer("") or packet(COMMAND, b"QTM RT Interface connected\0"))
        waiting = b""
        while not self.closed.is_set():
            try:
                data = line.recv(4096)
            except TimeoutError:
                continue
            except OSError:
                return
            if not data:
                return
            waiting += data
            while len(waiting) >= 8 and len(waiting) >= (
                size := struct.unpack("<I", waiting[:4])[0]
            ):
                command = waiting[8:size].rstrip(b"\0").decode()
                waiting = waiting[size:]
                try:
                    line.sendall(self.reply(command))
                except OSError:
                    return

    def reply(self, command: str) -> bytes:
        own = self.answer(command)
        if own is not None:
            return own
        word = command.split()[0]
        if word == "Version":
            return packet(COMMAND, f"Version set to {command.split()[1]}\0".encode())
        if word == "GetState":
            return packet(EVENT, b"\x01")
        if word == "GetParameters":
            return packet(XML, names_in_xml(list(self.bodies)) + b"\0")
        if word == "StreamFrames":
            self.streaming.set()
            return b""
        if word == "QTMVersion":
            return packet(COMMAND, b"QTM Version is 2.17\0")
        return packet(COMMAND, b"Ok\0")

    def send(self) -> None:
        number = 0
        while not self.closed.wait(1.0 / self.rate):
            if self.streaming.is_set() and self.flowing.is_set():
                shake = 0.3 * math.sin(12.9898 * number)
                self.forge(
                    frame(number, [(x + shake, y, z, a) for x, y, z, a in self.bodies.values()])
                )
                self.frames_sent += 1
            number += 1


def turned(x: float, y: float, yaw: float) -> Body:
    """A body on the floor, from metres and radians."""
    return 1000.0 * x, 1000.0 * y, 50.0, math.degrees(yaw)
