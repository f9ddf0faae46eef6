"""The questions of a class: asked, answered by runs, and shown.

What takes long is done in processes: runs by those of `RunQueue`, pictures and files by another,
curves by a third. So none of them waits for what another is at.
"""

from __future__ import annotations

import asyncio
import gzip
import json
from collections.abc import Coroutine
from dataclasses import replace
from pathlib import Path
from typing import Any

from agents.kinds import kind_table
from agents.spec import CompleteSpec
from app.classroom.collect.class_table import to_json
from app.classroom.collect.collection import Collection
from app.classroom.collect.hand_in import Point
from app.classroom.collect.question import Question, question_of
from app.classroom.collect.question_choices import measures_of, parameters_of, ready_for
from app.classroom.run_queue import RunQueue
from app.classroom.workers.measuring import DRAW_NICENESS, CurveWorker, DrawWorker
from app.classroom.workers.worker_process import WorkerProcess
from app.processes import ProcessLostError
from app.viewer.gallery.lessons.lessons import lesson_of
from app.viewer.gallery.saved_scene import SavedScene
from worlds.input_error import InputError

CURVE = 2.0
"""Seconds between two looks at a sweep that makes a curve."""
MOST_QUESTIONS = 50


class QuestionService:
    """The questions of a class, the latest last; for one event loop. `results`: of sweeps."""

    def __init__(self, results: Path):
        self.results = results
        self.all: list[Collection] = []
        self.is_open = False
        """Whether results are taken for the latest."""
        self.scene: SavedScene | None = None
        """That of the latest."""
        self.told = ""
        """What is to be said of the curve that is being made."""
        self.runs = RunQueue()
        self.drawing = WorkerProcess(DrawWorker, niceness=DRAW_NICENESS, restarts=True)
        self.sweeping = WorkerProcess(CurveWorker, results, restarts=True)
        self.drawn: object = None
        """Of what the results below are."""
        self.results_json: dict[str, Any] = {}
        self.packed_plot = b""
        self.drawings = 0
        self.counted: tuple[object, dict[str, list[int]]] = (None, {})
        self.handed: set[asyncio.Task[Point]] = set()
        """What is being made, whether or not the page that handed it in still waits."""
        self.curves: asyncio.Task[None] | None = None

    @property
    def latest(self) -> Collection | None:
        """The question that was asked last."""
        return self.all[-1] if self.all else None

    @property
    def open(self) -> Collection | None:
        """The question that is asked now."""
        return self.latest if self.is_open else None

    async def close(self) -> None:
        """End the processes."""
        self.is_open = False
        for task in (*self.handed, *([self.curves] if self.curves is not None else [])):
            task.cancel()
        await asyncio.gather(self.runs.close(), self.drawing.close(), self.sweeping.close())

    async def draw(self, name: str, *given: Any) -> Any:
        """What the process that draws and writes files answers. Raises InputError."""
        return await self.have(self.drawing, name, *given)

    async def have(self, process: WorkerProcess, name: str, *given: Any) -> Any:
        """What a process answers. Raises InputError."""
        try:
            return await process.do(name, *given)
        except ProcessLostError:
            raise InputError("this took too long, or its process was ended: try again") from None

    def take_over(self, questions: list[Collection], scene: SavedScene) -> None:
        """Go on with the questions of a class that is opened again; the latest stays shown."""
        self.all, self.scene = list(questions), scene
        for collection in self.all:
            collection.scene = self.scene = collection.scene or scene

    # What the teacher does.

    def choices(self, scene: SavedScene) -> dict[str, Any]:
        """What may be asked about a scene: parameters, measures, and questions that are ready."""
        spec = scene.spec
        return {
            "parameters": [vars(one) for one in parameters_of(spec)],
            "measures": [vars(one) for one in measures_of(spec)],
            "kinds": list(kind_table(spec.kinds, spec.to).names) if spec.kinds else [],
            "ready": [
                {
                    "name": one.name,
                    "lesson": one.lesson,
                    "question": one.question.to_values(),
                    "result": one.question.result_words,
                }
                for one in ready_for(spec, lesson_of(scene), scene.steps)
            ],
        }

    async def ask(self, values: Any, scene: SavedScene, moves_kinds: bool = True) -> Question:
        """Ask a question about a scene. Raises InputError.

        `moves_kinds`: whether students have sliders of the numbers of kinds.
        """
        if len(self.all) >= MOST_QUESTIONS:
            raise InputError(f"{MOST_QUESTIONS} questions have been asked: begin another class")
        question = await asyncio.to_thread(question_of, values, scene.spec)
        if question.kinds and scene.beside is not None:
            raise InputError("kinds: nobody plays one where two flocks are beside each other")
        if question.moves_kinds and not moves_kinds:
            raise InputError(
                "students' pages have no sliders of kinds: give values, and no kinds to play, or "
                "begin the class with --flocks on-server"
            )
        collection = Collection(question, scene=scene)
        self.all.append(collection)
        self.is_open, self.scene, self.told = True, scene, ""
        self.runs.begin(question, scene.spec)
        if self.curves is not None:
            self.curves.cancel()
        self.curves = asyncio.create_task(self.look_for_curve(collection, scene.spec))
        return question

    async def look_for_curve(self, collection: Collection, scene: CompleteSpec) -> None:
        """Find the curve that a sweep has made of the question."""
        try:
            collection.curve = await self.have(
                self.sweeping, "find_curve", collection.question, scene
            )
        except InputError as refusal:
            self.told = str(refusal)

    async def make_curve(self) -> str:
        """Begin the sweep that makes the curve of the latest question. Raises InputError."""
        if self.latest is None or self.scene is None:
            raise InputError("no question has been asked")
        collection, scene = self.latest, self.scene.spec
        question = collection.question
        name: str = await self.have(self.sweeping, "begin_curve", question, scene)
        if self.latest is not collection:
            return f"the sweep {name} has begun, for the question before: its curve is not shown"
        if self.curves is not None:
            self.curves.cancel()
        self.curves = asyncio.create_task(self.follow(name, collection, scene))
        return f"the sweep {name} has begun"

    async def follow(self, name: str, collection: Collection, scene: CompleteSpec) -> None:
        """Look at a sweep while it runs."""
        self.told = "the sweep begins"
        try:
            while self.told:
                await asyncio.sleep(CURVE)
                curve, self.told = await self.have(
                    self.sweeping, "curve", name, collection.question, scene
                )
                collection.curve = curve or collection.curve
        except InputError as refusal:
            self.told = str(refusal)

    def end(self) -> None:
        """Take no more results."""
        self.is_open = False

    # What students do.

    def begins(self, student: str, scene: SavedScene) -> SavedScene | None:
        """What a student begins with, while a question is asked; None while none is."""
        if self.open is None:
            return None
        return replace(scene, spec=self.open.begins(student, scene.spec))

    def demand_turn(self, student: str) -> Collection:
        """The question that is asked now, to which a student may hand in. Raises InputError."""
        if self.open is None:
            raise InputError("no question is asked now")
        self.runs.demand_turn(student)
        self.open.demand_room(student, self.runs.record(student).ended)
        return self.open

    async def hand_in(self, student: str, ran: str) -> Point:
        """Take a student's run, the scene `ran` as TOML, as an answer. Raises InputError.

        It is made to its end and taken even if the page that handed it in waits no more: a student
        who leaves and comes back has not two runs at a time.
        """
        collection = self.demand_turn(student)
        if self.scene is None:
            raise InputError("no question has been asked")
        self.runs.record(student).busy = True
        work = self.make_point(collection, student, ran, self.scene.spec)
        return await finish(self.handed, work)

    async def make_point(
        self, collection: Collection, student: str, ran: str, scene: CompleteSpec
    ) -> Point:
        """Have a run made, and take its result. Raises InputError."""
        point = await self.runs.make(student, collection.question, ran, scene)
        collection.add(point)
        return point

    # What is shown.

    @property
    def names(self) -> set[str]:
        """Of all who have handed a result in, whoever has been taken out since."""
        return {point.student for one in self.all for point in one.points}

    def shown(self) -> dict[str, Any] | None:
        """The latest question and its results, for the teacher's page."""
        if self.latest is None:
            return None
        made = self.shown_now()
        values = self.latest.question.values
        return {
            **made,
            "values": values,
            "open": self.is_open,
            "making": self.told,
            "asked": len(self.all),
        }

    def shown_now(self) -> dict[str, Any]:
        """The results of the latest question, made anew only where there is another one."""
        assert self.latest is not None
        now = (len(self.all), len(self.latest.points), self.latest.curve)
        if now != self.drawn:
            self.drawn = now
            self.drawings += 1
            self.results_json = to_json(self.latest)
            plot = json.dumps(without_names(self.results_json), separators=(",", ":"))
            self.packed_plot = gzip.compress(plot.encode(), 6, mtime=0)
        return self.results_json

    @property
    def plot_version(self) -> int:
        """Another one for other results; 0: no question has been asked."""
        if self.latest is None:
            return 0
        self.shown_now()
        return self.drawings

    def results_of(self, student: str) -> list[int]:
        """The numbers of a student's results of the latest question."""
        if self.latest is None:
            return []
        points = self.latest.points
        if self.counted[0] != (len(self.all), len(points)):
            numbers: dict[str, list[int]] = {}
            for number, point in enumerate(points):
                numbers.setdefault(point.student, []).append(number)
            self.counted = (len(self.all), len(points)), numbers
        return self.counted[1].get(student, [])

    def kind_of(self, student: str) -> str:
        """The kind that a student plays while a question is asked; empty: all of them."""
        given = None if self.open is None else self.open.given.get(student)
        return "" if given is None else given.kind

    def value_of(self, student: str) -> str:
        """The value that a student tries, with its unit: what the latest question gave them, else
        that of their last result; empty without any."""
        if self.latest is None:
            return ""
        given, numbers = self.latest.given.get(student), self.results_of(student)
        value = None if given is None else given.value
        if value is None and numbers:
            value = self.latest.points[numbers[-1]].value
        return "" if value is None else self.latest.question.value_text(value)

    def plot(self) -> bytes:
        """The results of the latest question as JSON, packed by gzip, for students: nobody's name
        is in it. Raises InputError where there is none."""
        if self.latest is None:
            raise InputError("no question has been asked")
        self.shown_now()
        return self.packed_plot

    async def picture(self, kind: str) -> bytes:
        """The picture of the latest question. Raises InputError."""
        made: bytes = await self.draw("picture", self.demand(), kind)
        return made

    def point(self, number: int) -> SavedScene:
        """The scene of a result of the latest question. Raises InputError."""
        collection = self.demand()
        if not 0 <= number < len(collection.points):
            raise InputError("there is no such result")
        return collection.points[number].scene(collection.question)

    def demand(self) -> Collection:
        """The latest question. Raises InputError where there is none."""
        if self.latest is None:
            raise InputError("no question has been asked")
        return self.latest


def without_names(results: dict[str, Any]) -> dict[str, Any]:
    """Results as students see them: of no point whose it is."""
    return results | {
        "points": [[number, "", *rest] for number, _, *rest in results["points"]],
    }


async def finish[T](tasks: set[asyncio.Task[T]], work: Coroutine[Any, Any, T]) -> T:
    """What some work gives, which goes on to its end among `tasks` even if nobody waits for it."""
    task = asyncio.get_running_loop().create_task(work)
    tasks.add(task)

    def forget(done: asyncio.Task[T]) -> None:
        tasks.discard(done)
        if not done.cancelled():
            done.exception()  # else asyncio complains of it where nobody waits

    task.add_done_callback(forget)
    return await asyncio.shield(task)
