"""A request as it comes in: who it is from, and whether it may be answered at all."""

from __future__ import annotations

import asyncio
import json
from collections import Counter
from typing import Any
from urllib.parse import parse_qsl

from aiohttp import web
from websockets.datastructures import Headers
from websockets.http11 import Request

from app.front.client_addresses import RateLimit, address_of
from app.front.kinds import LARGEST
from app.front.origin import AllowedHost
from app.front.page_front import refusal
from worlds.input_error import InputError

# What one student's pages may send, however many they are.

REQUESTS = (10.0, 60.0)
"""Requests by HTTP, a second and at once: a page loads ten files, its gallery twenty pictures."""
PAGES = (1.0, 8.0)
"""Pages that connect, a second and at once."""
MOST_PAGES = 4
"""Pages of one student at a time."""
MOST_STREAMS = 8
"""Lines of one student over which the class tells what has changed: pages that are loaded again
leave theirs behind for a while."""
MOST_AT_ONCE = 32
"""Requests of one student that are being answered: whoever reads no answer has it wait here."""
FRAMES = (200.0, 400.0)
"""Messages, a second and at once: a page that drags sends some 60."""
BYTES = (256.0 * 1024, 1.5 * LARGEST)
"""Bytes of messages, a second and at once: a file that is opened comes at once."""
WORDS = (1.0, 5.0)
"""Things that a student hands in, a second and at once."""
STRANGERS = (5.0, 60.0)
"""Wrong codes that are tried from one address, a second and at once. The right one is always taken:
a class comes through one router or one proxy, and nobody there may lock out the others."""
JOINS = (5.0, 250.0)
"""Students who come in, a second and at once: a whole class does within a minute."""


class StudentLimits:
    """Of one student, or of the teacher."""

    def __init__(self) -> None:
        self.requests = RateLimit(*REQUESTS)
        self.pages = RateLimit(*PAGES)
        self.frames = RateLimit(*FRAMES)
        self.bytes = RateLimit(*BYTES)
        self.words = RateLimit(*WORDS)
        self.streams = self.going = 0
        """Lines that tell of the class, and requests that are being answered."""


# The connections of a class: how many there are of each address, and which of them make room.

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


MARK, WORD = "X-Flockscope", "class"
"""A header that no foreign page can send: a browser would ask first whether it may."""
READING = ("GET", "HEAD")
"""The methods that only read: HEAD is answered as GET is, without a body."""
LARGEST_BODY = 64 * 1024
"""Bytes of what a page sends by POST."""
COMES = 10.0
"""Seconds that it may take to come."""
FORM, FIELDS = "application/x-www-form-urlencoded", 8
"""How our forms are sent, and fields of one at most."""


def refused(request: web.Request, allow: tuple[AllowedHost, ...]) -> web.Response | None:
    """What a request gets that is not our own page's; None for one that may be answered."""
    headers = Headers([(name, value) for name, value in request.headers.items()])
    found = refusal(Request(request.raw_path, headers), allow)
    if found is None:
        return None
    return web.Response(status=found.status_code, body=found.body, content_type="text/plain")


async def text_of(request: web.Request) -> str:
    """What was sent with a request, as text. Raises InputError, and HTTPRequestTimeout."""
    try:
        async with asyncio.timeout(COMES):
            sent = await request.read()
        return sent.decode()
    except TimeoutError:
        raise web.HTTPRequestTimeout(text="what was sent did not come\n") from None
    except ValueError:
        raise InputError("what was sent is no text") from None


async def form_of(request: web.Request) -> dict[str, str]:
    """What a form of ours sends. Raises InputError."""
    if request.content_type != FORM:
        raise InputError("what was sent is no form")
    try:
        return dict(parse_qsl(await text_of(request), max_num_fields=FIELDS))
    except ValueError:
        raise InputError("what was sent is no form") from None


async def values_of(request: web.Request) -> dict[str, Any]:
    """What a page of ours sends, as JSON. Raises InputError, and HTTPForbidden for any other
    page."""
    if request.headers.getall(MARK, []) != [WORD]:
        raise web.HTTPForbidden(text=f"this is asked with the header {MARK}: {WORD}\n")
    try:
        values = json.loads(await text_of(request))
    except (ValueError, RecursionError):
        raise InputError("what was sent is no JSON") from None
    if not isinstance(values, dict):
        raise InputError("what was sent is no table of values")
    return values


def text_in(values: dict[str, Any], key: str, longest: int = 200) -> str:
    """A text among the values. Raises InputError."""
    found = values.get(key)
    if not isinstance(found, str) or len(found) > longest:
        raise InputError(f"{key} is to be a text of at most {longest} letters")
    return found


def numbers_in(values: dict[str, Any], key: str, most: int = 1000) -> list[int] | None:
    """Whole numbers among the values; None if they are left out. Raises InputError."""
    found = values.get(key)
    if found is None:
        return None
    if not isinstance(found, list) or len(found) > most or any(type(n) is not int for n in found):
        raise InputError(f"{key} is to be a list of whole numbers")
    return found
