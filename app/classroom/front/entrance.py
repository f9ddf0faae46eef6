"""How people come in: the teacher by a key, students by the code on the wall and a name."""

from __future__ import annotations

import html
from dataclasses import dataclass
from functools import cache
from string import Template

from aiohttp import web

from app.classroom.class_keys import LONGEST, is_same_text, normalise_code
from app.classroom.classroom import Classroom
from app.classroom.front.class_request import JOINS, STRANGERS, form_of
from app.classroom.student import Student
from app.front.client_addresses import RateLimit
from app.front.client_page import font_face, script_hash
from app.front.http_server import POLICY, Request, address_of_line
from app.front.page_front import page_policy
from app.package_files import STATIC
from worlds.input_error import InputError

# The pages that the front serves itself: how one comes in, the laboratory's, the teacher's.

FOLDER = STATIC / "classroom"
THEME = "classroom/theme.js"
STYLES = ("page.css", "classroom/pages.css", "classroom/chart.css")


@dataclass(frozen=True)
class Page:
    """A page of our own, whose words are put in where it says $name."""

    template: Template
    hashes: tuple[str, ...]

    def filled(self, **words: str) -> str:
        """The page with these words, which stand in it as text."""
        return self.template.substitute({name: html.escape(text) for name, text in words.items()})

    def policy(self, lines: tuple[str, ...] = ()) -> str:
        """What it may do; its forms are sent here alone."""
        return page_policy(self.hashes, lines).replace("form-action 'none'", "form-action 'self'")


@cache
def own_page(name: str, scripts: tuple[str, ...] = ()) -> Page:
    """A page of `static/classroom` with its scripts and styles in itself."""
    texts = [(STATIC / one).read_text("utf-8") for one in scripts]
    style = font_face() + "".join((STATIC / one).read_text("utf-8") for one in STYLES)
    added = f"<style>{style}</style>" + "".join(f"<script>{text}</script>" for text in texts)
    page = (FOLDER / name).read_text("utf-8")
    page = page.replace("</head>", added.replace("$", "$$") + "</head>")
    return Page(Template(page), tuple(script_hash(text.encode()) for text in texts))


LASTS = 12 * 3600
"""Seconds that a cookie lasts."""
OF_FORMS = {"Referrer-Policy": "origin"}
"""Without any referrer a browser says of a form that it comes from nowhere; the code is in the
path, which is not told."""
STRANGER = "this class is entered by its code: the address on the wall\n"
MOST_ADDRESSES = 4096
"""Addresses whose tries are remembered."""


class ClassEntrance:
    """Knows people by their cookies, and gives them. `port`: the class's; cookies know no ports."""

    def __init__(self, classroom: Classroom, port: int):
        self.classroom = classroom
        self.cookies = {who: f"flockscope-{who}-{port}" for who in ("teacher", "student")}
        self.strangers: dict[str, RateLimit] = {}
        self.joins = RateLimit(JOINS[0], max(JOINS[1], classroom.seats))

    def is_teacher(self, request: Request) -> bool:
        """Whether the teacher asks."""
        return self.classroom.is_teacher(request.cookies.get(self.cookies["teacher"], ""))

    def student_of(self, request: Request) -> Student | None:
        """The student who asks, if one does."""
        return self.classroom.student_of(request.cookies.get(self.cookies["student"], ""))

    def welcome(
        self, request: Request, is_teacher: bool, is_student: bool
    ) -> web.StreamResponse | None:
        """What somebody is answered at the address of the code or of a key; None at any other."""
        secret = request.path[1:]
        if len(secret) >= LONGEST:
            return None
        teaches = self.classroom.is_key(secret)
        if not teaches:
            known = is_teacher or is_student  # of strangers the code is taken as they have typed it
            if not is_same_text(secret if known else normalise_code(secret), self.classroom.code):
                return None
        if is_teacher if teaches else is_student:
            raise web.HTTPSeeOther("class" if teaches else "./")
        if teaches:
            page = own_page("teach.html", (THEME, "classroom/teach.js"))
            return own_page_response(page.filled(key=secret), page)
        return self.ask_name()

    def ask_name(self, name: str = "", why: str = "") -> web.Response:
        """The page on which somebody gives a name, and why another one is needed."""
        page = own_page("join.html", (THEME,))
        words = {"code": self.classroom.code, "title": self.classroom.title}
        return own_page_response(
            page.filled(**words, name=name, why=why), page, 400 if why else 200
        )

    async def come_in(self, request: Request) -> web.StreamResponse:
        """Take in who sends the code and a name, or the teacher's key. Raises InputError."""
        given = await form_of(request)
        if request.path == "/teach":
            if not self.classroom.is_key(given.get("key", "")):
                self.limit_tries(request)
            cookie = self.classroom.admit_teacher(given.get("key", ""))
            return self.let_in(request, "teacher", cookie, "class")
        code = normalise_code(given.get("code", ""))
        if not is_same_text(code, self.classroom.code):
            self.limit_tries(request)
        elif not self.joins.take():
            raise web.HTTPTooManyRequests(text="many come in at once: try again in a moment\n")
        try:
            _, cookie = self.classroom.admit(code, given.get("name", ""))
        except InputError as refusal:
            if not is_same_text(code, self.classroom.code):
                return web.Response(status=403, text=f"{refusal}\n")
            return self.ask_name(given.get("name", "")[:60], str(refusal))
        return self.let_in(request, "student", cookie, "./")

    def let_in(self, request: Request, who: str, cookie: str, to: str) -> web.Response:
        """Give somebody a cookie, and lead them on."""
        answer = web.Response(status=303, headers={"Location": to})
        answer.set_cookie(
            self.cookies[who],
            cookie,
            max_age=LASTS,
            path="/",
            httponly=True,
            samesite="Strict",
            secure=request.secure or request.headers.get("Origin", "").startswith("https:"),
        )
        return answer

    def turn_away(self, request: Request) -> web.Response:
        """What a stranger is answered."""
        self.limit_tries(request)
        return web.Response(status=403, text=STRANGER)

    def limit_tries(self, request: Request) -> None:
        """Bound how often strangers try."""
        if len(self.strangers) >= MOST_ADDRESSES:
            self.strangers = {
                one: limit for one, limit in self.strangers.items() if limit.fill() < limit.most
            }
            if len(self.strangers) >= MOST_ADDRESSES:
                raise web.HTTPTooManyRequests(text="too many tries from too many addresses\n")
        limit = self.strangers.setdefault(address_of_line(request), RateLimit(*STRANGERS))
        if not limit.take():
            raise web.HTTPTooManyRequests(text="too many tries from one address\n")


def own_page_response(text: str, page: Page, status: int = 200) -> web.Response:
    """A page with a form."""
    headers = {POLICY: page.policy(), **OF_FORMS}
    return web.Response(text=text, status=status, content_type="text/html", headers=headers)
