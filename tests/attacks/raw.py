"""A browser that keeps to no rules: raw frames, as many and as fast as the line takes them."""

from __future__ import annotations

import contextlib
import socket
import time
from typing import Any

import msgspec
import viser
from websockets.protocol import CLOSED
from websockets.sync.client import ClientConnection, connect

from tests.live.stand_in import CAMERA

PROTOCOL = f"viser-v{viser.__version__}"
BINARY, TEXT, CONTINUED = 0x2, 0x1, 0x0


def frame(payload: bytes, kind: int = BINARY, last: bool = True) -> bytes:
    """A frame of the websocket protocol as a browser sends it, with a mask that changes nothing."""
    size = len(payload)
    head = bytes([kind | (0x80 if last else 0)])
    if size < 126:
        head += bytes([0x80 | size])
    elif size < 65536:
        head += bytes([0x80 | 126]) + size.to_bytes(2, "big")
    else:
        head += bytes([0x80 | 127]) + size.to_bytes(8, "big")
    return head + bytes(4) + payload


def said(**message: Any) -> bytes:
    """A message of viser's in a frame."""
    return frame(msgspec.msgpack.encode(message))


class Raw:
    """A connection that says what it likes; used with `with`.

    `sent` counts the messages that the line took, `code` and `reason` are how it was closed.
    """

    def __init__(self, port: int, camera: bool = True, host: str = "127.0.0.1"):
        self.line: ClientConnection = connect(
            f"ws://{host}:{port}",
            subprotocols=[PROTOCOL],  # type: ignore[list-item]
            max_size=None,
            max_queue=None,
            close_timeout=0.5,
            ping_interval=None,
        )
        self.sent = 0
        if camera:
            self.say(said(**CAMERA))

    def __enter__(self) -> Raw:
        return self

    def __exit__(self, *_: object) -> None:
        self.line.close()

    def say(self, frames: bytes, count: int = 1) -> bool:
        """Put frames on the line; whether it took them."""
        try:
            self.line.socket.sendall(frames)
        except OSError:
            return False
        self.sent += count
        return True

    def pour(self, message: bytes, seconds: float, most: int = 200_000, at_once: int = 50) -> int:
        """Say one frame again and again; how often the line took it."""
        before, end = self.sent, time.monotonic() + seconds
        heap = message * at_once
        while time.monotonic() < end and self.sent - before < most:
            if not self.say(heap, at_once):
                break
        return self.sent - before

    @property
    def code(self) -> int | None:
        """How the other side closed the line; None while it is open."""
        received = self.line.protocol.close_rcvd
        return received.code if received is not None else None

    @property
    def reason(self) -> str:
        """The word with which it did."""
        received = self.line.protocol.close_rcvd
        return received.reason if received is not None else ""

    @property
    def closed(self) -> bool:
        """Whether the other side has closed the line, or begun to."""
        return self.code is not None or self.line.protocol.state is CLOSED


def alone(port: int, host: str = "127.0.0.1") -> socket.socket:
    """A connection that says nothing at all."""
    return socket.create_connection((host, port), timeout=5.0)


def quietly(*lines: Any) -> None:
    """Close whatever it is."""
    for line in lines:
        with contextlib.suppress(OSError):
            line.close()
