"""Asks a server by HTTP, byte by byte, as no library would let one."""

from __future__ import annotations

import gzip
import socket
from dataclasses import dataclass

import viser


@dataclass(frozen=True)
class Answer:
    """What came back; a name of a header, in small letters -> all its values."""

    status: int
    headers: dict[str, list[str]]
    body: bytes

    def header(self, name: str) -> str:
        """A header that stands there once."""
        (value,) = self.headers[name.lower()]
        return value

    @property
    def text(self) -> str:
        """The body in words."""
        packed = self.headers.get("content-encoding") == ["gzip"]
        return (gzip.decompress(self.body) if packed else self.body).decode()


def ask(port: int, path: str = "/", headers: dict[str, str] | None = None, method: str = "GET"):
    """One request and its answer; None if the server closes without one. `headers` beside Host."""
    given = {"Host": f"localhost:{port}"} | (headers or {})
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in given.items())]
    return tell(port, "\r\n".join((*lines, "", "")).encode("utf-8", "surrogateescape"))


def tell(port: int, request: bytes) -> Answer | None:
    """Send these bytes, and read the answer to its end (to HEAD: whatever comes until the line is
    closed) or, of a websocket, to its first frame."""
    with socket.create_connection(("127.0.0.1", port), timeout=60) as line:
        line.sendall(request)
        got = b""
        while b"\r\n\r\n" not in got:
            more = line.recv(65536)
            if not more:
                return None
            got += more
        head, _, body = got.partition(b"\r\n\r\n")
        first, *rest = head.decode("latin-1").split("\r\n")
        found: dict[str, list[str]] = {}
        for one in rest:
            name, _, value = one.partition(": ")
            found.setdefault(name.lower(), []).append(value)
        status = int(first.split(" ")[1])
        expected = int(found.get("content-length", ["0"])[0])
        while status != 101 and (len(body) < expected or request.startswith(b"HEAD ")):
            more = line.recv(65536)
            if not more:
                break
            body += more
        return Answer(status, found, body)


def upgrade(port: int, origin: str | None = None, host: str | None = None, path: str = "/"):
    """Ask for a websocket as a browser does."""
    headers = {
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Protocol": f"viser-v{viser.__version__}",
    }
    headers |= {} if origin is None else {"Origin": origin}
    headers |= {} if host is None else {"Host": host}
    return ask(port, path, headers)
