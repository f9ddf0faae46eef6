"""The connections of a class: how many there are of each address, and which of them make room."""

from __future__ import annotations

import asyncio
from collections import Counter
from typing import Any

from aiohttp import web

from app.front.client_addresses import address_of

MOST = 2048
"""Open connections in all: of a class of forty some two hundred."""
MOST_OF_ONE = 1024
"""Open connections of one address: a class behind one router has one."""


class Connections:
    """Counts them. One too many ends the one that has been silent longest, or itself.

    Otherwise whoever opens many and says nothing would keep out all at the same address.
    """

    def __init__(self, server: web.Server):
        self.server = server
        self.open: dict[Any, str] = {}
        self.idle: dict[Any, asyncio.Transport] = {}
        """Those that nothing is asked on now, the longest first."""
        self.of: Counter[str] = Counter()
        self.made, self.lost = server.connection_made, server.connection_lost
        server.connection_made = self.connection_made  # type: ignore[method-assign]
        server.connection_lost = self.connection_lost  # type: ignore[method-assign]

    def connection_made(self, handler: Any, transport: asyncio.Transport) -> None:
        """Take a connection, or end it."""
        self.made(handler, transport)
        address = address_of(transport.get_extra_info("peername"))
        if (len(self.open) >= MOST or self.of[address] >= MOST_OF_ONE) and not self.make_room(
            address if self.of[address] >= MOST_OF_ONE else None
        ):
            transport.abort()
            return
        self.open[handler] = address
        self.of[address] += 1
        self.idle[handler] = transport

    def make_room(self, address: str | None) -> bool:
        """End one that is silent, of an address or of any; whether there was one."""
        for handler, transport in self.idle.items():
            if address is None or self.open[handler] == address:
                self.forget(handler)
                transport.abort()
                return True
        return False

    def busy(self, handler: Any) -> None:
        """Something is asked on a connection."""
        self.idle.pop(handler, None)

    def rest(self, handler: Any, transport: asyncio.Transport | None) -> None:
        """It has been answered."""
        if handler in self.open and transport is not None:
            self.idle[handler] = transport

    def connection_lost(self, handler: Any, exc: BaseException | None = None) -> None:
        """A connection is gone."""
        self.lost(handler, exc)
        self.forget(handler)

    def forget(self, handler: Any) -> None:
        """Count a connection no more."""
        self.idle.pop(handler, None)
        address = self.open.pop(handler, None)
        if address is not None:
            self.of[address] -= 1
            if not self.of[address]:
                del self.of[address]
