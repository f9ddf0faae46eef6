"""A server of a test, in a thread of its own."""

from __future__ import annotations

import asyncio
import threading
from typing import Self


class SideServer:
    """Serves until left; `serve` sets `port` and `begun`, and goes on until `ended`."""

    def __init__(self) -> None:
        self.port = 0
        self.loop = asyncio.new_event_loop()
        self.begun = threading.Event()
        self.ended = asyncio.Event()
        self.thread = threading.Thread(target=lambda: self.loop.run_until_complete(self.serve()))

    async def serve(self) -> None:
        raise NotImplementedError

    def __enter__(self) -> Self:
        self.thread.start()
        assert self.begun.wait(60)
        return self

    def __exit__(self, *_: object) -> None:
        self.loop.call_soon_threadsafe(self.ended.set)
        self.thread.join()
        self.loop.close()
