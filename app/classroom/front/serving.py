"""Serves a class: one address, one port, and nothing for who has neither code nor cookie."""

from __future__ import annotations

import asyncio
import re
import secrets
import ssl
from collections import defaultdict
from pathlib import Path
from typing import Any

from aiohttp import web

from app.classroom.classroom import Classroom
from app.classroom.flocks import TEACHER
from app.classroom.front.class_request import (
    LARGEST_BODY,
    MOST_AT_ONCE,
    MOST_PAGES,
    READING,
    Connections,
    StudentLimits,
    refused,
)
from app.classroom.front.entrance import ClassEntrance
from app.classroom.front.relay import Ending, Relay, camera_alone
from app.classroom.front.student_requests import StudentRequests
from app.classroom.front.teacher_requests import TeacherRequests
from app.classroom.student import LaboratoryAddress, Role, Student
from app.front.client_page import ClientPage, client_page
from app.front.log import Log, in_a_line, log_failures, logger
from app.front.origin import AllowedHost, authority, elsewhere, here
from app.front.page_front import CLOSED, FIXED, POLICY, policy
from app.front.server import listening
from app.viewer.lab.scene_requests import MARK, SCRIPTS
from worlds.input_error import InputError

IDLE = 20.0
"""Seconds that a connection may be silent that has no request."""
LINGERS = 2.0
"""Seconds that more is taken of a request that has been refused, so that the refusal is read."""
READS = 60.0
"""Seconds in which an answer is to be read."""
CHANGES_OVER = 3.0
"""Seconds that a page has to change over by itself, after which its connection is ended."""
METHODS = (*READING, "POST")
PLAIN = re.compile(r"[\w./~-]+", re.ASCII)
"""The paths that a laboratory serves, none of which is encoded."""
PAGES = ("/", "/index.html")
STYLES = ("classroom/bar.css",)
TEACHES = ("classroom/wall.js", "classroom/teacher.js")
LEARNS = ("classroom/student.js",)
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
        self.tls = None if certificate is None else tls(*certificate)
        self.sock = listening(host, port)
        self.port: int = self.sock.getsockname()[1]
        self.name = secrets.token_hex(8)
        self.relay: Relay
        self.limits: dict[int, StudentLimits] = defaultdict(StudentLimits)
        self.entrance = ClassEntrance(classroom, self.port)
        self.log = Log()
        self.student = StudentRequests(classroom)
        self.teacher = TeacherRequests(classroom, self.addresses(host))

    def addresses(self, host: str) -> list[str]:
        """Where others reach it, the likeliest first; where only this machine does, here."""
        plain = (80, self.port)
        named = [
            f"{self.scheme if one.port in plain else 'https'}://{one}" for one in self.allow
        ]  # at any other port there is a proxy, which encrypts
        found = elsewhere(host, self.port) or [here(host, self.port)]
        return [*named, *(one.replace("http:", f"{self.scheme}:", 1) for one in found)]

    async def open(self) -> None:
        """Serve, until closed."""
        self.relay = Relay()
        log_failures(asyncio.get_running_loop(), self.log)
        app = web.Application(client_max_size=LARGEST_BODY, middlewares=[self.answer])
        app.on_response_prepare.append(self.finish)
        self.runner = web.AppRunner(
            app,
            access_log=None,
            logger=logger(self.log),
            keepalive_timeout=IDLE,
            lingering_time=LINGERS,
            handler_cancellation=True,
            auto_decompress=False,
        )
        await self.runner.setup()
        server = self.runner.server
        if server is None:
            raise RuntimeError("aiohttp's runner has no server after its setup")
        self.connections = Connections(server)
        await web.SockSite(self.runner, self.sock, ssl_context=self.tls).start()

    async def close(self) -> None:
        """Serve no more."""
        await self.relay.close()
        self.runner._shutdown_timeout = 0.5
        await self.runner.cleanup()

    @property
    def scheme(self) -> str:
        """How its address begins."""
        return "http" if self.tls is None else "https"

    @property
    def teachers_link(self) -> str:
        """What opens the teacher's page, for who starts the class alone."""
        at = here("127.0.0.1", self.port).replace("http:", f"{self.scheme}:", 1)
        return f"{at}/{self.classroom.key}"

    @property
    def opening_link(self) -> str:
        """What opens it once, for the browser that the command begins."""
        return f"{self.teachers_link.rpartition('/')[0]}/{self.classroom.first_key}"

    async def finish(self, request: web.Request, response: web.StreamResponse) -> None:
        """Give an answer, whoever made it, the headers that every one has."""
        response.headers["Server"] = "flockscope"
        for name, value in FIXED.items():
            response.headers.setdefault(name, value)
        response.headers.setdefault(POLICY, CLOSED)
        if request.method == "HEAD" and isinstance(response, web.Response):
            response.headers.setdefault("Content-Length", "0")  # which aiohttp says to GET alone

    # Who asks for what.

    @web.middleware
    async def answer(
        self,
        request: web.Request,
        handler: Any,  # noqa: ARG002, what aiohttp would answer
    ) -> web.StreamResponse:
        """Everything that is asked."""
        self.connections.busy(request.protocol)
        try:
            response = await self.answer_whatever(request)
            if response.status >= 400:
                response.force_close()
            await self.send(request, response)
        finally:
            self.connections.rest(request.protocol, request.transport)
        return response

    async def answer_whatever(self, request: web.Request) -> web.StreamResponse:
        """Everything that is asked, however it ends."""
        try:
            if request.method not in METHODS:
                raise web.HTTPMethodNotAllowed(request.method, METHODS)
            if not request.path.startswith("/"):
                raise web.HTTPBadRequest(text="this is no address of a page\n")
            return refused(request, self.allow) or await self.answer_known(request)
        except InputError as refusal:
            words = f"{refusal}\n".encode("utf-8", "replace")
            return web.Response(status=400, body=words, content_type="text/plain", charset="utf-8")
        except web.HTTPException as found:
            headers = {
                name: found.headers[name] for name in ("Location", "Allow") if name in found.headers
            }
            return web.Response(status=found.status, text=found.text, headers=headers)
        except ConnectionError:
            raise
        except Exception as error:
            self.log.line(f"what a browser asked for failed: {in_a_line(error)}")
            return web.Response(status=500, text="this cannot be answered\n")

    async def send(self, request: web.Request, response: web.StreamResponse) -> None:
        """Send an answer, to who reads it."""
        if not isinstance(response, web.Response):
            return
        try:
            async with asyncio.timeout(READS):
                await response.prepare(request)
                await response.write_eof()
        except TimeoutError:
            if request.transport is not None:
                request.transport.abort()

    async def answer_known(self, request: web.Request) -> web.StreamResponse:
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

    async def answer_teacher(self, request: web.Request) -> web.StreamResponse:
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

    async def answer_student(self, request: web.Request, student: Student) -> web.StreamResponse:
        """What a student is answered."""
        limits = self.limits[student.number]
        if not limits.requests.take():
            raise web.HTTPTooManyRequests(text="too many requests at once: wait a moment\n")
        if is_websocket(request):
            return await self.connect_student(request, student, limits)
        if limits.going >= MOST_AT_ONCE + limits.streams:
            raise web.HTTPTooManyRequests(text="too many requests at once: wait a moment\n")
        limits.going += 1
        try:
            response = await self.answer_page(request, student, limits)
            await self.send(request, response)
        finally:
            limits.going -= 1
        return response

    async def answer_page(
        self, request: web.Request, student: Student, limits: StudentLimits
    ) -> web.StreamResponse:
        """What a student's page is answered that asks for something else than a line."""
        if (found := await self.student.answer(request, student, limits)) is not None:
            return found
        if MARK in request.headers and student.frozen and student.role is Role.OWN:
            raise web.HTTPForbidden(text="your flock is held by the teacher\n")
        if request.path in ("/alive", *PAGES):
            place = None
        else:
            place = await self.classroom.place_of(student)
        return await self.show(request, place, request.path, limits, LEARNS)

    async def connect_student(
        self, request: web.Request, student: Student, limits: StudentLimits
    ) -> web.StreamResponse:
        """A student's page connects with what it is shown."""
        place = await self.classroom.place_of(student)
        if student.lines >= MOST_PAGES or not limits.pages.take():
            raise web.HTTPTooManyRequests(text="too many pages of one student at once\n")
        self.classroom.connect(student)
        try:
            return await self.relay.connect(
                request,
                place,
                limits,
                lambda data: not student.frozen or camera_alone(data),
                self.changed_over(student),
            )
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
        request: web.Request,
        place: LaboratoryAddress | None,
        path: str,
        limits: StudentLimits,
        script: tuple[str, ...],
    ) -> web.StreamResponse:
        """A laboratory's page, or what that asks its laboratory for."""
        if is_websocket(request):
            if place is None:
                raise web.HTTPNotFound(text="there is no such page\n")
            return await self.relay.connect(request, place, limits)
        if path == "/alive":
            return web.Response(text=f"{self.name}\n")
        if request.method not in READING:
            raise web.HTTPMethodNotAllowed(request.method, READING)
        if path in PAGES:
            return self.page(request, client_page((*SCRIPTS, *script), STYLES))
        if place is None or not PLAIN.fullmatch(path):
            raise web.HTTPNotFound(text="there is no such page\n")
        query = f"?{request.rel_url.raw_query_string}" if request.rel_url.raw_query_string else ""
        return await self.relay.pass_on(request, place, path + query)

    def page(self, request: web.Request, page: ClientPage) -> web.Response:
        """viser's page, with what it may do."""
        packed = "gzip" in request.headers.get("Accept-Encoding", "")
        headers = {POLICY: policy(page.hashes, self.lines_of(request)), "Vary": "Accept-Encoding"}
        if packed:
            headers["Content-Encoding"] = "gzip"
        return web.Response(
            body=page.packed if packed else page.html,
            content_type="text/html",
            charset="utf-8",
            headers=headers,
        )

    def lines_of(self, request: web.Request) -> tuple[str, ...]:
        """Where a page that is served may open websockets, as its policy writes it."""
        reached = authority(request.headers.get("Host"))
        own = "ws" if self.tls is None else "wss"
        named = [f"{scheme}://{one}" for one in self.allow for scheme in ("ws", "wss")]
        found = dict.fromkeys((f"{own}://{reached}", *named))
        return tuple(line for line in found if "[" not in line)


def is_websocket(request: web.Request) -> bool:
    """Whether a request wants to become a websocket."""
    return request.headers.get("Upgrade", "").lower() == "websocket"


def tls(certificate: Path, key: Path) -> ssl.SSLContext:
    """What encrypts with a certificate. Raises InputError."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(certificate, key, password=lambda: "")  # else it would ask for it
    except (OSError, ssl.SSLError) as error:
        why = error.strerror or str(error)
        raise InputError(
            f"--certificate {str(certificate)!r} with --key {str(key)!r} cannot be used: {why}"
        ) from None
    return context
