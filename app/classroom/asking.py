"""The questions of a class: asked, answered by runs, and shown.

What takes long is done in a process of its own, one run after the other; one that takes too long
ends with that process, and another is begun.
"""

from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path
from typing import Any

from agents.spec import Spec
from app.classroom.collect.choices import measures_of, parameters_of, ready_for
from app.classroom.collect.collection import Collection
from app.classroom.collect.curve import Curve
from app.classroom.collect.hand_in import SECONDS, Point
from app.classroom.collect.question import Question, question_of
from app.classroom.collect.table import to_csv, to_json
from app.classroom.lessons.lessons import lesson_of
from app.classroom.workers.measuring import Measuring
from app.classroom.workers.process import Gone, WorkerProcess
from app.viewer.gallery.saved_scene import SavedScene
from worlds.refusal import Refusal

COMPILES = 180.0
"""Seconds that the first run of a model may take, on a busy machine."""
CURVE = 2.0
"""Seconds between two looks at a sweep that makes a curve."""
MOST_QUESTIONS = 50


class Asking:
    """The questions of a class, the latest last; for one event loop. `results`: of sweeps."""

    def __init__(self, results: Path):
        self.results = results
        self.all: list[Collection] = []
        self.is_open = False
        """Whether results are taken for the latest."""
        self.scene: SavedScene | None = None
        """That of the latest."""
        self.curve: Curve | None = None
        self.told = ""
        """What is to be said of the curve that is being made."""
        self.worker: WorkerProcess | None = None
        self.beginning = asyncio.Lock()
        self.busy: set[str] = set()
        """Students whose run is being made."""
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
        """End the process."""
        self.is_open = False
        if self.curves is not None:
            self.curves.cancel()
        if self.worker is not None:
            worker, self.worker = self.worker, None
            await worker.close()

    async def have(self, name: str, *given: Any, patience: float = COMPILES) -> Any:
        """What the process answers. Raises Refusal."""
        async with self.beginning:
            if self.worker is None:
                self.worker = await WorkerProcess(self.has_ended, Measuring, self.results).begin()
        worker = self.worker
        try:
            return await worker.ask(name, *given, patience=patience)
        except Gone:
            if self.worker is worker:
                self.worker = None
                worker.process.kill()
            raise Refusal("this took too long, or its process was ended: try again") from None

    def has_ended(self, worker: WorkerProcess) -> None:
        """The process has died: the next that is asked of it begins another."""
        if self.worker is worker:
            self.worker = None

    def take_over(self, questions: list[Collection], scene: SavedScene) -> None:
        """Go on with the questions of a class that is opened again; the latest stays shown."""
        self.all, self.scene = list(questions), scene

    # What the teacher does.

    def choices(self, scene: SavedScene) -> dict[str, Any]:
        """What may be asked about a scene: parameters, measures, and questions that are ready."""
        spec = scene.spec
        return {
            "parameters": [vars(one) for one in parameters_of(spec)],
            "measures": [vars(one) for one in measures_of(spec)],
            "ready": [
                {
                    "name": one.name,
                    "lesson": one.lesson,
                    "question": one.question.to_values(),
                    "result": one.question.result_words,
                }
                for one in ready_for(spec, lesson_of(scene))
            ],
        }

    async def ask(self, values: Any, scene: SavedScene) -> Question:
        """Ask a question about a scene. Raises Refusal."""
        if len(self.all) >= MOST_QUESTIONS:
            raise Refusal(f"{MOST_QUESTIONS} questions have been asked: begin another class")
        question = await asyncio.to_thread(question_of, values, scene.spec)
        self.all.append(Collection(question))
        self.is_open, self.scene, self.curve, self.told = True, scene, None, ""
        if self.curves is not None:
            self.curves.cancel()
        self.curves = asyncio.create_task(self.look_for_curve(question, scene.spec))
        return question

    async def look_for_curve(self, question: Question, scene: Spec) -> None:
        """Have the runs compiled, and find the curve that a sweep has made of the question."""
        try:
            await self.have("warm_up", question, scene)
            self.curve = await self.have("find_curve", question, scene)
        except Refusal as refusal:
            self.told = str(refusal)

    async def make_curve(self) -> str:
        """Begin the sweep that makes the curve of the latest question. Raises Refusal."""
        if self.latest is None or self.scene is None:
            raise Refusal("no question has been asked")
        question, scene = self.latest.question, self.scene.spec
        name: str = await self.have("begin_curve", question, scene)
        if self.curves is not None:
            self.curves.cancel()
        self.curves = asyncio.create_task(self.follow(name, question, scene))
        return f"the sweep {name} has begun"

    async def follow(self, name: str, question: Question, scene: Spec) -> None:
        """Look at a sweep while it runs."""
        self.told = "the sweep begins"
        try:
            while self.told:
                await asyncio.sleep(CURVE)
                curve, self.told = await self.have("curve", name, question, scene)
                self.curve = curve or self.curve
        except Refusal as refusal:
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

    async def hand_in(self, student: str, ran: str) -> Point:
        """Take a student's run, the scene `ran` as TOML, as an answer. Raises Refusal."""
        collection = self.open
        if collection is None or self.scene is None:
            raise Refusal("no question is asked now")
        if student in self.busy:
            raise Refusal("your last result is still being made")
        collection.demand_room(student)
        self.busy.add(student)
        try:
            patience = SECONDS + 1.0 if collection.points else COMPILES
            point: Point = await self.have(
                "hand_in", collection.question, student, ran, self.scene.spec, patience=patience
            )
            collection.add(point)
            return point
        finally:
            self.busy.discard(student)

    # What is shown.

    @property
    def names(self) -> set[str]:
        """Of all who have handed a result in, whoever has been taken out since."""
        return {point.student for one in self.all for point in one.points}

    def shown(self) -> dict[str, Any] | None:
        """The latest question and its results, for the teacher's page."""
        if self.latest is None:
            return None
        made = to_json(self.latest, self.curve)
        values = self.latest.question.values
        return {
            **made,
            "values": values,
            "open": self.is_open,
            "making": self.told,
            "asked": len(self.all),
        }

    def csv(self) -> str:
        """The results of the latest question. Raises Refusal."""
        return to_csv(self.demand())

    async def picture(self, kind: str) -> bytes:
        """The picture of the latest question. Raises Refusal."""
        made: bytes = await self.have("picture", self.demand(), kind, self.curve)
        return made

    def point(self, number: int) -> SavedScene:
        """The scene of a result of the latest question. Raises Refusal."""
        collection = self.demand()
        if not 0 <= number < len(collection.points):
            raise Refusal("there is no such result")
        return collection.points[number].scene(collection.question)

    def demand(self) -> Collection:
        """The latest question. Raises Refusal where there is none."""
        if self.latest is None:
            raise Refusal("no question has been asked")
        return self.latest
