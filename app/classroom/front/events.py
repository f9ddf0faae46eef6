"""Tells a page what has changed, as it changes: events that a server sends."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import Any

from aiohttp import web

from app.classroom.classroom import Classroom

APART = 0.25
"""Seconds between two events at least."""
ALIVE = 15.0
"""Seconds after which a page is told that nothing has changed, so that proxies keep the line."""


async def stream(
    request: web.Request, classroom: Classroom, told: Callable[[], Any]
) -> web.StreamResponse:
    """An endless answer: `told()` as JSON now, and whenever it has become another."""
    response = web.StreamResponse(headers={"Content-Type": "text/event-stream"})
    await response.prepare(request)
    changed = asyncio.Event()
    classroom.listeners.add(changed.set)
    before = None
    try:
        while True:
            changed.clear()
            now = json.dumps(told())
            if now != before:
                before = now
                await response.write(f"data: {now}\n\n".encode())
            await asyncio.sleep(APART)
            try:
                async with asyncio.timeout(ALIVE):
                    await changed.wait()
            except TimeoutError:
                await response.write(b": nothing new\n\n")
    except (ConnectionError, asyncio.CancelledError):
        pass
    finally:
        classroom.listeners.discard(changed.set)
    return response
