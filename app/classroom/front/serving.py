"""Serves a class: one address, one port, and nothing for who has neither code nor cookie."""

from __future__ import annotations

import secrets
import ssl
from collections import defaultdict
from pathlib import Path

from aiohttp import web

from app.classroom.classroom import TEACHER, Classroom
from app.classroom.front.asked import LARGEST, refused
from app.classroom.front.connections import Connections
from app.classroom.front.limits import MOST_PAGES, STRANGERS, Limits
from app.classroom.front.pages import Page, own_page
from app.classroom.front.relay import Relay, camera_alone
from app.classroom.front.student_requests import StudentRequests
from app.classroom.front.teacher_requests import TeacherRequests
from app.classroom.keys import LONGEST, plain, same
from app.classroom.student import Place, Student
from app.viewer.lab.scene_requests import SCRIPTS
from app.viewer.web.addresses import elsewhere, here
from app.viewer.web.incoming.rate_limit import RateLimit
from app.viewer.web.incoming.visitors import address_of
from app.viewer.web.origin import Allowed, authority
from app.viewer.web.server import listening
from app.viewer.web.serving.client_page import ClientPage, client_page
from app.viewer.web.serving.headers import CLOSED, FIXED, POLICY, policy
from worlds.refusal import Refusal

LASTS = 12 * 3600
"""Seconds that a cookie lasts."""
IDLE = 20.0
"""Seconds that a connection may be silent that has no request."""
PAGES = ("/", "/index.html")
THEME = "classroom/theme.js"
STYLES = ("classroom/bar.css",)
TEACHES = ("classroom/wall.js", "classroom/teacher.js")
LEARNS = ("classroom/student.js",)
VISIT = ("classroom/visit.js",)
"""The scripts of a laboratory's page in a class, beside its own."""
OF_FORMS = {"Referrer-Policy": "origin"}
"""Without any referrer a browser says of a form that it comes from nowhere; the code is in the
path, which is not told."""
STRANGER = "this class is entered by its code: the address on the wall\n"
MOST_ADDRESSES = 4096
"""Addresses whose tries are remembered."""


class ClassFront:
    """What everybody reaches. Raises Refusal if the port is busy or a certificate is unusable."""

    def __init__(
        self,
        classroom: Classroom,
        host: str = "127.0.0.1",
        port: int = 8080,
        allow: tuple[Allowed, ...] = (),
        certificate: tuple[Path, Path] | None = None,
    ):
        self.classroom = classroom
        self.allow = allow
        self.tls = None if certificate is None else tls(*certificate)
        self.sock = listening(host, port)
        self.port: int = self.sock.getsockname()[1]
        self.name = secrets.token_hex(8)
        self.relay: Relay
        self.limits: dict[int, Limits] = defaultdict(Limits)
        self.strangers: dict[str, RateLimit] = {}
        self.lines: dict[int, set[web.WebSocketResponse]] = defaultdict(set)
        self.student = StudentRequests(classroom)
        self.teacher = TeacherRequests(classroom, self.addresses(host))

    def addresses(self, host: str) -> list[str]:
        """Where others reach it, the likeliest first; where only this machine does, here."""
        named = [f"{'https' if one.port is None else self.scheme}://{one}" for one in self.allow]
        found = elsewhere(host, self.port) or [here(host, self.port)]
        return [*named, *(one.replace("http:", f"{self.scheme}:", 1) for one in found)]

    async def open(self) -> None:
        """Serve, until closed."""
        self.relay = Relay()
        app = web.Application(client_max_size=LARGEST)
        app.on_response_prepare.append(self.finish)
        app.router.add_route("*", "/{path:.*}", self.answer)
        self.runner = web.AppRunner(
            app, access_log=None, keepalive_timeout=IDLE, handler_cancellation=True
        )
        await self.runner.setup()
        assert self.runner.server is not None
        self.connections = Connections(self.runner.server)
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

    async def finish(self, _request: web.Request, response: web.StreamResponse) -> None:
        """Give an answer, whoever made it, the headers that every one has."""
        for name, value in FIXED.items():
            response.headers.setdefault(name, value)
        response.headers.setdefault(POLICY, CLOSED)

    # Who asks for what.

    async def answer(self, request: web.Request) -> web.StreamResponse:
        """Everything that is asked."""
        found = refused(request, self.allow)
        if found is not None:
            return found
        try:
            return await self.answer_known(request)
        except Refusal as refusal:
            return web.Response(status=400, text=f"{refusal}\n")

    async def answer_known(self, request: web.Request) -> web.StreamResponse:
        """What is asked by whom we know; others are asked for the code."""
        classroom, path = self.classroom, request.path
        if classroom.is_over:
            return web.Response(status=410, text="this class is over\n")
        if request.method == "POST" and path in ("/join", "/teach"):
            return await self.come_in(request, path)
        is_teacher = classroom.is_teacher(request.cookies.get(self.cookie("teacher"), ""))
        student = classroom.student_of(request.cookies.get(self.cookie("student"), ""))
        known = is_teacher or student is not None
        if len(path) <= LONGEST and (same(path[1:], classroom.key) or self.is_code(path, known)):
            return self.welcome(request, path[1:], is_teacher, student is not None)
        if is_teacher:
            return await self.answer_teacher(request)
        if student is not None:
            return await self.answer_student(request, student)
        self.demand_patience(request)
        return web.Response(status=403, text=STRANGER)

    def is_code(self, path: str, known: bool) -> bool:
        """Whether a path is the code of the class; of strangers as they have typed it."""
        code = path[1:] if known else plain(path[1:])
        return same(code, self.classroom.code)

    def welcome(
        self, request: web.Request, secret: str, is_teacher: bool, is_student: bool
    ) -> web.StreamResponse:
        """The page on which somebody comes in, if they are not in yet."""
        teaches = same(secret, self.classroom.key)
        if is_teacher if teaches else is_student:
            raise web.HTTPSeeOther("/class" if teaches else "/")
        if teaches:
            page, words = own_page("teach.html", (THEME, "classroom/teach.js")), {"key": secret}
            return self.own(request, page.filled(**words), page)
        return self.ask_name(request)

    def ask_name(self, request: web.Request, name: str = "", why: str = "") -> web.StreamResponse:
        """The page on which somebody gives a name, and why another one is needed."""
        page = own_page("join.html", (THEME,))
        words = {"code": self.classroom.code, "title": self.classroom.title}
        return self.own(
            request, page.filled(**words, name=name, why=why), page, 400 if why else 200
        )

    def own(
        self, request: web.Request, text: str, page: Page, status: int = 200
    ) -> web.StreamResponse:
        """A page of our own."""
        headers = {POLICY: page.policy(self.lines_of(request)), **OF_FORMS}
        return web.Response(text=text, status=status, content_type="text/html", headers=headers)

    async def come_in(self, request: web.Request, path: str) -> web.StreamResponse:
        """Take in who sends the code and a name, or the teacher's key."""
        self.demand_patience(request)
        sent = await request.post()
        given = {key: value for key, value in sent.items() if isinstance(value, str)}
        secure = request.secure or request.headers.get("Origin", "").startswith("https:")
        if path == "/teach":
            cookie, who, to = (
                self.classroom.admit_teacher(given.get("key", "")),
                "teacher",
                "/class",
            )
        else:
            code = plain(given.get("code", ""))
            try:
                _, cookie = self.classroom.admit(code, given.get("name", ""))
            except Refusal as refusal:
                if not same(code, self.classroom.code):
                    return web.Response(status=403, text=f"{refusal}\n")
                return self.ask_name(request, given.get("name", "")[:60], str(refusal))
            who, to = "student", "/"
        answer = web.Response(status=303, headers={"Location": to})
        answer.set_cookie(
            self.cookie(who),
            cookie,
            max_age=LASTS,
            path="/",
            httponly=True,
            samesite="Strict",
            secure=secure,
        )
        return answer

    def demand_patience(self, request: web.Request) -> None:
        """Bound how often strangers try."""
        if len(self.strangers) >= MOST_ADDRESSES:
            self.strangers = {
                one: limit for one, limit in self.strangers.items() if limit.fill() < limit.most
            }
        peer = request.transport and request.transport.get_extra_info("peername")
        limit = self.strangers.setdefault(address_of(peer), RateLimit(*STRANGERS))
        if not limit.take():
            raise web.HTTPTooManyRequests(text="too many tries from one address\n")

    def cookie(self, who: str) -> str:
        """The name of a cookie: cookies know no ports, classes do."""
        return f"flockscope-{who}-{self.port}"

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
        place = self.classroom.teacher_place
        if place is None:
            raise web.HTTPServiceUnavailable(text="your flock is just beginning\n")
        return await self.show(request, place, request.path, limits, TEACHES)

    async def answer_student(self, request: web.Request, student: Student) -> web.StreamResponse:
        """What a student is answered."""
        limits = self.limits[student.number]
        if not limits.requests.take():
            raise web.HTTPTooManyRequests(text="too many requests at once: wait a moment\n")
        if (found := await self.student.answer(request, student, limits)) is not None:
            return found
        if request.path == "/alive" or (request.path in PAGES and not is_websocket(request)):
            place = None
        else:
            place = await self.classroom.place_of(student)
        if not is_websocket(request):
            return await self.show(request, place, request.path, limits, LEARNS)
        if student.lines >= MOST_PAGES or not limits.pages.take():
            raise web.HTTPTooManyRequests(text="too many pages of one student at once\n")
        assert place is not None
        self.classroom.connect(student)
        try:
            return await self.relay.connect(
                request,
                place,
                limits,
                lambda data: not student.frozen or camera_alone(data),
            )
        finally:
            self.classroom.disconnect(student)

    async def show(
        self,
        request: web.Request,
        place: Place | None,
        path: str,
        limits: Limits,
        script: tuple[str, ...],
    ) -> web.StreamResponse:
        """A laboratory's page, or what that asks its laboratory for."""
        if path == "/alive":
            return web.Response(text=f"{self.name}\n")
        if is_websocket(request):
            assert place is not None
            return await self.relay.connect(request, place, limits)
        if request.method != "GET":
            raise web.HTTPMethodNotAllowed(request.method, ["GET"])
        if path in PAGES:
            return self.page(request, client_page((*SCRIPTS, *script), STYLES))
        assert place is not None
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
    """What encrypts with a certificate. Raises Refusal."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(certificate, key)
    except (OSError, ssl.SSLError) as error:
        why = error.strerror or str(error)
        raise Refusal(
            f"--certificate {str(certificate)!r} with --key {str(key)!r} cannot be used: {why}"
        ) from None
    return context
