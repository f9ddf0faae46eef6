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
    """An answer without end: `told()` as JSON now, and whenever it has become another.

    It ends once it has said that the class is over, for all or for this page.
    """
    response = web.StreamResponse(headers={"Content-Type": "text/event-stream"})
    await response.prepare(request)
    if request.method == "HEAD":
        return response
    changed = asyncio.Event()
    classroom.listeners.add(changed.set)
    before = None
    try:
        while True:
            changed.clear()
            said = told()
            now = json.dumps(said)
            if now != before:
                before = now
                await response.write(f"data: {now}\n\n".encode())
                if said["over"]:
                    break
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
