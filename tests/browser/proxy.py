"""A reverse proxy as JupyterHub has one: it takes a prefix off the path and passes the rest on."""

from __future__ import annotations

import asyncio
import threading
from contextlib import suppress

PREFIX = "/user/ada/proxy/8080"


class Proxy:
    """Serves until left. `host`: what it says as `Host`; None passes on what the browser said."""

    def __init__(self, inner: int, host: str | None = None):
        self.inner = inner
        self.host = host
        self.port = 0
        self.loop = asyncio.new_event_loop()
        self.begun = threading.Event()
        self.thread = threading.Thread(target=lambda: self.loop.run_until_complete(self.serve()))

    def __enter__(self) -> Proxy:
        self.thread.start()
        assert self.begun.wait(10)
        return self

    def __exit__(self, *_: object) -> None:
        self.loop.call_soon_threadsafe(self.ended.set)
        self.thread.join()
        self.loop.close()

    async def serve(self) -> None:
        self.ended = asyncio.Event()
        server = await asyncio.start_server(self.passed_on, "127.0.0.1", 0)
        self.port = server.sockets[0].getsockname()[1]
        self.begun.set()
        await self.ended.wait()
        server.close()
        for task in asyncio.all_tasks(self.loop) - {asyncio.current_task()}:
            task.cancel()

    async def passed_on(self, near: asyncio.StreamReader, back: asyncio.StreamWriter) -> None:
        """One connection; the inner server ends it after each answer but a websocket."""
        with suppress(OSError, asyncio.IncompleteReadError, asyncio.CancelledError):
            head = (await near.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")
            if not head[0].startswith(f"GET {PREFIX}"):
                back.write(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n")
                back.close()
                return
            path = head[0].removeprefix(f"GET {PREFIX}")
            head[0] = f"GET {path if path.startswith('/') else '/' + path}"
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
