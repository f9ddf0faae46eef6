"""A Vicon DataStream server on loopback: enough of the protocol for the library to track bodies.

The server says by TCP what it can send; the client answers with what it wants; then every frame is
one packet. A packet is a block that holds blocks; a block is led by its type and its length, which
does not count its own head. Everything is little-endian and unpadded.
"""

from __future__ import annotations

import math
import select
import socket
import struct
import threading

OBJECTS, OBJECT_ENUMS, CONTENTS = 0x1A2B0001, 100001, 100004
STREAM_INFO, SUBJECT_INFO, FRAME_INFO, GLOBAL_SEGMENTS = 1, 2, 5, 9

Body = tuple[float, float, float, float]
"""x, y, z in metres, and the yaw in radians."""


def block(kind: int, data: bytes, size: int | None = None) -> bytes:
    """A block; `size` claims another length than it has."""
    return struct.pack("<II", kind, len(data) if size is None else size) + data


def vector(items: list[bytes], count: int | None = None) -> bytes:
    """A list as the protocol has it; `count` claims another number of items."""
    return struct.pack("<I", len(items) if count is None else count) + b"".join(items)


def string(text: bytes, size: int | None = None) -> bytes:
    """A string; `size` claims another length than it has."""
    return struct.pack("<I", len(text) if size is None else size) + text


def subject(number: int, name: bytes, segments: bytes | None = None) -> bytes:
    """A block that names a body: a subject of one segment of the same name, as rigid bodies are."""
    one = struct.pack("<II6f", 0, 1, *[0.0] * 6) + string(name)
    segments = vector([one]) if segments is None else segments
    nothing = vector([])
    return block(
        SUBJECT_INFO,
        struct.pack("<I", number) + string(name) + segments + nothing + nothing,
    )


def pose(number: int, body: Body, segments: bytes | None = None) -> bytes:
    """A block with the pose of a body."""
    x, y, z, yaw = body
    cos, sin = (math.cos(yaw), math.sin(yaw)) if math.isfinite(yaw) else (yaw, yaw)
    rotation = (cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
    one = struct.pack("<I3d9d", 1, 1000.0 * x, 1000.0 * y, 1000.0 * z, *rotation)
    segments = vector([one]) if segments is None else segments
    return block(GLOBAL_SEGMENTS, struct.pack("<I", number) + segments)


def frame(number: int, *blocks: bytes) -> bytes:
    """A packet with a frame of these blocks."""
    return block(OBJECTS, block(FRAME_INFO, struct.pack("<I", number)) + b"".join(blocks))


class ViconEmulator:
    """A running server whose bodies stand, shaken by 0.3 mm; `bodies` are by name.

    `forge(data)` sends anything in the stream, as one would who has taken the server's place.
    """

    def __init__(self, bodies: dict[str, Body], rate: float = 100.0) -> None:
        self.bodies = bodies
        self.rate = rate
        self.flowing = threading.Event()
        self.flowing.set()
        self.closed = threading.Event()
        self.door = socket.create_server(("127.0.0.1", 0))
        self.door.settimeout(0.05)
        self.host = f"127.0.0.1:{self.door.getsockname()[1]}"
        self.line: socket.socket | None = None
        self.lock = threading.Lock()  # a forged packet must not fall into an honest one
        self.thread = threading.Thread(target=self.serve)

    def __enter__(self) -> ViconEmulator:
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.closed.set()
        self.thread.join()
        self.door.close()

    def forge(self, data: bytes) -> None:
        """Send these bytes to the client, if one is there."""
        with self.lock:
            if self.line is not None:
                self.send(data)

    def hang_up(self) -> None:
        """End the connection, as a server does that is closed."""
        with self.lock:
            self.forget()

    def serve(self) -> None:
        while not self.closed.is_set():
            try:
                line, _ = self.door.accept()
            except TimeoutError:
                continue
            line.settimeout(5.0)
            kinds = (CONTENTS, STREAM_INFO, SUBJECT_INFO, FRAME_INFO, GLOBAL_SEGMENTS)
            offer = block(OBJECT_ENUMS, vector([struct.pack("<I", kind) for kind in kinds]))
            with self.lock:
                self.line = line
                self.send(block(OBJECTS, offer))
            self.stream()
            self.hang_up()

    def stream(self) -> None:
        """Send frames until the client is gone."""
        number = 0
        while not self.closed.wait(1.0 / self.rate):
            with self.lock:
                if self.line is None:
                    return
                if self.flowing.is_set():
                    number += 1
                    self.send(self.honest_frame(number))
                self.drain()

    def honest_frame(self, number: int) -> bytes:
        """The frame that the cameras would give."""
        shake = 0.0003 * math.sin(12.9898 * number)
        blocks = [subject(k, name.encode()) for k, name in enumerate(self.bodies)]
        poses = [
            pose(k, (x + shake, y, z, yaw)) for k, (x, y, z, yaw) in enumerate(self.bodies.values())
        ]
        return frame(number, *blocks, *poses)

    def send(self, data: bytes) -> None:
        """Send all of it; a client that is gone is forgotten. The lock is held."""
        assert self.line is not None
        try:
            self.line.sendall(data)
        except OSError:
            self.forget()

    def drain(self) -> None:
        """Read what the client wants, and its pings; nothing answers. The lock is held."""
        if self.line is None or not select.select([self.line], [], [], 0.0)[0]:
            return
        try:
            gone = not self.line.recv(4096)
        except OSError:
            gone = True
        if gone:
            self.forget()

    def forget(self) -> None:
        """Close the connection. The lock is held."""
        if self.line is not None:
            self.line.close()
            self.line = None
