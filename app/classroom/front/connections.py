"""The connections of a class: how many there are of each address."""

from __future__ import annotations

import asyncio
from collections import Counter
from typing import Any

from aiohttp import web

from app.viewer.web.incoming.visitors import address_of

MOST = 2048
"""Open connections in all: of a class of forty some two hundred."""
MOST_OF_ONE = 1024
"""Open connections of one address: a class behind one router has one."""


class Connections:
    """Counts them, and ends at once those that are too many."""

    def __init__(self, server: web.Server):
        self.server = server
        self.open: dict[Any, str] = {}
        self.of: Counter[str] = Counter()
        self.made, self.lost = server.connection_made, server.connection_lost
        server.connection_made = self.connection_made  # type: ignore[method-assign]
        server.connection_lost = self.connection_lost  # type: ignore[method-assign]

    def connection_made(self, handler: Any, transport: asyncio.Transport) -> None:
        """Take a connection, or end it."""
        self.made(handler, transport)
        address = address_of(transport.get_extra_info("peername"))
        if len(self.open) >= MOST or self.of[address] >= MOST_OF_ONE:
            transport.abort()
            return
        self.open[handler] = address
        self.of[address] += 1

    def connection_lost(self, handler: Any, exc: BaseException | None = None) -> None:
        """A connection is gone."""
        self.lost(handler, exc)
        address = self.open.pop(handler, None)
        if address is not None:
            self.of[address] -= 1
            if not self.of[address]:
                del self.of[address]
