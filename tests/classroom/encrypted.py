"""Somebody who reaches a class by https, by whatever name, without a browser."""

from __future__ import annotations

import http.client
import socket
import ssl
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlencode

import msgspec
from websockets.sync.client import ClientConnection, connect

from tests.classroom.running import BUSY, PROTOCOL
from tests.live.stand_in import CAMERA


@dataclass
class Encrypted:
    """One who trusts a certificate; `name` and `port` are what stands in their address line."""

    name: str
    port: int
    trusted: Path
    cookies: dict[str, str] = field(default_factory=dict)

    @property
    def base(self) -> str:
        """The origin of the pages."""
        return f"https://{self.name}:{self.port}"

    @property
    def cookie(self) -> str:
        """The header with the cookies."""
        return "; ".join(f"{name}={value}" for name, value in self.cookies.items())

    def line(self) -> ssl.SSLSocket:
        """A line, encrypted."""
        plain = socket.create_connection(("127.0.0.1", self.port), BUSY)
        context = ssl.create_default_context(cafile=str(self.trusted))
        return context.wrap_socket(plain, server_hostname=self.name)

    def ask(
        self, path: str, method: str = "GET", body: str | None = None, **headers: str
    ) -> tuple[int, http.client.HTTPMessage, str]:
        """One request: status, headers, text."""
        one = http.client.HTTPConnection(self.name, self.port)
        one.sock = self.line()
        try:
            one.request(method, path, body, {"Cookie": self.cookie, **headers})
            got = one.getresponse()
            text = got.read().decode()
        finally:
            one.close()
        for said in got.headers.get_all("Set-Cookie", []):
            name, _, value = said.partition(";")[0].partition("=")
            self.cookies[name] = value
        return got.status, got.headers, text

    def join(self, code: str, name: str) -> http.client.HTTPMessage:
        """Come in by the code; the headers of the answer."""
        form = "application/x-www-form-urlencoded"
        body = urlencode({"code": code, "name": name})
        status, headers, text = self.ask(
            "/join", "POST", body, **{"Content-Type": form, "Origin": self.base}
        )
        assert status == 303, text
        return headers

    def listen(self, path: str, events: int) -> list[str]:
        """So many events of a stream."""
        one = http.client.HTTPConnection(self.name, self.port)
        one.sock = self.line()
        found: list[str] = []
        try:
            one.request("GET", path, headers={"Cookie": self.cookie})
            got = one.getresponse()
            while len(found) < events:
                line = got.readline().decode()
                assert line
                found += [line.removeprefix("data: ")] if line.startswith("data: ") else []
        finally:
            one.close()
        return found

    def connect(self, path: str = "/") -> ClientConnection:
        """A websocket as viser's page opens it, introduced."""
        plain = socket.create_connection(("127.0.0.1", self.port), BUSY)
        line = connect(
            f"wss://{self.name}:{self.port}{path}",
            sock=plain,
            ssl=ssl.create_default_context(cafile=str(self.trusted)),
            subprotocols=[PROTOCOL],  # type: ignore[list-item]
            additional_headers={"Cookie": self.cookie},
            origin=self.base,  # type: ignore[arg-type]
            max_size=None,
            open_timeout=BUSY,
        )
        line.send(msgspec.msgpack.encode(CAMERA))
        return line
