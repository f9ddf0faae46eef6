"""A request as it comes in: who it is from, and whether it may be answered at all."""

from __future__ import annotations

import asyncio
import json
import math
from contextlib import suppress
from typing import Any
from urllib.parse import parse_qsl

from aiohttp import web

from app.classroom.student import Student
from app.front.client_addresses import ConnectionLimits, RateLimit
from app.front.http_server import Request
from app.front.message_filter import CAMERA, LARGEST, TOO_MUCH, UnusableMessage, kind_of
from app.viewer.gallery.scene_steps import MOST_CHOICES, MOST_STEPS
from worlds.input_error import InputError, shorten

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
MESSAGES = (200.0, 400.0)
"""Messages, a second and at once: a page that drags sends some 60."""
BYTES = (256.0 * 1024, 1.5 * LARGEST)
"""Bytes of messages, a second and at once: a file that is opened comes at once."""
PREDICTIONS = (2.0, 2.0 * MOST_STEPS)
"""Predictions of a student's pages, per second and at once: one as it is made and one as its run
ends, in each step. They cost far less than a run that is handed in."""
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
        self.messages = RateLimit(*MESSAGES)
        self.bytes = RateLimit(*BYTES)
        self.words = RateLimit(*WORDS)
        self.predictions = RateLimit(*PREDICTIONS)
        self.streams = self.going = 0
        """Lines that tell of the class, and requests that are being answered."""


class StudentMessages:
    """What one page of a student, or of the teacher, may say; nobody else is held to a flock that
    the teacher holds."""

    def __init__(self, limits: StudentLimits, student: Student | None = None):
        self.limits = limits
        self.student = student
        self.verdict = ""

    def count_bytes(self, size: int) -> None:
        """Count bytes as they come in."""
        if not self.limits.bytes.take(size):
            self.verdict = TOO_MUCH

    def count_message(self) -> None:
        """Count a message or a ping."""
        if not self.limits.messages.take():
            self.verdict = TOO_MUCH

    def accepts(self, data: bytes | str) -> bool:
        """Whether the laboratory may have a message; of whoever is held, only the camera."""
        if isinstance(data, str):
            return False
        if self.student is None or not self.student.frozen:
            return True
        try:
            return kind_of(data) == CAMERA
        except UnusableMessage:
            return False


# How many lines there are of a class, of all and of one address.

LIMITS = ConnectionLimits(
    silent=2048,
    open=2048,
    open_of_one=1024,
    requests=(1000.0, 3000.0),
)
"""Of a class of forty there are some two hundred lines, all from one router."""


MARK, WORD = "X-Flockscope", "class"
"""A header that no foreign page can send: a browser would ask first whether it may."""
COMES = 10.0
"""Seconds that it may take to come."""
FORM, FIELDS = "application/x-www-form-urlencoded", 8
"""How our forms are sent, and fields of one at most."""


async def text_of(request: Request) -> str:
    """What was sent with a request, as text. Raises InputError, and HTTPRequestTimeout."""
    try:
        async with asyncio.timeout(COMES):
            sent = await request.read()
        return sent.decode()
    except TimeoutError:
        raise web.HTTPRequestTimeout(text="what was sent did not come\n") from None
    except ValueError:
        raise InputError("what was sent is no text") from None


async def form_of(request: Request) -> dict[str, str]:
    """What a form of ours sends. Raises InputError."""
    if request.content_type != FORM:
        raise InputError("what was sent is no form")
    try:
        return dict(parse_qsl(await text_of(request), max_num_fields=FIELDS))
    except ValueError:
        raise InputError("what was sent is no form") from None


async def values_of(request: Request) -> dict[str, Any]:
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


MOST_VALUES = 8
"""Sliders of a page."""


def slider_values_in(values: dict[str, Any], key: str) -> dict[str, float]:
    """Finite numbers by name among the values; none if they are left out. Raises InputError."""
    found = values.get(key, {})
    if not isinstance(found, dict) or len(found) > MOST_VALUES:
        raise InputError(f"{key} is to be a table of at most {MOST_VALUES} numbers")
    return {name: finite_number(name, value) for name, value in found.items()}


def finite_number(name: str, value: object) -> float:
    """A number that a page sends. Raises InputError."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        with suppress(OverflowError):
            if math.isfinite(value):
                return float(value)
    raise InputError(f"{shorten(name)} = {shorten(value)} is not a finite number")


def step_number_in(values: dict[str, Any], key: str) -> int:
    """The number of a step of a lesson among the values; 0 where it is left out. Raises
    InputError."""
    found = values.get(key, 0)
    if type(found) is not int or not 0 <= found <= MOST_STEPS:
        raise InputError(
            f"{key} = {shorten(found)} is not allowed: a number from 0 to {MOST_STEPS}"
        )
    return found


def choice_in(values: dict[str, Any], key: str) -> int | None:
    """The place of a choice among the values, from 0; None where it is left out. Raises
    InputError."""
    found = values.get(key)
    if found is not None and (type(found) is not int or not 0 <= found < MOST_CHOICES):
        raise InputError(
            f"{key} = {shorten(found)} is not allowed: a number from 0 to {MOST_CHOICES - 1}"
        )
    return found


def numbers_in(values: dict[str, Any], key: str, most: int = 1000) -> list[int] | None:
    """Whole numbers among the values; None if they are left out. Raises InputError."""
    found = values.get(key)
    if found is None:
        return None
    if not isinstance(found, list) or len(found) > most or any(type(n) is not int for n in found):
        raise InputError(f"{key} is to be a list of whole numbers")
    return found
