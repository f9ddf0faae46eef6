"""A connection to one browser, which no browser can make dear."""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import Callable, Mapping
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.frames import CloseCode, Frame
from websockets.http11 import Response
from websockets.protocol import OPEN, Event

from app.front.client_addresses import ClientAddresses, RateLimit, address_of
from app.front.kinds import (
    CAMERA,
    KINDS,
    KNOWN,
    LARGEST,
    LONGEST,
    RENDER,
    Kind,
    UnusableMessage,
    demand_shape,
    kind_of,
)
from app.front.log import Log
from app.front.renders import Renders
from app.front.waiting import Admission, MessageNotifier, in_turn

# Which messages of one connection are let through, looked at before viser decodes them.

ALL = (500.0, 1000.0)
"""Frames of any kind, a second and at once; more ends a connection."""
BYTES = (1024.0 * 1024, 2.0 * LARGEST)
"""Bytes, a second and at once; more ends a connection."""
DROPPED = (30.0, 300.0)
"""Messages that are dropped, a second and at once; more ends a connection."""
UNUSABLE = 5.0
"""As many dropped messages does one count that nobody can use."""
TOO_MUCH = "more messages than anybody can mean"


class Messages:
    """Judges the messages of one connection; used by viser's thread.

    `shared` is a limit that all connections of an address have in common; `log` gets a line for a
    message that nobody can use; `expected` knows the answers that were asked for; `kinds` are the
    kinds that may be passed on.
    """

    def __init__(
        self,
        shared: RateLimit,
        log: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
        expected: Callable[[bytes], bool] = lambda _: False,
        kinds: Mapping[str, Kind] = KINDS,
    ):
        self.shared = shared
        self.expected = expected
        self.log = log
        self.frames = RateLimit(*ALL, clock)
        self.bytes = RateLimit(*BYTES, clock)
        self.dropped = RateLimit(*DROPPED, clock)
        self.kinds = {name: RateLimit(kind.rate, kind.most, clock) for name, kind in kinds.items()}
        self.introduced = False
        """Whether the browser has sent its camera."""
        self.verdict = ""
        """Why the connection is to be ended; empty: it is not."""

    def arrive(self, size: int) -> None:
        """Count a frame of so many bytes."""
        if not (self.frames.take() and self.bytes.take(size)):
            self.verdict = self.verdict or TOO_MUCH

    def pass_on(self, data: bytes | str) -> bool:
        """Whether viser may have a message."""
        if self.verdict:
            return False
        try:
            return self.judge(data)
        except UnusableMessage as why:
            self.log(str(why))
            self.drop(UNUSABLE)
            return False

    def judge(self, data: bytes | str) -> bool:
        """Whether a message is allowed now. Raises Unusable."""
        if isinstance(data, str):
            raise UnusableMessage("it is text")
        kind = kind_of(data)
        limit = self.kinds.get(kind)
        if limit is None:
            if kind not in KNOWN:
                raise UnusableMessage("it is of no kind that there is")
            return self.drop()
        if not (self.introduced or kind == CAMERA):
            return self.drop()
        if not (limit.take() and self.shared.take()):
            return self.drop()
        demand_shape(kind, data)
        if kind == RENDER:
            if not self.expected(data):
                return self.drop()
            self.bytes.give_back(len(data))  # we asked for them
        self.introduced = True
        return True

    def drop(self, cost: float = 1.0) -> bool:
        """Count a message that is not passed on; a connection that goes on so is to be ended."""
        if not self.dropped.take(cost):
            self.verdict = self.verdict or TOO_MUCH
        return False


SLICE = 16 * 1024
"""Bytes that are taken apart before a look whether to go on: the line brings 256 KiB at once."""
FAREWELL = 0.5
"""Seconds that a browser has to read why it is cut off."""
REQUEST_LINE = re.compile(rb"([A-Z]{1,20}) (\S+) HTTP/1\.[01]\r?\n")
HELD = 64
"""Messages of one browser that are kept for a page that begins, beside its camera; no files."""
LONGEST_LINE = 8192
"""Bytes of a request line, as websockets has it."""


class Connection(ServerConnection):
    """What is too much is dropped before it is decoded; who goes on is cut off, with a word."""

    def __init__(
        self,
        *args: Any,
        visitors: ClientAddresses,
        log: Log,
        renders: Renders,
        kinds: Mapping[str, Kind],
        heard: MessageNotifier,
        admission: Admission,
        **options: Any,
    ):
        super().__init__(*args, **options)
        self.kinds = kinds
        self.heard = heard
        self.admission = admission
        self.visitors = visitors
        self.renders = renders
        self.log = log
        self.held: list[Any] = []
        """What viser gets once the page is whole; the browser's newest camera comes first."""
        self.cut_off = False
        self.method = ""
        """How it asks; empty until its request line is there."""
        self.line = b""
        """What there is of it so far."""

    def connection_made(self, transport: Any) -> None:
        self.address = address_of(transport.get_extra_info("peername"))
        shared = self.visitors.messages(self.address)
        self.messages = Messages(
            shared, self.complain, expected=self.renders.expects, kinds=self.kinds
        )
        super().connection_made(transport)

    def connection_lost(self, exc: Exception | None) -> None:
        self.visitors.leave(self.address)
        super().connection_lost(exc)

    def complain(self, why: str) -> None:
        """Say that a message cannot be used."""
        self.log.line(f"a message from {self.address} is dropped: {why}")

    async def handshake(self, process_request: Any = None, *args: Any, **options: Any) -> None:
        """Let a page in when it is its turn."""
        await super().handshake(in_turn(self.admitted, process_request), *args, **options)

    def admitted(self) -> float | Response:
        """Seconds until a page may connect, or what it is told instead."""
        wait = self.visitors.page(self.address)
        if wait is not None:
            return wait
        answer = self.respond(HTTPStatus.TOO_MANY_REQUESTS, "too many pages from one address\n")
        answer.headers["Retry-After"] = "10"
        return answer

    def data_received(self, data: bytes) -> None:
        if not self.method:
            self.line += data
            if b"\n" not in self.line and len(self.line) <= LONGEST_LINE:
                return
            data = self.as_get()
        for begin in range(0, len(data), SLICE):
            if self.cut_off:
                return
            super().data_received(data[begin : begin + SLICE])

    def as_get(self) -> bytes:
        """What has come, as a GET of HTTP/1.1 whatever it is: websockets closes the line upon all
        else without an answer. By `method` it is answered as what it is."""
        data, self.line = self.line, b""
        found = REQUEST_LINE.match(data)
        if found is None:
            self.method = "GET"
            return data  # what is no request gets no answer
        self.method = found[1].decode()
        return b"GET %b HTTP/1.1\r\n%b" % (found[2], data[found.end() :])

    def process_event(self, event: Event) -> None:
        if isinstance(event, Frame):
            if not self.cut_off:
                self.messages.arrive(len(event.data))
                self.end_if_told()
            if self.cut_off:
                return
        super().process_event(event)

    async def recv(self, decode: bool | None = None) -> Any:
        """The next message that viser may have; none before the page is there whole.

        viser calls a browser connected, and begins to call what is registered for browsers, at
        their first message: so it is here that they wait. What it sends them meanwhile they get.
        """
        while not self.admission.decided.done():
            await self.hold(decode)
        while True:
            if self.held:
                data = self.held.pop(0)
            else:
                data = await self.next_allowed(decode)
            if self.admission.decided.result():  # else the server closes: the next look says so
                self.heard.note(self.loop)
                return data

    async def next_allowed(self, decode: bool | None) -> Any:
        """The next message that its browser may send."""
        while True:
            data = await super().recv(decode)
            if self.messages.pass_on(data):
                return data
            self.end_if_told()

    async def hold(self, decode: bool | None) -> None:
        """Keep the next message until the page is whole, or return as soon as it is.

        Messages are judged as they come: left on the line, all would come at once later, and too
        many at once end a connection. Of cameras only the newest counts.
        """
        message = asyncio.create_task(self.next_allowed(decode))
        try:
            ends = (message, self.admission.decided)
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
            if not message.done():
                return
            data = message.result()
        finally:
            message.cancel()
            await asyncio.gather(message, return_exceptions=True)  # two cannot wait for a message
        if kind_of(data) == CAMERA:
            self.held[:1] = [data]
        elif len(self.held) <= HELD and len(data) <= LONGEST:
            self.held.append(data)
        else:
            self.messages.drop()
            self.end_if_told()

    def end_if_told(self) -> None:
        """Cut the connection off if its messages have been judged so."""
        why = self.messages.verdict
        if not why or self.cut_off:
            return
        self.cut_off = True
        self.visitors.cut(self.address)
        self.log.line(f"a browser at {self.address} is cut off: {why}")
        self.recv_messages.resume = lambda: None
        if self.protocol.state is OPEN:
            self.protocol.fail(CloseCode.POLICY_VIOLATION, why)
            self.send_data()
        self.transport.pause_reading()
        self.loop.call_later(FAREWELL, self.transport.abort)
