"""Passes requests and messages on between a page and the laboratory that it is shown.

Messages are not looked into, but for their kind while a flock is held. To the page they are
deflated: of what viser sends only words are packed, not the numbers of agents.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

import aiohttp
from aiohttp import web
from yarl import URL

from app.classroom.front.class_request import StudentLimits
from app.classroom.student import LaboratoryAddress
from app.front.kinds import CAMERA, LARGEST, UnusableMessage, kind_of
from app.front.viser_internals import PROTOCOL

HEARTBEAT = 30.0
"""Seconds between two looks whether a page that says nothing is there still."""
TIMEOUT = 10.0
"""Seconds for a laboratory to answer."""
MOST_ANSWER = 64 * 1024 * 1024
"""Bytes of an answer that is passed on: films are some megabytes."""
TOO_MUCH = "more than one page can mean to send"
PASSED_ON = ("X-Flockscope", "Accept", "Range", "If-None-Match")
"""Headers of a request that a laboratory is told."""
BROUGHT_BACK = ("Content-Type", "Content-Disposition", "Content-Range", "Accept-Ranges", "ETag")
"""Headers of its answer that the page is told."""
Heard = Callable[[bytes], bool]
"""Whether a message of the page's may be passed on."""
Ending = Callable[[], Coroutine[Any, Any, None]]
"""Returns when a connection is to be ended."""


async def never() -> None:
    """Of a connection that nobody but the page or the laboratory ends."""
    await asyncio.Event().wait()


def anything(_: bytes) -> bool:
    """Of whoever may say everything."""
    return True


def camera_alone(data: bytes) -> bool:
    """Of whoever is held."""
    try:
        return kind_of(data) == CAMERA
    except UnusableMessage:
        return False


class Relay:
    """Passes on, for all pages of a class; on one event loop."""

    def __init__(self) -> None:
        self.session = aiohttp.ClientSession(
            timeout=aiohttp.ClientTimeout(total=None, connect=TIMEOUT, sock_connect=TIMEOUT),
            connector=aiohttp.TCPConnector(limit=0),
            auto_decompress=False,
            cookie_jar=aiohttp.DummyCookieJar(),
        )

    async def close(self) -> None:
        """Pass nothing on any more."""
        await self.session.close()

    async def pass_on(
        self, request: web.Request, place: LaboratoryAddress, path: str
    ) -> web.Response:
        """What a laboratory answers to a request of a page's for `path`, with its query."""
        headers = {
            name: value for name in PASSED_ON if (value := request.headers.get(name)) is not None
        }
        url = URL(f"{place.address}{path}", encoded=True)
        try:
            async with self.session.get(url, headers=headers, allow_redirects=False) as answer:
                body = await answer.content.read(MOST_ANSWER + 1)
                while not answer.content.at_eof() and len(body) <= MOST_ANSWER:
                    body += await answer.content.read(MOST_ANSWER + 1 - len(body))
        except (aiohttp.ClientError, TimeoutError):
            return web.Response(status=503, text="the flock is just beginning again\n")
        if len(body) > MOST_ANSWER:
            return web.Response(status=502, text="the answer is too large for a class\n")
        brought = {name: answer.headers[name] for name in BROUGHT_BACK if name in answer.headers}
        return web.Response(status=answer.status, body=body, headers=brought)

    async def connect(
        self,
        request: web.Request,
        place: LaboratoryAddress,
        limits: StudentLimits,
        heard: Heard = anything,
        ends: Ending = never,
    ) -> web.WebSocketResponse:
        """Connect a page with a laboratory, until one of both goes or `ends` returns."""
        demand_websocket(request)
        page = web.WebSocketResponse(
            protocols=(PROTOCOL,),
            max_msg_size=LARGEST,
            heartbeat=HEARTBEAT,
            timeout=1.0,
            autoping=False,
        )
        try:
            inner = await self.session.ws_connect(
                f"{place.address}/",
                protocols=(PROTOCOL,),
                max_msg_size=0,
                compress=0,
                autoping=True,
            )
        except (aiohttp.ClientError, TimeoutError):
            raise web.HTTPServiceUnavailable(text="the flock is just beginning again\n") from None
        try:
            await page.prepare(request)
            ways = (
                asyncio.create_task(outward(inner, page)),
                asyncio.create_task(inward(page, inner, limits, heard)),
                asyncio.create_task(ends()),
            )
            try:
                await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for one in ways:
                    one.cancel()
                await asyncio.gather(*ways, return_exceptions=True)
        finally:
            await inner.close()
            if page.prepared and not page.closed:
                await page.close(code=aiohttp.WSCloseCode.GOING_AWAY)
        return page


def demand_websocket(request: web.Request) -> None:
    """Raises HTTPBadRequest for what is no websocket of viser's page of this version."""
    offered = request.headers.get("Sec-WebSocket-Protocol", "").split(",")
    if request.method != "GET" or PROTOCOL not in map(str.strip, offered):
        raise web.HTTPBadRequest(text="a websocket of another kind, or of a page of another time\n")


async def outward(inner: aiohttp.ClientWebSocketResponse, page: web.WebSocketResponse) -> None:
    """From the laboratory to the page."""
    async for message in inner:
        if message.type is aiohttp.WSMsgType.BINARY:
            await page.send_bytes(message.data)


async def inward(
    page: web.WebSocketResponse, inner: Any, limits: StudentLimits, heard: Heard
) -> None:
    """From the page to the laboratory, within limits."""
    async for message in page:
        if message.type is aiohttp.WSMsgType.ERROR:
            return
        if not (limits.frames.take() and limits.bytes.take(len(message.data or b""))):
            await page.close(code=aiohttp.WSCloseCode.POLICY_VIOLATION, message=TOO_MUCH.encode())
            return
        if message.type is aiohttp.WSMsgType.PING:
            await page.pong(message.data)
        elif message.type is aiohttp.WSMsgType.BINARY and heard(message.data):
            await inner.send_bytes(message.data)
