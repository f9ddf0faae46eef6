"""A class: who is in it, in what role, and which laboratory each of them sees.

All of it runs on one event loop. What takes long is done in worker processes.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from app.classroom.browser_flocks import MOST_WATCHING, BrowserFlocks, moved_scene
from app.classroom.class_keys import hash_key, is_same_text, new_code, new_key
from app.classroom.collect.class_table import to_csv
from app.classroom.flocks import Flocks, allowance
from app.classroom.lesson_prediction import (
    LessonPrediction,
    merge_prediction,
    prediction_columns,
    predictions_to_csv,
)
from app.classroom.question_service import QuestionService
from app.classroom.student import LaboratoryAddress, Role, Student, student_name, unique_name
from app.classroom.workers.page_worker import StudentPage
from app.classroom.workers.worker_process import WorkerProcess
from app.processes import ChildError
from app.results_folder import RESULTS
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_steps import SceneStep, lesson_key
from app.viewer.lab.panels.step_progress import LessonLead
from worlds.input_error import InputError

WAITS = 300.0
"""Seconds that the flock of a student waits whose line broke; then it is kept as a scene."""
UNUSED = 60.0
"""Seconds after which a seat is free again that somebody took without ever opening the page."""
UNUSED_WHEN_FULL = 10.0
"""Likewise where somebody else waits for a seat."""
LOOK = 2.0
"""Seconds between two looks at all laboratories."""
LONGEST_WORD = 200
"""Letters of a word to all."""
IN_BROWSER = "this flock runs in its student's browser: press a result to open what was handed in"


class Classroom:
    """One class. `seats`: students at most. `workers`: processes for their flocks. `results`: the
    folder of sweeps. `in_browser`: whether students' flocks run in their browsers."""

    def __init__(
        self,
        scene: SavedScene,
        seats: int = 40,
        workers: int = 2,
        results: Path = RESULTS,
        in_browser: bool = False,
    ):
        self.title = scene.title
        self.scene = scene
        """What flocks of one's own begin with."""
        self.seats = seats
        self.code = new_code()
        self.key = new_key()
        """What opens the teacher's page."""
        self.first_key = new_key()
        """What opens it once: a browser is begun with it, and everybody on the machine sees how."""
        self.teachers: set[str] = set()
        """Hashes of the teacher's cookies."""
        self.students: dict[int, Student] = {}
        self.by_key: dict[str, Student] = {}
        self.pages = BrowserFlocks() if in_browser else None
        """None: students' flocks run on the server."""
        self.first_role = Role.OWN if in_browser else Role.WATCHING
        """What new students do."""
        self.asking = QuestionService(results)
        self.flocks = Flocks(
            0 if in_browser else workers, allowance(scene, seats), self.moved, self.lead_of
        )
        self.workers = workers
        self.flocks_note = ""
        """Why students' flocks run on the server though they were to run in browsers."""
        self.compiling: asyncio.Task[None] | None = None
        self.not_kept = ""
        """Why the class's file could not be written when that was tried last; empty: it was."""
        self.word = ""
        self.step = 0
        """The step of the lesson that the teacher shows to all, from 1; 0: each goes their own
        way."""
        self.turn = 0
        """Counts its lessons: what was predicted before the present one began is not of it."""
        self.keyed: tuple[tuple[SceneStep, ...], str] = (), ""
        """Steps, and by which key their lesson is known."""
        self.frozen = False
        self.has_ended = False
        """Whether the teacher has ended it."""
        self.is_over = False
        """Whether nobody is served any more: it has ended, or the command is being stopped."""
        self.looking: asyncio.Task[None] | None = None
        self.listeners: set[Callable[[], None]] = set()
        """Called when something has changed that pages should be told."""

    async def open(self) -> None:
        """Begin the processes and the teacher's laboratory. Raises InputError."""
        await self.flocks.open(self.scene)
        self.looking = asyncio.create_task(self.look())
        if self.pages is not None:
            self.compiling = asyncio.create_task(self.compile(self.pages))

    async def compile(self, pages: BrowserFlocks) -> None:
        """Compile what students' browsers run; if none can run it, flocks run on the server."""
        try:
            await pages.compile(self.scene)
        except InputError as refusal:
            self.flocks_note = f"students' flocks run on the server: {refusal}"
            self.pages = None
            self.flocks.begin_workers(self.workers)
            await pages.close()
        self.tell()

    async def close(self) -> None:
        """End all processes."""
        self.is_over = True
        self.tell()
        for task in (self.looking, self.compiling):
            if task is not None:
                task.cancel()
        ends = [self.asking.close(), self.flocks.close()]
        await asyncio.gather(*ends, *([] if self.pages is None else [self.pages.close()]))

    async def look(self) -> None:
        """Now and then: see how all laboratories stand, keep their scenes, close those left."""
        while True:
            await asyncio.sleep(LOOK)
            await self.flocks.look(self.students)
            self.take_predictions()
            for student in self.students.values():
                if not student.is_here and time.monotonic() - student.left > WAITS:
                    self.flocks.leave(student)
            self.tell()

    def moved(self, worker: WorkerProcess) -> None:
        """A process has died, or has been begun anew: the pages that it was for connect anew."""
        for student in self.students.values():
            shown = self.flocks.shown(student)
            if shown is not None and shown.worker is worker:
                self.move(student)
        self.tell()

    # Who is in it.

    def admit(self, code: str, name: str) -> tuple[Student, str]:
        """Take a student in who gives the code; the student, and their cookie. Raises
        InputError."""
        if self.is_over:
            raise InputError("this class is over")
        if not is_same_text(code, self.code):
            raise InputError("this is not the code of the class: look at the wall again")
        self.free_seats()
        chosen = student_name(name)
        kept = next((s for s in self.students.values() if s.name == chosen and not s.key), None)
        if kept is not None:  # of a class that has been opened again
            return kept, self.give_key(kept)
        if len(self.students) >= self.seats:
            raise InputError(f"all {self.seats} seats of this class are taken")
        number = max(self.students, default=0) + 1
        taken = {one.name for one in self.students.values()} | self.asking.names
        chosen = unique_name(chosen, taken)
        student = Student(number, chosen, "", self.first_role, frozen=self.frozen)
        self.students[number] = student
        return student, self.give_key(student)

    def give_key(self, student: Student) -> str:
        """A cookie for a student who has none."""
        cookie = new_key()
        student.key = hash_key(cookie)
        self.by_key[student.key] = student
        self.tell()
        return cookie

    def free_seats(self) -> None:
        """Take back the seats of those who never came."""
        now = time.monotonic()
        waits = UNUSED if len(self.students) < self.seats else UNUSED_WHEN_FULL
        for student in list(self.students.values()):
            if not student.came and now - student.left > waits:
                self.forget(student)

    def forget(self, student: Student) -> None:
        """Take a student out of the class; their page is told."""
        self.students.pop(student.number, None)
        self.by_key.pop(student.key, None)
        self.flocks.leave(student)
        if self.asking.open is not None:
            self.asking.open.take_back(student.name)
        self.tell()

    def student_of(self, cookie: str) -> Student | None:
        """Whose cookie it is."""
        return self.by_key.get(hash_key(cookie)) if cookie else None

    def admit_teacher(self, key: str) -> str:
        """A cookie for who has the teacher's key. Raises InputError."""
        if not self.is_key(key):
            raise InputError("this is not the teacher's key")
        if not is_same_text(key, self.key):
            self.first_key = ""
        cookie = new_key()
        self.teachers.add(hash_key(cookie))
        return cookie

    def is_key(self, key: str) -> bool:
        """Whether it opens the teacher's page."""
        return bool(key) and (is_same_text(key, self.key) | is_same_text(key, self.first_key))

    def is_teacher(self, cookie: str) -> bool:
        """Whether it is a cookie of the teacher's."""
        return bool(cookie) and hash_key(cookie) in self.teachers

    def renew(self) -> None:
        """Give the class another code; who is in it stays."""
        self.code = new_code()
        self.tell()

    def student_at(self, text: str) -> Student:
        """The student whose number stands in an address. Raises InputError."""
        found = self.students.get(int(text)) if text.isdecimal() and len(text) < 9 else None
        if found is None:
            raise InputError("that student is not in the class any more")
        return found

    # What each of them sees.

    async def place_of(self, student: Student) -> LaboratoryAddress:
        """The laboratory that a student sees; their own is opened if need be. Raises InputError."""
        if self.is_in_browser(student):
            raise InputError(IN_BROWSER)
        return await self.flocks.place_of(student, lambda: self.first_scene(student, self.scene))

    def is_in_browser(self, student: Student) -> bool:
        """Whether a student's page has the flock in it."""
        return self.pages is not None and student.role is Role.OWN

    async def page_of(self, student: Student) -> StudentPage:
        """The page with a student's own flock in it. Raises InputError.

        A scene of their own that no browser runs, of a class that is opened again, is left.
        """
        if self.pages is None:
            raise InputError("students' flocks run on the server")
        student.scene = student.scene or self.first_scene(student, self.scene)
        question = None if self.asking.open is None else self.asking.open.question
        try:
            return await self.pages.page_of(student, question)
        except InputError:
            if student.begun or self.is_over:
                raise
            student.scene = self.first_scene(student, self.scene)
            return await self.pages.page_of(student, question)

    def first_scene(self, student: Student, scene: SavedScene) -> str:
        """What a student begins with, TOML: a scene with a seed of their own.

        While a question is asked about it, it has their value.
        """
        asked = self.asking.begins(student.name, scene)
        student.kind = self.asking.kind_of(student.name)
        if asked is None:
            seed = scene.spec.seed + student.number
            asked = replace(scene, spec=scene.spec.with_values(seed=seed))
        return asked.to_toml()

    def connect(self, student: Student) -> None:
        """A page of a student's has connected."""
        student.lines += 1
        student.came = True
        self.tell()

    def listen(self, student: Student, more: int) -> None:
        """A page of a student's listens to the class from now on (1), or no more (-1)."""
        student.listening += more
        student.came = True
        student.left = time.monotonic()
        self.tell()

    def disconnect(self, student: Student) -> None:
        """A page of a student's is gone."""
        student.lines -= 1
        student.left = time.monotonic()
        self.tell()

    def move(self, student: Student) -> None:
        """Have a student's pages connect anew."""
        student.moves += 1
        self.tell()

    def tell(self) -> None:
        """Tell all pages that something has changed."""
        for listener in list(self.listeners):
            listener()

    # What the teacher does.

    def chosen(self, numbers: Iterable[int] | None) -> list[Student]:
        """Students by their numbers; all for None. Raises InputError for a number nobody has."""
        if numbers is None:
            return list(self.students.values())
        found = [self.students.get(number) for number in numbers]
        if None in found:
            raise InputError("that student is not in the class any more")
        return [one for one in found if one is not None]

    def give_role(self, role: Role, numbers: Iterable[int] | None = None) -> None:
        """Let students watch, or have flocks of their own; new ones too if it is said of all."""
        students = self.chosen(numbers)
        if self.pages is not None and role is Role.WATCHING:
            watching = {one.number for one in students}
            watching |= {one.number for one in self.chosen(None) if one.role is Role.WATCHING}
            if len(watching) > MOST_WATCHING:
                raise InputError(
                    f"at most {MOST_WATCHING} students can look at your flock at once: "
                    f"these would be {len(watching)}"
                )
        if numbers is None:
            self.first_role = role
        for student in students:
            if student.role is not role:
                student.role = role
                self.move(student)

    async def start_from(self, scene: SavedScene, numbers: Iterable[int] | None = None) -> None:
        """Have students begin with a scene, each with a seed of their own; a question is over."""
        self.flocks.allowance.demand(scene.spec, scene.beside, None)
        if self.pages is not None:
            await self.pages.compile(scene)
        if numbers is None:
            is_other = scene.steps != self.scene.steps
            if is_other:
                self.leave_lesson()
            self.scene = scene
            self.asking.end()
            if is_other:
                await self.lead_all()
        await self.begin_anew(self.chosen(numbers), scene)

    async def ask(self, values: object) -> str:
        """Ask a question: all begin anew, each with a value of their own. Raises InputError."""
        question = await self.asking.ask(values, self.scene, moves_kinds=self.pages is None)
        self.first_role = Role.OWN
        await self.begin_anew(self.chosen(None), self.scene)
        return f"asked: {question.title}"

    async def begin_anew(self, students: Iterable[Student], scene: SavedScene) -> None:
        """Have students begin with a scene, in flocks of their own."""
        for student in students:
            await asyncio.sleep(0)  # five hundred scenes take a second: others are answered between
            student.scene = self.first_scene(student, scene)
            student.begun += 1
            student.page = None
            if student.place is not None:
                with suppress(InputError):  # it is opened when their page asks for it
                    await self.flocks.tell_own(student, "open", student.scene, student.kind)
                    if student.frozen:
                        await self.flocks.tell_own(student, "pause")
            if student.role is not Role.OWN:
                student.role = Role.OWN
                self.move(student)
        self.tell()

    async def hand_in(self, student: Student, values: Mapping[str, float], step: int = 0) -> str:
        """Take a student's run as an answer; the result in a sentence. Raises InputError.

        Of a page that has the flock in it, `values` is what the sliders say, and `step` the number
        of the lesson's step that the flock began with, from 1; 0: with none.
        """
        if student.role is not Role.OWN:
            raise InputError("only who has a flock of their own hands in a result")
        question = self.asking.demand_turn(student.name).question
        if self.pages is None:
            student.scene = ran = await self.flocks.tell_own(student, "scene")
        elif student.frozen:
            raise InputError("your flock is held by the teacher: hand in once it goes on")
        else:
            page = await self.page_of(student)
            begun = page.step_at(step) if step else None
            plain = moved_scene(student, page, values)
            ran = plain if begun is None else moved_scene(student, page, values, begun)
            # Without what the step sets: the next run may be of another step, or of none.
            student.scene = plain
        try:
            point = await self.asking.hand_in(student.name, ran)
        finally:
            self.tell()
        return point.told(question)

    def shares_lesson(self, student: Student) -> bool:
        """Whether the page of a student has the steps of the class."""
        page, steps = student.page, self.scene.steps
        if page is None:
            return False
        if page.steps is not steps and page.steps == steps:
            # They are asked for at every change of the class, of all students: compared once.
            student.page = replace(page, steps=steps)
            return True
        return page.steps is steps

    async def predict(self, student: Student, step: int, prediction: LessonPrediction) -> str:
        """Take what a student predicts in a step of the lesson, and what their run showed. Raises
        InputError."""
        if not self.is_in_browser(student):
            raise InputError("only who has a flock of their own predicts")
        if student.frozen:
            raise InputError("your flock is held by the teacher: predict once it goes on")
        page = await self.page_of(student)
        if not self.shares_lesson(student):
            raise InputError("your flock has not the steps of the class")
        self.keep_prediction(student, page.step_at(step), step, prediction)
        self.tell()
        return "predicted"

    def take_predictions(self) -> None:
        """Take what students have predicted in flocks on the server, as these stood when they were
        looked at last."""
        for student in self.students.values():
            status = self.flocks.seen.get(student.number)
            if status is None or (status.lesson, status.turn) != (self.lesson, self.turn):
                continue
            for number, choice, shown in status.predictions:
                # What is refused since the class is at an earlier step is there at the next look.
                with suppress(InputError):
                    step, made = self.scene.steps[number - 1], LessonPrediction(choice, shown)
                    self.keep_prediction(student, step, number, made)

    def keep_prediction(
        self, student: Student, step: SceneStep, number: int, prediction: LessonPrediction
    ) -> None:
        """Keep what a student predicts in a step, if the rules of a class allow it. Raises
        InputError."""
        known = student.predictions.get(number)
        kept = merge_prediction(step, number, prediction, known, self.step)
        student.predictions[number] = kept

    def results_csv(self) -> str:
        """The results of the latest question, each with the kind that its student plays, and with
        what they have predicted in the lesson. Raises InputError."""
        collection = self.asking.demand()
        made = {student.name: student.predictions for student in self.students.values()}
        rows = [made.get(point.student, {}) for point in collection.points]
        beside: dict[str, list[Any]] = {}
        if collection.question.kinds:
            given = (collection.given.get(point.student) for point in collection.points)
            beside["kind"] = ["" if one is None else one.kind for one in given]
        steps = self.scene.steps
        # Of another lesson than that which the question was asked about they say nothing.
        is_same = self.asking.scene is not None and self.asking.scene.steps == steps
        if is_same and any(rows):
            beside |= prediction_columns(steps, rows)
        return to_csv(collection, beside)

    def predictions_csv(self) -> str:
        """What students have predicted in the steps of the lesson. Raises InputError."""
        if not self.scene.steps:
            raise InputError("this class has no lesson with steps")
        made = {student.name: student.predictions for student in self.students.values()}
        return predictions_to_csv(self.scene.steps, made)

    async def open_point(self, number: int) -> str:
        """Open the run of a result in the teacher's laboratory. Raises InputError."""
        scene = self.asking.point(number)
        await self.flocks.tell_teacher("open", scene.to_toml())
        return f"opened in your flock: {scene.title}"

    async def teachers_scene(self) -> SavedScene:
        """What the teacher's laboratory runs now. Raises InputError."""
        return SavedScene.from_toml(await self.flocks.tell_teacher("scene"), "the teacher's run")

    async def freeze(self, frozen: bool, numbers: Iterable[int] | None = None) -> None:
        """Hold flocks, or let them go on."""
        if numbers is None:
            self.frozen = frozen
        for student in self.chosen(numbers):
            student.frozen = frozen
            if student.place is not None:
                with suppress(InputError):
                    await self.flocks.tell_own(student, "pause" if frozen else "go")
        self.tell()

    async def show_step(self, step: int) -> None:
        """Show a step of the lesson, from 1, to all students; 0 lets them go their own way. Raises
        InputError."""
        most = len(self.scene.steps)
        if not most:
            raise InputError("this class has no lesson with steps")
        if not 0 <= step <= most:
            raise InputError(f"step = {step} is not allowed: 0 to {most}")
        self.step = step
        self.tell()
        await self.lead_all()

    async def lead_all(self) -> None:
        """Have all flocks on the server show what the class shows."""
        await asyncio.gather(*(self.lead_student(one) for one in self.chosen(None) if one.place))

    async def lead_student(self, student: Student) -> None:
        """Have a student's flock on the server show what the class shows."""
        # Of one whose process ends now the next laboratory is led when it is opened.
        with suppress(InputError, ChildError):
            await self.flocks.tell_own(student, "lead", self.lead_of(student))

    def lead_of(self, student: Student) -> LessonLead:
        """How the class leads a student through its lesson now."""
        choices = {number: one.choice for number, one in student.predictions.items()}
        return LessonLead(self.lesson, self.step, self.turn, choices)

    @property
    def lesson(self) -> str:
        """Which lesson the class has, by `lesson_key`; empty: none with steps."""
        if self.keyed[0] is not self.scene.steps:  # asked for at every look: made once
            self.keyed = self.scene.steps, lesson_key(self.scene.steps)
        return self.keyed[1]

    def leave_lesson(self) -> None:
        """Forget the step that is shown, and predictions: another lesson has others."""
        self.step = 0
        self.turn += 1
        for student in self.students.values():
            student.predictions = {}

    def end(self) -> None:
        """End the class for all: pages are told so."""
        self.has_ended = self.is_over = True
        self.tell()

    def say(self, word: str) -> None:
        """A word to all; empty takes it back. Raises InputError."""
        text = " ".join(word.split())
        if len(text) > LONGEST_WORD or not text.isprintable():
            raise InputError(
                f"a word to all has at most {LONGEST_WORD} letters that can be printed"
            )
        self.word = text
        self.tell()
