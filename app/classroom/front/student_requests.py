"""What a student's page asks the class for, beside the laboratory that it shows."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import Any

from aiohttp import web

from app.classroom.classroom import Classroom
from app.classroom.collect.question import Question
from app.classroom.front.class_request import (
    MOST_STREAMS,
    StudentLimits,
    choice_in,
    slider_values_in,
    step_number_in,
    values_of,
)
from app.classroom.front.student_pages import packed_response
from app.classroom.lesson_prediction import LessonPrediction
from app.classroom.student import Role, Student
from app.front.http_server import READING, Request, secure
from app.viewer.measuring.observable_format import observable_words
from worlds.input_error import InputError

# Tells a page what has changed, as it changes: events that a server sends.

APART = 0.25
"""Seconds between two events at least."""
ALIVE = 15.0
"""Seconds after which a page is told that nothing has changed, so that proxies keep the line."""


async def stream(
    request: Request, classroom: Classroom, told: Callable[[], Any]
) -> web.StreamResponse:
    """An answer without end: `told()` as JSON now, and whenever it has become another.

    It ends once it has said that the class is over, for all or for this page, and where the command
    is stopped: then pages come back to the class when it is opened again.
    """
    response = web.StreamResponse(headers={"Content-Type": "text/event-stream"})
    secure(response.headers)
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
            if said["over"] or classroom.is_over:
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


PLOT = "/class/plot.json"
"""Where a page has the class's results from."""
PLOT_APART, PLOTS = 2.0, 50.0
"""Seconds between two looks of a page at them at least, and looks a second of the whole class."""


class StudentRequests:
    """Answers them; `answer` gives None for what is the laboratory's."""

    def __init__(self, classroom: Classroom):
        self.classroom = classroom

    async def answer(
        self, request: Request, student: Student, limits: StudentLimits
    ) -> web.StreamResponse | None:
        """What a student is answered."""
        if request.path == "/class/mine" and request.method in READING:
            return await self.listen(request, student, limits)
        if request.path == PLOT and request.method in READING:
            return packed_response(request, self.classroom.asking.plot(), "application/json", {})
        if request.method != "POST":
            if request.path.startswith("/class"):
                raise web.HTTPForbidden(text="this page is the teacher's\n")
            return None
        values = await values_of(request)
        predicts = request.path == "/class/predict"
        if not (limits.predictions if predicts else limits.words).take():
            raise web.HTTPTooManyRequests(text="too much at once: wait a moment\n")
        if predicts:
            return web.Response(text=await self.predict(student, values))
        if request.path != "/class/hand-in":
            raise web.HTTPForbidden(text="only the teacher may do that\n")
        sliders = slider_values_in(values, "values")
        step = step_number_in(values, "step")
        return web.Response(text=await self.classroom.hand_in(student, sliders, step))

    async def predict(self, student: Student, values: dict[str, Any]) -> str:
        """Take what a page says of a step of the lesson. Raises InputError."""
        choice, shown = choice_in(values, "choice"), choice_in(values, "shown")
        if choice is None:
            raise InputError("choice is missing: what is predicted?")
        step = step_number_in(values, "step")
        return await self.classroom.predict(student, step, LessonPrediction(choice, shown))

    async def listen(
        self, request: Request, student: Student, limits: StudentLimits
    ) -> web.StreamResponse:
        """Tell a student's page of the class, as long as it listens."""
        if limits.streams >= MOST_STREAMS:
            raise web.HTTPTooManyRequests(text="too many pages of one student at once\n")
        limits.streams += 1
        here = self.classroom.is_in_browser(student) and request.method != "HEAD"
        if here:
            self.classroom.listen(student, 1)
        try:
            return await stream(request, self.classroom, lambda: self.mine(student))
        finally:
            limits.streams -= 1
            if here:
                self.classroom.listen(student, -1)

    def mine(self, student: Student) -> dict[str, Any]:
        """What a student's page shows of the class; nothing any more to who is taken out of it."""
        if student.number not in self.classroom.students:
            return {"over": True, "removed": True}
        return {
            "name": student.name,
            "class": self.classroom.title,
            "role": student.role,
            "frozen": student.frozen,
            "moves": student.moves,
            "word": self.classroom.word,
            "question": self.question(student),
            "over": self.classroom.has_ended,
        } | self.of_page(student)

    def of_page(self, student: Student) -> dict[str, Any]:
        """What kind of page a student has, and of which results they can see the plot."""
        apart = max(PLOT_APART, len(self.classroom.students) / PLOTS)
        asking = self.classroom.asking
        mine = asking.results_of(student.name)
        told = {"plot": {"version": asking.plot_version, "apart": apart, "mine": mine}}
        pages = self.classroom.pages
        if pages is None:
            return told | {"page": "laboratory"}
        if not self.classroom.is_in_browser(student):
            return told | {"page": "watching"}
        lesson = self.lesson(student)
        return told | {"page": "flock", "flock": pages.flock_of(student), "lesson": lesson}

    def lesson(self, student: Student) -> dict[str, Any] | None:
        """The step that the teacher shows, and what the student has predicted as [step, choice,
        shown or null]; None where their page has not the steps of the class."""
        if not self.classroom.scene.steps or not self.classroom.shares_lesson(student):
            return None
        made = [[step, one.choice, one.shown] for step, one in student.predictions.items()]
        return {"step": self.classroom.step, "predictions": made}

    def measured_now(self, student: Student, question: Question) -> str:
        """What a flock on the server shows now of what the question measures, in words; empty where
        that is not known."""
        seen = self.classroom.flocks.seen.get(student.number)
        words = observable_words(question.measure.observable)
        value = None if seen is None else dict(seen.numbers).get(words)
        return (
            "" if seen is None or value is None else f"Now, tick {seen.tick}: {words} {value:.3g}"
        )

    def question(self, student: Student) -> dict[str, Any] | None:
        """What a student with a flock is asked, and has answered so far."""
        collection = self.classroom.asking.open
        if collection is None or student.role is Role.WATCHING:
            return None
        question, given = collection.question, collection.give(student.name)
        handed = self.classroom.asking.results_of(student.name)
        return {
            "title": question.title,
            "kind": given.kind,
            "parameter": question.parameter_words,
            "value": None if given.value is None else question.value_text(given.value),
            "measured": question.result_words,
            "now": self.measured_now(student, question),
            "handed": len(handed),
            "answer": collection.points[handed[-1]].told(question) if handed else "",
        }
