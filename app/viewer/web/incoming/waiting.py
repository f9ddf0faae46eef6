"""Pages that connect wait for their turn."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from websockets.http11 import Request, Response


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
