"""A request as it comes in: who it is from, and whether it may be answered at all."""

from __future__ import annotations

import asyncio
import json
from typing import Any
from urllib.parse import parse_qsl

from aiohttp import web
from websockets.datastructures import Headers
from websockets.http11 import Request

from app.front.origin import AllowedHost
from app.front.page_front import refusal
from worlds.input_error import InputError

MARK, WORD = "X-Flockscope", "class"
"""A header that no foreign page can send: a browser would ask first whether it may."""
READING = ("GET", "HEAD")
"""The methods that only read: HEAD is answered as GET is, without a body."""
LARGEST = 64 * 1024
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
