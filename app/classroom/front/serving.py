"""Serves a class: one address, one port, and nothing for who has neither code nor cookie."""

from __future__ import annotations

import asyncio
import re
import secrets
from collections import defaultdict
from pathlib import Path

import aiohttp
from aiohttp import web
from websockets.asyncio.client import ClientConnection
from yarl import URL

from app.classroom.classroom import Classroom
from app.classroom.flocks import TEACHER
from app.classroom.front.class_request import (
    LIMITS,
    MOST_AT_ONCE,
    MOST_PAGES,
    StudentLimits,
    StudentMessages,
)
from app.classroom.front.entrance import ClassEntrance
from app.classroom.front.student_pages import StudentPages
from app.classroom.front.student_requests import StudentRequests
from app.classroom.front.teacher_requests import TeacherRequests
from app.classroom.student import LaboratoryAddress, Role, Student
from app.front.client_addresses import ClientAddresses
from app.front.client_page import client_page
from app.front.http_server import (
    READING,
    HttpServer,
    Request,
    address_of_line,
    is_websocket,
    listen,
    load_certificate,
    send,
)
from app.front.log import Log, log_failures
from app.front.origin import AllowedHost, local_address, network_addresses
from app.front.page_front import ALIVE, PAGES, page_response, refusal, websocket_addresses
from app.front.relay import NOT_THERE, Ending, connect_viser, never, relay
from app.viewer.lab.scene_requests import MARK, SCRIPTS

CHANGES_OVER = 3.0
"""Seconds that a page has to change over by itself, after which its connection is ended."""
ANSWERS = 10.0
"""Seconds for a laboratory to be reached."""
MOST_ANSWER = 64 * 1024 * 1024
"""Bytes of an answer that is passed on: films are some megabytes."""
PASSED_ON = ("X-Flockscope", "Accept", "Range", "If-None-Match")
"""Headers of a request that a laboratory is told."""
BROUGHT_BACK = ("Content-Type", "Content-Disposition", "Content-Range", "Accept-Ranges", "ETag")
"""Headers of its answer that the page is told."""
PLAIN = re.compile(r"[\w./~-]+", re.ASCII)
"""The paths that a laboratory serves, none of which is encoded."""
STYLES = ("classroom/chart.css", "classroom/bar.css")
ENDED = "classroom/ended.js"
TEACHES = (ENDED, "classroom/wall.js", "classroom/teacher.js")
LEARNS = (ENDED, "classroom/chart.js", "classroom/student.js")
VISIT = ("classroom/visit.js",)
"""The scripts of a laboratory's page in a class, beside its own."""


class ClassFront:
    """What everybody reaches. Raises InputError if the port is busy or a certificate is
    unusable."""

    def __init__(
        self,
        classroom: Classroom,
        host: str = "127.0.0.1",
        port: int = 8080,
        allow: tuple[AllowedHost, ...] = (),
        certificate: tuple[Path, Path] | None = None,
    ):
        self.classroom = classroom
        self.allow = allow
        self.tls = None if certificate is None else load_certificate(*certificate)
        self.sock = listen(host, port)
        self.port: int = self.sock.getsockname()[1]
        self.name = secrets.token_hex(8)
        self.session: aiohttp.ClientSession
        self.visitors = ClientAddresses(limits=LIMITS)
        self.limits: dict[int, StudentLimits] = defaultdict(StudentLimits)
        self.entrance = ClassEntrance(classroom, self.port)
        self.log = Log()
        self.http = HttpServer(self.sock, self.answer, LIMITS.silent, self.log, self.tls)
        self.student = StudentRequests(classroom)
        self.pages = StudentPages(classroom)
        self.teacher = TeacherRequests(classroom, self.addresses(host))

    def addresses(self, host: str) -> list[str]:
        """Where others reach it, the likeliest first; where only this machine does, here."""
        plain = (80, self.port)
        named = [
            f"{self.scheme if one.port in plain else 'https'}://{one}" for one in self.allow
        ]  # at any other port there is a proxy, which encrypts
        found = network_addresses(host, self.port) or [local_address(host, self.port)]
        return [*named, *(one.replace("http:", f"{self.scheme}:", 1) for one in found)]

    async def open(self) -> None:
        """Serve, until closed."""
        log_failures(asyncio.get_running_loop(), self.log)
        self.session = aiohttp.ClientSession(
            timeout=aiohttp.ClientTimeout(total=None, connect=ANSWERS, sock_connect=ANSWERS),
            connector=aiohttp.TCPConnector(limit=0),
            auto_decompress=False,
            cookie_jar=aiohttp.DummyCookieJar(),
        )
        await self.http.open()

    async def close(self) -> None:
        """Serve no more."""
        await self.session.close()
        await self.http.close()

    @property
    def scheme(self) -> str:
        """How its address begins."""
        return "http" if self.tls is None else "https"

    @property
    def teachers_link(self) -> str:
        """What opens the teacher's page, for who starts the class alone."""
        at = local_address("127.0.0.1", self.port).replace("http:", f"{self.scheme}:", 1)
        return f"{at}/{self.classroom.key}"

    @property
    def opening_link(self) -> str:
        """What opens it once, for the browser that the command begins."""
        return f"{self.teachers_link.rpartition('/')[0]}/{self.classroom.first_key}"

    # Who asks for what.

    async def answer(self, request: Request) -> web.StreamResponse:
        """What a request is answered."""
        address = address_of_line(request)
        wait = self.visitors.enter(address)
        if wait is None:
            raise web.HTTPTooManyRequests(text="too many requests from one address\n")
        try:
            await asyncio.sleep(wait)
            return refusal(request, self.allow) or await self.answer_known(request)
        finally:
            self.visitors.leave(address)

    async def answer_known(self, request: Request) -> web.StreamResponse:
        """What is asked by whom we know; others are asked for the code."""
        classroom, path = self.classroom, request.path
        if classroom.is_over:
            return web.Response(status=410, text="this class is over\n")
        if request.method == "POST" and path in ("/join", "/teach"):
            return await self.entrance.come_in(request)
        is_teacher = self.entrance.is_teacher(request)
        student = self.entrance.student_of(request)
        welcome = self.entrance.welcome(request, is_teacher, student is not None)
        if welcome is not None:
            return welcome
        if is_teacher:
            return await self.answer_teacher(request)
        if student is not None:
            return await self.answer_student(request, student)
        return self.entrance.turn_away(request)

    async def answer_teacher(self, request: Request) -> web.StreamResponse:
        """What the teacher is answered."""
        limits = self.limits[TEACHER]
        if (found := await self.teacher.answer(request)) is not None:
            return found
        parts = request.path.split("/")
        if parts[1] == "at" and len(parts) > 2:
            student = self.classroom.student_at(parts[2])
            path = "/" + "/".join(parts[3:])
            visited = await self.classroom.place_of(student)
            return await self.show(request, visited, path, limits, VISIT)
        place = self.classroom.flocks.teacher
        if place is None:
            raise web.HTTPServiceUnavailable(text="your flock is just beginning\n")
        return await self.show(request, place, request.path, limits, TEACHES)

    async def answer_student(self, request: Request, student: Student) -> web.StreamResponse:
        """What a student is answered."""
        limits = self.limits[student.number]
        if not limits.requests.take():
            raise web.HTTPTooManyRequests(text="too many requests at once: wait a moment\n")
        if is_websocket(request) and not self.classroom.is_in_browser(student):
            return await self.connect_student(request, student, limits)
        if limits.going >= MOST_AT_ONCE + limits.streams:
            raise web.HTTPTooManyRequests(text="too many requests at once: wait a moment\n")
        limits.going += 1
        try:
            response = await self.answer_page(request, student, limits)
            await send(request, response)
        finally:
            limits.going -= 1
        return response

    async def answer_page(
        self, request: Request, student: Student, limits: StudentLimits
    ) -> web.StreamResponse:
        """What a student's page is answered that asks for something else than a line."""
        if (found := await self.student.answer(request, student, limits)) is not None:
            return found
        if MARK in request.headers and student.frozen and student.role is Role.OWN:
            raise web.HTTPForbidden(text="your flock is held by the teacher\n")
        if self.classroom.is_in_browser(student) and request.path != ALIVE:
            return await self.pages.answer(request, student)
        if request.path in (ALIVE, *PAGES):
            place = None
        else:
            place = await self.classroom.place_of(student)
        return await self.show(request, place, request.path, limits, LEARNS)

    async def connect_student(
        self, request: Request, student: Student, limits: StudentLimits
    ) -> web.StreamResponse:
        """A student's page connects with what it is shown."""
        place = await self.classroom.place_of(student)
        if student.lines >= MOST_PAGES or not limits.pages.take():
            raise web.HTTPTooManyRequests(text="too many pages of one student at once\n")
        self.classroom.connect(student)
        try:
            incoming = StudentMessages(limits, student)
            return await self.connect(request, place, incoming, self.changed_over(student))
        finally:
            self.classroom.disconnect(student)

    def changed_over(self, student: Student) -> Ending:
        """Returns some time after a student has been shown something else, or taken out.

        Our own page connects anew at once; one that does not keeps nothing of what it had.
        """
        role, other = student.role, asyncio.Event()

        def look() -> None:
            if (
                student.role is not role
                or self.classroom.students.get(student.number) is not student
            ):
                other.set()

        async def ends() -> None:
            self.classroom.listeners.add(look)
            try:
                look()
                await other.wait()
                await asyncio.sleep(CHANGES_OVER)
            finally:
                self.classroom.listeners.discard(look)

        return ends

    async def show(
        self,
        request: Request,
        place: LaboratoryAddress | None,
        path: str,
        limits: StudentLimits,
        script: tuple[str, ...],
    ) -> web.StreamResponse:
        """A laboratory's page, or what that asks its laboratory for."""
        if is_websocket(request):
            if place is None:
                raise web.HTTPNotFound(text="there is no such page\n")
            return await self.connect(request, place, StudentMessages(limits))
        if path == ALIVE:
            return web.Response(text=f"{self.name}\n")
        if request.method not in READING:
            raise web.HTTPMethodNotAllowed(request.method, READING)
        if path in PAGES:
            scheme = "ws" if self.tls is None else "wss"
            addresses = websocket_addresses(request, self.allow, scheme=scheme)
            return page_response(request, client_page((*SCRIPTS, *script), STYLES), addresses)
        if place is None or not PLAIN.fullmatch(path):
            raise web.HTTPNotFound(text="there is no such page\n")
        query = f"?{request.rel_url.raw_query_string}" if request.rel_url.raw_query_string else ""
        return await self.pass_on(request, place, path + query)

    async def pass_on(self, request: Request, place: LaboratoryAddress, path: str) -> web.Response:
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
            return web.Response(status=503, text=f"{NOT_THERE}\n")
        if len(body) > MOST_ANSWER:
            return web.Response(status=502, text="the answer is too large for a class\n")
        brought = {name: answer.headers[name] for name in BROUGHT_BACK if name in answer.headers}
        return web.Response(status=answer.status, body=body, headers=brought)

    async def connect(
        self,
        request: Request,
        place: LaboratoryAddress,
        incoming: StudentMessages,
        ends: Ending = never,
    ) -> web.StreamResponse:
        """Connect a page with a laboratory, until one of both goes or `ends` returns."""
        address = place.address.replace("http:", "ws:", 1)

        async def open_line() -> ClientConnection:
            return await connect_viser(f"{address}/")

        return await relay(request, open_line, incoming, ends, compress=True)
