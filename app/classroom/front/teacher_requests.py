"""What the teacher's pages ask the class for, beside the laboratories that they show."""

from __future__ import annotations

import io
import re
from collections.abc import Awaitable, Callable
from dataclasses import asdict
from typing import Any

import segno
from aiohttp import web

from app.classroom.class_file import slug
from app.classroom.class_keeper import state_of
from app.classroom.classroom import Classroom
from app.classroom.flocks import TEACHER
from app.classroom.front.class_request import numbers_in, step_number_in, text_in, values_of
from app.classroom.front.entrance import own_page
from app.classroom.front.student_requests import stream
from app.classroom.lesson_prediction import count_choices
from app.classroom.student import Role, Student
from app.front.http_server import POLICY, READING, Request
from worlds.input_error import InputError

Values = dict[str, Any]
SCRIPTS = ("theme", "wall", "class", "chart", "lesson", "collect")
"""Of the teacher's page, in their order."""
PICTURES = {
    "/class/results.svg": "image/svg+xml",
    "/class/results.png": "image/png",
    "/class/results.pdf": "application/pdf",
}


class TeacherRequests:
    """Answers them; `answer` gives None for what is a laboratory's.

    `addresses`: where students reach the class, the likeliest first.
    """

    def __init__(self, classroom: Classroom, addresses: list[str]):
        self.classroom = classroom
        self.addresses = addresses
        self.page = own_page(
            "class.html",
            tuple(f"classroom/{name}.js" for name in SCRIPTS),
        )
        self.actions: dict[str, Callable[[Values], Awaitable[str]]] = {
            "role": self.give_role,
            "start": self.start,
            "freeze": self.freeze,
            "step": self.show_step,
            "say": self.say,
            "renew": self.renew,
            "remove": self.remove,
            "ask": self.ask,
            "stop-asking": self.stop_asking,
            "curve": self.make_curve,
            "open-point": self.open_point,
            "end": self.end,
        }

    async def answer(self, request: Request) -> web.StreamResponse | None:
        """What the teacher is answered."""
        path, get = request.path, request.method in READING
        if path == "/class" and get:
            headers = {POLICY: self.page.policy(("'self'",))}
            return web.Response(text=self.page.filled(), content_type="text/html", headers=headers)
        if path == "/class/roster" and get:
            return await stream(request, self.classroom, self.roster)
        if path == "/class/code.svg" and get:
            return web.Response(body=self.code(request), content_type="image/svg+xml")
        if path == "/class/choices.json" and get:
            choices = self.classroom.asking.choices(self.classroom.scene)
            return web.json_response(choices)
        if path == "/class/results.csv" and get:
            return file(self.classroom.results_csv().encode(), "text/csv", self.name("csv"))
        if path == "/class/predictions.csv" and get:
            return file(self.classroom.predictions_csv().encode(), "text/csv", "predictions.csv")
        if path == "/class/class.zip" and get:
            made = await self.classroom.asking.draw("packed", state_of(self.classroom))
            return file(made, "application/zip", "class.zip")
        if path in PICTURES and get:
            kind = path.rpartition(".")[2]
            picture = await self.classroom.asking.picture(kind)
            return file(picture, PICTURES[path], self.name(kind))
        if path == "/class/do" and request.method == "POST":
            values = await values_of(request)
            action = self.actions.get(text_in(values, "do"))
            if action is None:
                raise InputError(f"do is to be one of {', '.join(self.actions)}")
            return web.Response(text=await action(values))
        return None

    def name(self, kind: str) -> str:
        """File name of the results of the latest question: what was asked."""
        return f"{slug(self.classroom.asking.demand().question.title)}.{kind}"

    def code(self, request: Request) -> bytes:
        """The address on the wall as a QR code, SVG; behind a proxy only the page knows it."""
        at = request.query.get("at", "")
        if not re.fullmatch(
            rf"https?://[\w.:/\[\]~-]{{1,300}}/{self.classroom.code}", at, re.ASCII
        ):
            raise InputError("this is not an address of the class")
        made = io.BytesIO()
        segno.make_qr(at, error="m").save(
            made, kind="svg", border=2, xmldecl=False, omitsize=True, light="#fff"
        )
        return made.getvalue()

    def links(self) -> list[str]:
        """What students open, the likeliest address first."""
        return [f"{address}/{self.classroom.code}" for address in self.addresses]

    def roster(self) -> dict[str, Any]:
        """The whole class, for the teacher's page."""
        classroom = self.classroom
        mine = classroom.flocks.seen.get(TEACHER)
        return {
            "title": classroom.title,
            "code": classroom.code,
            "links": self.links(),
            "seats": classroom.seats,
            "word": classroom.word,
            "frozen": classroom.frozen,
            "first": classroom.first_role,
            "over": classroom.has_ended,
            "unkept": classroom.not_kept,
            "browsers": classroom.pages is not None,
            "flocks": classroom.pages.progress if classroom.pages else classroom.flocks_note,
            "question": classroom.asking.shown(),
            "lesson": self.lesson(),
            "mine": None if mine is None else asdict(mine),
            "students": [self.student(one) for one in classroom.students.values()],
        }

    def lesson(self) -> dict[str, Any] | None:
        """The steps of the lesson, and how many have predicted what; None where there are none."""
        classroom = self.classroom
        steps = classroom.scene.steps
        if not steps:
            return None
        made = [one.predictions for one in classroom.students.values()]
        return {"step": classroom.step, "steps": count_choices(steps, made)}

    def student(self, one: Student) -> dict[str, Any]:
        """A student, for the teacher's page."""
        seen = self.classroom.flocks.seen.get(one.number)
        return {
            "number": one.number,
            "name": one.name,
            "role": one.role,
            "here": one.is_here,
            "frozen": one.frozen,
            "note": self.classroom.asking.runs.note(one.name),
            "seen": None if seen is None else asdict(seen),
            "kind": one.kind,
            "value": self.classroom.asking.value_of(one.name),
            "handed": len(self.classroom.asking.results_of(one.name)),
        }

    # What the teacher does; each gives a line of what has been done.

    async def give_role(self, values: Values) -> str:
        """Let students watch, or have flocks of their own."""
        text = text_in(values, "role")
        if text not in list(Role):
            raise InputError(f"role is to be one of {', '.join(Role)}")
        self.classroom.give_role(Role(text), numbers_in(values, "students"))
        return "done"

    async def start(self, values: Values) -> str:
        """Have students begin with what the teacher's laboratory runs."""
        scene = await self.classroom.teachers_scene()
        await self.classroom.start_from(scene, numbers_in(values, "students"))
        return f"begun with “{scene.title}”"

    async def freeze(self, values: Values) -> str:
        """Hold flocks, or let them go on."""
        held = values.get("held")
        if not isinstance(held, bool):
            raise InputError("held is to be true or false")
        await self.classroom.freeze(held, numbers_in(values, "students"))
        return "held" if held else "going on"

    async def show_step(self, values: Values) -> str:
        """Show a step of the lesson to all, or let them go their own way."""
        step = step_number_in(values, "step")
        await self.classroom.show_step(step)
        return f"all students see step {step}" if step else "students go through the steps"

    async def say(self, values: Values) -> str:
        """A word to all."""
        self.classroom.say(text_in(values, "word"))
        return "said"

    async def renew(self, _values: Values) -> str:
        """Another code."""
        self.classroom.renew()
        return "the class has a new code; who is in it stays"

    async def remove(self, values: Values) -> str:
        """Take students out of the class."""
        for student in self.classroom.chosen(numbers_in(values, "students") or []):
            self.classroom.forget(student)
        return "removed"

    async def ask(self, values: Values) -> str:
        """Ask a question."""
        return await self.classroom.ask(values.get("question"))

    async def stop_asking(self, _values: Values) -> str:
        """Take no more results."""
        self.classroom.asking.end()
        self.classroom.tell()
        return "no more results are taken; what is there stays"

    async def make_curve(self, _values: Values) -> str:
        """Have a sweep make the curve of the question."""
        return await self.classroom.asking.make_curve()

    async def end(self, _values: Values) -> str:
        """End the class for all."""
        self.classroom.end()
        return "the class is over"

    async def open_point(self, values: Values) -> str:
        """Open the run of a result."""
        (number,) = numbers_in(values, "points", most=1) or [-1]
        return await self.classroom.open_point(number)


def file(body: bytes, kind: str, name: str) -> web.Response:
    """An answer that a browser saves under a name."""
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return web.Response(body=body, content_type=kind, headers=headers)
