"""What a student is answered whose flock runs in their browser: the page, and what runs in it."""

from __future__ import annotations

import gzip
import re

from aiohttp import web

from app.classroom.classroom import Classroom
from app.classroom.front.entrance import THEME, own_page
from app.classroom.student import Student
from app.classroom.workers.page_worker import MODULES
from app.front.http_server import POLICY, READING, UNFRAMED, Request, is_websocket
from app.front.page_front import PAGES
from worlds.input_error import InputError

MODULE = re.compile(rf"/{MODULES}([0-9a-f]{{32}})\.wasm")
KEPT = {"Cache-Control": "private, max-age=43200, immutable"}
"""Of a module: its name says what is in it."""


class StudentPages:
    """Answers them, for a class whose flocks run in browsers."""

    def __init__(self, classroom: Classroom):
        self.classroom = classroom

    async def answer(self, request: Request, student: Student) -> web.Response:
        """What a student is answered who has a flock of their own."""
        pages = self.classroom.pages
        if pages is None or is_websocket(request):
            raise web.HTTPNotFound(text="there is no such page\n")
        if request.method not in READING:
            raise web.HTTPMethodNotAllowed(request.method, READING)
        found = MODULE.fullmatch(request.path)
        if found is not None and found[1] in pages.modules:
            return packed_response(request, pages.modules[found[1]], "application/wasm", KEPT)
        if request.path not in PAGES:
            raise web.HTTPNotFound(text="there is no such page\n")
        if pages.is_waiting(student):
            return waiting_page(self.classroom.title, "Your flock is made ready …", "")
        try:
            page = await self.classroom.page_of(student)
        except InputError as refusal:
            words = f"There is no flock for you yet: {refusal}"
            return waiting_page(self.classroom.title, words, pages.flock_of(student))
        policy = f"{page.policy}; frame-ancestors {UNFRAMED}"
        return packed_response(request, page.html, "text/html", {POLICY: policy})


def waiting_page(title: str, words: str, flock: str) -> web.Response:
    """What a student sees until there is another flock than `flock`; it goes on by itself."""
    page = own_page("wait.html", (THEME, "classroom/wait.js"))
    text = page.filled(title=title, words=words, flock=flock)
    return web.Response(text=text, content_type="text/html", headers={POLICY: page.policy()})


def packed_response(
    request: Request, packed: bytes, kind: str, headers: dict[str, str]
) -> web.Response:
    """What is packed by gzip, as the browser takes it."""
    headers = headers | {"Vary": "Accept-Encoding"}
    is_taken = "gzip" in ",".join(request.headers.getall("Accept-Encoding", []))
    if is_taken:
        headers["Content-Encoding"] = "gzip"
    charset = "utf-8" if kind.startswith("text/") else None
    body = packed if is_taken else gzip.decompress(packed)
    return web.Response(body=body, content_type=kind, charset=charset, headers=headers)
