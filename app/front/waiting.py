"""Tells whoever draws that a browser has sent something, so that nobody has to look for it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

from websockets.http11 import Request, Response

# What waits on viser's loop: pages for their turn, and all that is asked of a page that begins.

BEGINS = 6.0
"""Seconds that a request waits for a page that begins; all has to be answered within 10."""


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

    async def admits(self, connection: Any, timeout: float | None = None) -> bool:
        """Wait for the decision, at most `timeout` seconds or until a connection is lost; whether
        it may be used."""
        if not self.decided.done():
            ends = (self.decided, connection.connection_lost_waiter)
            await asyncio.wait(ends, timeout=timeout, return_when=asyncio.FIRST_COMPLETED)
        return self.decided.done() and self.decided.result()


def in_turn(admitted: Callable[[], float | Response], answer: Any) -> Callable[..., Awaitable[Any]]:
    """`answer`, and for those who are to be connected after it, a wait."""

    async def answer_in_turn(connection: Any, request: Request) -> Response | None:
        response = answer(connection, request) if answer is not None else None
        if isinstance(response, Awaitable):
            response = await response
        if response is not None:
            return response
        wait = admitted()
        if isinstance(wait, Response):
            return wait
        gone, _ = await asyncio.wait([connection.connection_lost_waiter], timeout=wait)
        if gone:
            raise asyncio.CancelledError  # there is nobody to be answered
        return None

    return answer_in_turn


SOON = 0.002
"""Time from a message to its being told of, s: by then it has been carried out. Of many within it
one word is enough."""


class MessageNotifier:
    """Used by viser's thread; `tell` is called there."""

    def __init__(self, tell: Callable[[], None] = lambda: None):
        self.tell = tell
        self.waiting = False

    def note(self, loop: asyncio.AbstractEventLoop) -> None:
        """A message goes to viser now."""
        if not self.waiting:
            self.waiting = True
            loop.call_later(SOON, self.pass_on)

    def pass_on(self) -> None:
        """Tell of what has been carried out by now."""
        self.waiting = False
        self.tell()
