"""Requests that no browser makes: bytes on a line, and what comes back."""

from __future__ import annotations

import base64
import contextlib
import os
import socket
import time

from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection

from tests.attacks.raw import PROTOCOL
from tests.classroom.running import Person


def knock(port: int, sent: bytes, timeout: float = 20.0) -> bytes:
    """What comes back for these bytes, until the other side closes or `timeout` s are over."""
    found = b""
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 5.0) as line:
        line.settimeout(timeout)
        line.sendall(sent)
        while part := line.recv(65536):
            found += part
    return found


def request(
    first: str = "GET / HTTP/1.1", *headers: str, host: str = "localhost", body: bytes = b""
) -> bytes:
    """A request, whose connection is closed after it."""
    lines = [first, *([f"Host: {host}"] if host else []), "Connection: close", *headers, "", ""]
    return "\r\n".join(lines).encode("latin-1") + body


def upgrade(path: str = "/", *headers: str, protocol: str = PROTOCOL, version: str = "13") -> bytes:
    """A request that wants to become a websocket."""
    key = base64.b64encode(os.urandom(16)).decode()
    lines = [
        f"GET {path} HTTP/1.1",
        "Host: localhost",
        "Connection: Upgrade",
        "Upgrade: websocket",
        f"Sec-WebSocket-Key: {key}",
        f"Sec-WebSocket-Version: {version}",
        *([f"Sec-WebSocket-Protocol: {protocol}"] if protocol else []),
        *headers,
    ]
    return "\r\n".join([*lines, "", ""]).encode("latin-1")


def status(answer: bytes) -> int:
    """The status of an answer; 0 where there is none."""
    first = answer.partition(b"\r\n")[0].split(b" ")
    return int(first[1]) if len(first) > 1 and first[1].isdigit() else 0


def ended_after(port: int, sent: bytes, dripped: bytes = b"", most: float = 40.0) -> float:
    """Seconds until the other side ends a connection on which a byte comes each second."""
    begun = time.monotonic()
    with socket.create_connection(("127.0.0.1", port), 5.0) as line:
        line.sendall(sent)
        line.settimeout(1.0)
        while time.monotonic() - begun < most:
            try:
                if not line.recv(65536):
                    break
            except TimeoutError:
                with contextlib.suppress(OSError):
                    line.sendall(dripped)
            except OSError:
                break
    return time.monotonic() - begun


def let_in(who: Person) -> ClientConnection | None:
    """A websocket; None while so many have been opened that it is not the turn of another."""
    try:
        return who.connect()
    except InvalidStatus:
        time.sleep(0.5)
        return None
