"""The door: takes all connections, in a thread of its own.

What is an emergency stop is carried out here, at once; everything else is passed on to viser's
thread, each address in its turn. So a stop waits for none of viser's work, and no more than a
moment for the door's: that looks at one byte of every connection.
"""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import io
import socket
import threading
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any

from websockets.datastructures import Headers
from websockets.http11 import Request

from app.front.client_addresses import ClientAddresses, address_of
from app.front.origin import AllowedHost
from app.front.page_front import METHODS, refusal, secure
from app.front.viser_internals import LoopEvent
from app.front.waiting import BEGINS

# The emergency stop as a request of its own, beside viser's messages.
#
# Any page of ours sends it, and so may a program on this machine or a button on the wall:
#
#     curl -X POST -H 'X-Flockscope: stop' http://localhost:8080/emergency

PATH = "/emergency"
MARK, WORD = "X-Flockscope", "stop"
"""A header that no foreign page can send: a browser would ask first whether it may."""
NOT_ALLOWED = "only GET and HEAD, and POST of an emergency stop"
LONGEST = 8 * 1024
"""Bytes of a request."""


@dataclass(frozen=True)
class StopReply:
    """What a request comes to."""

    status: HTTPStatus
    words: str = ""
    stops: bool = False

    def to_bytes(self) -> bytes:
        """As it is sent."""
        body = f"{self.words}\n".encode() if self.words else b""
        headers = Headers({"Content-Type": "text/plain; charset=utf-8"})
        headers["Content-Length"] = str(len(body))
        headers["Connection"] = "close"
        secure(headers)
        if self.status is HTTPStatus.METHOD_NOT_ALLOWED:
            headers["Allow"] = ", ".join((*METHODS, "POST"))
        line = f"HTTP/1.1 {self.status.value} {self.status.phrase}\r\n"
        return line.encode() + headers.serialize() + body


def answered(head: bytes, stops: bool, allow: tuple[AllowedHost, ...] = ()) -> StopReply:
    """What to do with a request, of which `head` is all up to the empty line.

    `stops` says whether there is anything to stop here; `allow` are names by which it may be
    reached beside this machine's own.
    """
    first, _, rest = head.partition(b"\r\n")
    try:
        method, path, version = first.decode("ascii").split(" ")
        found = http.client.parse_headers(io.BytesIO(rest))
    except (ValueError, http.client.HTTPException):
        return StopReply(HTTPStatus.BAD_REQUEST, "this is no request")
    if method != "POST" or not version.startswith("HTTP/1."):
        return StopReply(HTTPStatus.METHOD_NOT_ALLOWED, NOT_ALLOWED)
    if path != PATH or not stops:
        return StopReply(HTTPStatus.NOT_FOUND, "there is nothing to stop here")
    headers = Headers([(name, str(value)) for name, value in found.items()])
    refused = refusal(Request(path, headers), allow)
    if refused is not None:
        return StopReply(HTTPStatus(refused.status_code), refused.body.decode().strip())
    if found.get_all(MARK) != [WORD]:
        return StopReply(HTTPStatus.FORBIDDEN, f"an emergency stop needs the header {MARK}: {WORD}")
    return StopReply(HTTPStatus.NO_CONTENT, stops=True)


UNDECIDED = 256
"""Connections that have not said yet what they want; one more ends the oldest."""
SILENT = 10.0
"""Seconds that they have to say it."""
HEAD = 3.0
"""Seconds that a stop has to arrive whole."""
NO_ROOM = 0.05
"""Seconds until the next try where this machine has no room for another connection."""
Stop = Callable[[str], None]
"""Stops the cars; is told by whom."""
Inside = Callable[[socket.socket], Awaitable[Any]]
"""Takes a connection in, on viser's loop."""


class ConnectionAcceptor:
    """Takes connections on a socket that listens, until closed.

    `allow` are names by which this machine may be reached beside its own; `stop` is what an
    emergency stop comes to, None where there is nothing to stop.
    """

    def __init__(
        self,
        listening: socket.socket,
        inside: Inside,
        loop: asyncio.AbstractEventLoop,
        visitors: ClientAddresses,
        allow: tuple[AllowedHost, ...] = (),
        stop: Stop | None = None,
    ):
        self.listening = listening
        self.inside = inside
        self.inner = loop
        self.visitors = visitors
        self.allow = allow
        self.stop = stop
        self.undecided: dict[socket.socket, asyncio.Task[None]] = {}
        self.passing: set[Any] = set()
        self.loop = asyncio.new_event_loop()
        self.settled = LoopEvent(self.loop)
        """Set once it is known whether there is anything to stop: a stop waits for that."""
        self.thread = threading.Thread(target=self.stand, name="door", daemon=True)
        self.thread.start()

    def close(self, wait: float = 2.0) -> None:
        """Take no more connections."""
        with contextlib.suppress(RuntimeError):  # closed already
            self.loop.call_soon_threadsafe(self.ending.cancel)
        self.thread.join(wait)

    def stand(self) -> None:
        """The door's thread."""
        self.ending = self.loop.create_task(self.take())
        with contextlib.suppress(asyncio.CancelledError):
            self.loop.run_until_complete(self.ending)
        for task in asyncio.all_tasks(self.loop):
            task.cancel()
        self.loop.run_until_complete(asyncio.sleep(0))
        for line in self.undecided:
            line.close()
        self.loop.close()

    async def take(self) -> None:
        """Take connections."""
        while True:
            try:
                line, peer = await self.loop.sock_accept(self.listening)
            except OSError:  # no room, or it was gone before it was taken
                await asyncio.sleep(NO_ROOM)
                self.end_oldest()
                continue
            if len(self.undecided) >= UNDECIDED:
                self.end_oldest()
            self.undecided[line] = self.loop.create_task(self.welcome(line, address_of(peer)))

    def end_oldest(self) -> None:
        """Make room."""
        oldest = next(iter(self.undecided), None)
        if oldest is not None:
            self.undecided.pop(oldest).cancel()

    async def welcome(self, line: socket.socket, address: str) -> None:
        """Find out what a connection wants, and see to it."""
        passed_on = False
        try:
            async with asyncio.timeout(SILENT):
                first = await self.first_byte(line)
            if first == b"P":  # of POST; what viser's thread serves is asked for by GET
                await self.attend(line, address)
            elif first:
                passed_on = await self.pass_on(line, address)
        except (OSError, TimeoutError, asyncio.CancelledError):
            pass
        finally:
            self.undecided.pop(line, None)
            if not passed_on:
                line.close()

    async def first_byte(self, line: socket.socket) -> bytes:
        """The first byte, which stays where it is; empty if none will come."""
        line.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            return line.recv(1, socket.MSG_PEEK)
        arrived = asyncio.Event()
        self.loop.add_reader(line, arrived.set)
        try:
            await arrived.wait()
        finally:
            self.loop.remove_reader(line)
        return line.recv(1, socket.MSG_PEEK)

    async def attend(self, line: socket.socket, address: str) -> None:
        """Carry out an emergency stop, or say why not."""
        async with asyncio.timeout(HEAD):
            head = b""
            while b"\r\n\r\n" not in head and len(head) < LONGEST:
                more = await self.loop.sock_recv(line, LONGEST)
                if not more:
                    return
                head += more
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(BEGINS):
                await self.settled.wait()
        whole = head.partition(b"\r\n\r\n")[0] + b"\r\n\r\n"
        answer = answered(whole, self.stop is not None, self.allow)
        if answer.stops and self.stop is not None:
            self.stop(f"browser at {address}")
        async with asyncio.timeout(HEAD):
            await self.loop.sock_sendall(line, answer.to_bytes())

    async def pass_on(self, line: socket.socket, address: str) -> bool:
        """Pass a connection on to viser's thread, when it is its turn."""
        wait = self.visitors.enter(address)
        if wait is None:
            return False
        try:
            await asyncio.sleep(wait)
            passing = asyncio.run_coroutine_threadsafe(self.taken_in(line, address), self.inner)
        except BaseException:
            self.visitors.leave(address)
            raise
        self.passing.add(passing)
        passing.add_done_callback(self.passing.discard)
        return True

    async def taken_in(self, line: socket.socket, address: str) -> None:
        """On viser's loop: from here on the connection is viser's."""
        try:
            await self.inside(line)
        except BaseException:
            self.visitors.leave(address)
            line.close()
            raise
