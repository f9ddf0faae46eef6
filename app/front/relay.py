"""Carries messages between a browser's page and the viser server that it is shown.

A page never speaks with viser itself: what it says is counted and looked at here first, and who
says too much is cut off with a word.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from contextlib import suppress
from typing import Any, Protocol

from aiohttp import WSCloseCode, WSMsgType, web
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException

from app.front.http_server import FAREWELL, Connection, Request, not_allowed, secure, text_response
from app.front.message_filter import CAMERA, LARGEST, LONGEST, MessageFilter, kind_of
from app.front.viser_internals import PROTOCOL

HEARTBEAT = 30.0
"""Seconds between two looks whether a page that says nothing is there still."""
TIMEOUT = 10.0
"""Seconds for viser to answer."""
WAITING = 4
"""Messages of viser's that wait here for a slow browser: more would be old when they are shown."""
HELD = 64
"""Messages of one browser that are kept for a page that begins, beside its camera; no files."""
DATA = (WSMsgType.BINARY, WSMsgType.TEXT)
NOT_THERE = "the flock is just beginning again"
FAMILY = PROTOCOL.rstrip("0123456789.")
"""How the protocols of all versions of viser begin."""


class IncomingMessages(Protocol):
    """What a page may say."""

    verdict: str
    """Why its line is to be closed; empty: it is not."""

    def count_bytes(self, size: int) -> None:
        """Count bytes as they come in."""

    def count_message(self) -> None:
        """Count a message or a ping."""

    def accepts(self, data: bytes | str) -> bool:
        """Whether viser may have a message."""


OpenLine = Callable[[], Awaitable[ClientConnection]]
"""Connects with viser. Raises OSError, TimeoutError, WebSocketException."""
Ending = Callable[[], Coroutine[Any, Any, Any]]
"""Returns when a line is to be closed."""


def connect_viser(address: str, **options: Any) -> connect:
    """A websocket to a viser server at an address, or on a socket that is given as `sock`."""
    return connect(
        address,
        subprotocols=[PROTOCOL],  # type: ignore[list-item]
        compression=None,
        max_size=None,
        max_queue=WAITING,
        ping_interval=None,  # it is on this machine: if it hangs, it is busy
        open_timeout=TIMEOUT,
        close_timeout=FAREWELL,
        proxy=None,
        user_agent_header=None,
        **options,
    )


class Admission:
    """Whether browsers may use what a server serves: not before all that they reach is there.

    A page registers what browsers reach one by one: whoever came in between would find a part of
    it, and what is missing could not be made up for. Any thread may decide, once.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop):
        self.loop = loop
        self.decided: asyncio.Future[bool] = loop.create_future()

    def decide(self, admits: bool) -> None:
        """Let in who waits, and all who come; or nobody any more, as the server closes."""
        with suppress(RuntimeError):  # the loop is closed, and nobody waits
            self.loop.call_soon_threadsafe(self.settle, admits)

    def settle(self, admits: bool) -> None:
        """On its loop."""
        if not self.decided.done():
            self.decided.set_result(admits)

    async def admits(self, timeout: float | None = None) -> bool:
        """Wait for the decision, at most `timeout` seconds; whether it may be used."""
        await asyncio.wait([self.decided], timeout=timeout)
        return self.decided.done() and self.decided.result()


class HeldMessages:
    """Gives viser what a browser says, once the page is whole; what it says before is kept.

    viser calls a browser connected, and begins to call what is registered for browsers, at their
    first message: so it is here that they wait. What viser sends them meanwhile they get. Messages
    are judged as they come: left on the line, all would come at once later, and too many at once
    end a connection. Of cameras only the newest counts.
    """

    def __init__(self, viser: ClientConnection, admission: Admission, incoming: MessageFilter):
        self.viser = viser
        self.admission = admission
        self.incoming = incoming
        self.held: list[bytes] = []
        """The browser's newest camera comes first."""
        self.sending = asyncio.Lock()
        """Held while messages are sent, so that those that were kept come before the next."""

    async def send(self, data: bytes) -> None:
        """Give viser a message, now or later."""
        if self.admission.decided.done():
            await self.release()
            await self.viser.send(data)
        elif kind_of(data) == CAMERA:
            self.held[:1] = [data]
        elif len(self.held) <= HELD and len(data) <= LONGEST:
            self.held.append(data)
        else:
            self.incoming.drop()

    async def release(self) -> None:
        """Give viser what has been kept."""
        async with self.sending:
            while self.held:
                await self.viser.send(self.held.pop(0))

    async def wait(self) -> None:
        """Release what is kept as soon as the page is whole; return if it never will be."""
        if await self.admission.admits():
            await self.release()
            await never()


async def never() -> None:
    """Of a line that nobody but the page or viser closes."""
    await asyncio.Event().wait()


def offered_protocols(request: Request) -> list[str]:
    """The protocols of viser's, of any version, that a page offers to speak."""
    offered = ",".join(request.headers.getall("Sec-WebSocket-Protocol", [])).split(",")
    return [one.strip() for one in offered if one.strip().startswith(FAMILY)]


async def relay(
    request: Request,
    open_line: OpenLine,
    incoming: IncomingMessages,
    ends: Ending = never,
    admission: Admission | None = None,
    cut: Callable[[str], object] = str,
    compress: bool = False,
) -> web.StreamResponse:
    """Connect a page with viser, until one of both goes, or `ends` returns.

    `incoming` decides what the page may say; nothing of it reaches viser before `admission` is
    decided. `cut` is told why a page is cut off. `compress`: deflate what is sent to the page:
    viser packs words alone, not the numbers of agents. On this machine that saves nothing.
    """
    if request.method != "GET":
        return not_allowed("a websocket is opened by GET", ("GET",))
    offered = offered_protocols(request)
    page = web.WebSocketResponse(
        protocols=offered[:1] if PROTOCOL not in offered else [PROTOCOL],
        max_msg_size=LARGEST,
        heartbeat=HEARTBEAT,
        timeout=FAREWELL,
        autoping=False,  # pings are counted
        compress=compress,
    )
    if not offered or not page.can_prepare(request).ok:
        return text_response(400, "this is no websocket of a page of ours")
    secure(page.headers)
    if PROTOCOL not in offered:
        await page.prepare(request)
        reason = f"Version mismatch. Server: {PROTOCOL.removeprefix(FAMILY)}"
        await page.close(code=WSCloseCode.PROTOCOL_ERROR, message=reason.encode())
        return page
    try:
        viser = await open_line()
    except (OSError, TimeoutError, WebSocketException):
        return text_response(503, NOT_THERE)
    try:
        await page.prepare(request)
        await carry(request, page, viser, incoming, ends, admission)
        if incoming.verdict:
            cut(incoming.verdict)
            await cut_off(request, page, incoming.verdict)
    finally:
        await viser.close()
        if page.prepared and not page.closed:
            await page.close(code=WSCloseCode.GOING_AWAY)
    return page


async def carry(
    request: Request,
    page: web.WebSocketResponse,
    viser: ClientConnection,
    incoming: IncomingMessages,
    ends: Ending,
    admission: Admission | None,
) -> None:
    """Carry messages in both directions until it is over."""
    too_much = asyncio.Event()

    def count(size: int) -> None:
        incoming.count_bytes(size)
        if incoming.verdict:
            too_much.set()

    send: Callable[[bytes], Awaitable[None]] = viser.send
    ways = [carry_to_page(viser, page), too_much.wait(), ends()]
    if admission is not None and isinstance(incoming, MessageFilter):
        held = HeldMessages(viser, admission, incoming)
        send = held.send
        ways.append(held.wait())
    line: Any = request.protocol
    if isinstance(line, Connection):
        line.on_bytes = count
    tasks = [asyncio.create_task(way) for way in (carry_to_viser(page, incoming, send), *ways)]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def carry_to_page(viser: ClientConnection, page: web.WebSocketResponse) -> None:
    """From viser to the page."""
    async for data in viser:
        if isinstance(data, bytes):
            await page.send_bytes(data)


async def carry_to_viser(
    page: web.WebSocketResponse,
    incoming: IncomingMessages,
    send: Callable[[bytes], Awaitable[None]],
) -> None:
    """From the page to viser, as far as it may."""
    with suppress(ConnectionClosed):
        async for message in page:
            if message.type is WSMsgType.ERROR:
                return
            incoming.count_message()
            if message.type is WSMsgType.PING:
                await page.pong(message.data)
            elif message.type in DATA and incoming.accepts(message.data):
                await send(message.data)
            if incoming.verdict:
                return


async def cut_off(request: Request, page: web.WebSocketResponse, why: str) -> None:
    """Close a page's line with a word; what it still sends is not read any more."""
    line: Any = request.protocol
    line.close()
    if request.transport is not None:
        request.transport.pause_reading()
    await page.close(code=WSCloseCode.POLICY_VIOLATION, message=why.encode())
