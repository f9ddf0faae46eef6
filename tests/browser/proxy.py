"""A reverse proxy as JupyterHub has one: it takes a prefix off the path and passes the rest on."""

from __future__ import annotations

import asyncio
from contextlib import suppress

from tests.browser.side_server import SideServer

PREFIX = "/user/ada/proxy/8080"


class Proxy(SideServer):
    """Serves until left. `host`: what it says as `Host`; None passes on what the browser said."""

    def __init__(self, inner: int, host: str | None = None):
        super().__init__()
        self.inner = inner
        self.host = host

    async def serve(self) -> None:
        server = await asyncio.start_server(self.passed_on, "127.0.0.1", 0)
        self.port = server.sockets[0].getsockname()[1]
        self.begun.set()
        await self.ended.wait()
        server.close()
        for task in asyncio.all_tasks(self.loop) - {asyncio.current_task()}:
            task.cancel()

    async def passed_on(self, near: asyncio.StreamReader, back: asyncio.StreamWriter) -> None:
        """One connection, which the inner server is asked to end after the answer."""
        with suppress(OSError, asyncio.IncompleteReadError, asyncio.CancelledError):
            head = (await near.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")
            if not head[0].startswith(f"GET {PREFIX}"):
                back.write(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")
                back.close()
                return
            path = head[0].removeprefix(f"GET {PREFIX}")
            head[0] = f"GET {path if path.startswith('/') else '/' + path}"
            if not any(one.lower().startswith("upgrade:") for one in head):
                rest = [one for one in head[1:] if not one.lower().startswith("connection:")]
                head = [head[0], "Connection: close", *rest]
            if self.host is not None:
                rest = [one for one in head if not one.lower().startswith("host:")]
                head = [rest[0], f"Host: {self.host}", *rest[1:]]
            far, on = await asyncio.open_connection("127.0.0.1", self.inner)
            on.write("\r\n".join(head).encode("latin-1"))
            await asyncio.gather(copied(near, on), copied(far, back))


async def copied(near: asyncio.StreamReader, far: asyncio.StreamWriter) -> None:
    """Pass on what comes, to its end."""
    with suppress(OSError):
        while part := await near.read(65536):
            far.write(part)
            await far.drain()
    far.close()
