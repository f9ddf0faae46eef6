"""A class: who is in it, in what role, and which laboratory each of them sees.

All of it runs on one event loop. What takes long is done in worker processes; one of them has the
teacher's laboratory alone, so that nothing that students do makes it wait.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from agents.catalogue import model as find_model
from agents.home import find_world
from app.classroom.asking import Asking
from app.classroom.keys import hashed, new_code, new_key, same
from app.classroom.names import student_name, unique_name
from app.classroom.student import Place, Role, Student
from app.classroom.workers.process import Gone, WorkerProcess
from app.classroom.workers.seen import Seen
from app.classroom.workers.worker import Laboratories
from app.experiments.workers.processes import cores
from app.results import RESULTS
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.run.allowance import Allowance
from worlds.refusal import Refusal

TEACHER = 0
"""The number of the teacher's laboratory; students count from 1."""
WAITS = 300.0
"""Seconds that the flock of a student waits whose line broke; then it is kept as a scene."""
UNUSED = 60.0
"""Seconds after which a seat is free again that somebody took without ever opening the page."""
LOOK = 2.0
"""Seconds between two looks at all laboratories."""
LONGEST_WORD = 200
"""Letters of a word to all."""


PICTURES, MANY, OF_MANY = 15.0, 20, 10.0
"""Pictures a second of a student's flock, for so many students, and of more."""
LEAST, MOST = 0.1, 0.15
"""Share of a core for one student's flock, and as much for drawing it."""


def allowance(scene: SavedScene, seats: int) -> Allowance:
    """What each student's flock may take: the scene of the class in any case."""
    model = find_model(scene.spec.model)
    agents = scene.spec.agents or model.agents
    beside = 1 if scene.beside is None else 2
    return Allowance(
        agents=max(Allowance.agents, beside * agents),
        obstacles=max(Allowance.obstacles, len(find_world(scene.spec, model).obstacles)),
        share=min(max(LEAST, cores() / seats), MOST),
        pictures=PICTURES,
    )


class Classroom:
    """One class. `seats`: students at most. `workers`: processes for their flocks. `results`: the
    folder of sweeps."""

    def __init__(
        self, scene: SavedScene, seats: int = 40, workers: int = 2, results: Path = RESULTS
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
        self.first_role = Role.WATCHING
        """What new students do."""
        self.asking = Asking(results)
        self.allowance = allowance(scene, seats)
        """What each student's flock may take."""
        self.word = ""
        self.frozen = False
        self.is_over = False
        self.seen: dict[int, Seen] = {}
        self.count = workers
        self.workers: list[WorkerProcess] = []
        self.own: WorkerProcess | None = None
        """The worker of the teacher's laboratory."""
        self.teacher_place: Place | None = None
        self.watching_place: Place | None = None
        self.tasks: set[asyncio.Task[None]] = set()
        self.listeners: set[Callable[[], None]] = set()
        """Called when something has changed that pages should be told."""

    # Its processes.

    async def open(self) -> None:
        """Begin the processes and the teacher's laboratory. Raises Refusal."""
        self.own = await WorkerProcess(self.has_ended).begin()
        self.workers = [await self.new_worker() for _ in range(self.count)]
        await self.open_teacher()
        self.task(self.look())

    async def new_worker(self) -> WorkerProcess:
        """Begin a process for students' flocks."""
        return await WorkerProcess(self.has_ended, Laboratories, self.allowance).begin()

    async def open_teacher(self) -> None:
        """Open the teacher's laboratory, and the page of those who watch it."""
        assert self.own is not None
        port = await self.own.ask("open", TEACHER, self.scene.to_toml())
        self.teacher_place = Place(self.own, port)
        self.watching_place = Place(self.own, await self.own.ask("watch", TEACHER))

    async def close(self) -> None:
        """End all processes."""
        self.is_over = True
        self.tell()
        for task in self.tasks:
            task.cancel()
        processes = [one for one in (*self.workers, self.own) if one]
        await asyncio.gather(self.asking.close(), *(one.close() for one in processes))

    def task(self, work: object) -> None:
        """Have something done beside all else."""
        task = asyncio.get_running_loop().create_task(work)  # type: ignore[arg-type, var-annotated]
        self.tasks.add(task)
        task.add_done_callback(self.tasks.discard)

    def has_ended(self, worker: WorkerProcess) -> None:
        """A process has died: begin another; pages connect to new laboratories by themselves."""
        for student in self.students.values():
            if student.place is not None and student.place.worker is worker:
                student.place = student.worker = None
                self.move(student)
        if not self.is_over:
            self.task(self.begin_again(worker))

    async def begin_again(self, worker: WorkerProcess) -> None:
        """Another process in place of one that has died."""
        if worker is self.own:
            self.own = await WorkerProcess(self.has_ended).begin()
            await self.open_teacher()
            self.move_watchers()
        else:
            self.workers[self.workers.index(worker)] = await self.new_worker()
        self.tell()

    # Who is in it.

    def admit(self, code: str, name: str) -> tuple[Student, str]:
        """Take a student in who gives the code; the student, and their cookie. Raises Refusal."""
        if self.is_over:
            raise Refusal("this class is over")
        if not same(code, self.code):
            raise Refusal("this is not the code of the class: look at the wall again")
        self.free_seats()
        chosen = student_name(name)
        kept = next((s for s in self.students.values() if s.name == chosen and not s.key), None)
        if kept is not None:  # of a class that has been opened again
            return kept, self.give_key(kept)
        if len(self.students) >= self.seats:
            raise Refusal(f"all {self.seats} seats of this class are taken")
        number = max(self.students, default=0) + 1
        chosen = unique_name(chosen, (one.name for one in self.students.values()))
        student = Student(number, chosen, "", self.first_role, frozen=self.frozen)
        self.students[number] = student
        return student, self.give_key(student)

    def give_key(self, student: Student) -> str:
        """A cookie for a student who has none."""
        cookie = new_key()
        student.key = hashed(cookie)
        self.by_key[student.key] = student
        self.tell()
        return cookie

    def free_seats(self) -> None:
        """Take back the seats of those who never came."""
        now = time.monotonic()
        for student in list(self.students.values()):
            if not student.came and now - student.left > UNUSED:
                self.forget(student)

    def forget(self, student: Student) -> None:
        """Take a student out of the class; their page is told."""
        self.students.pop(student.number, None)
        self.by_key.pop(student.key, None)
        self.leave_place(student)
        if self.asking.open is not None:
            self.asking.open.take_back(student.name)
        self.tell()

    def student_of(self, cookie: str) -> Student | None:
        """Whose cookie it is."""
        return self.by_key.get(hashed(cookie)) if cookie else None

    def admit_teacher(self, key: str) -> str:
        """A cookie for who has the teacher's key. Raises Refusal."""
        if not self.is_key(key):
            raise Refusal("this is not the teacher's key")
        if not same(key, self.key):
            self.first_key = ""
        cookie = new_key()
        self.teachers.add(hashed(cookie))
        return cookie

    def is_key(self, key: str) -> bool:
        """Whether it opens the teacher's page."""
        return bool(key) and (same(key, self.key) | same(key, self.first_key))

    def is_teacher(self, cookie: str) -> bool:
        """Whether it is a cookie of the teacher's."""
        return bool(cookie) and hashed(cookie) in self.teachers

    def renew(self) -> None:
        """Give the class another code; who is in it stays."""
        self.code = new_code()
        self.tell()

    def student_at(self, text: str) -> Student:
        """The student whose number stands in an address. Raises Refusal."""
        found = self.students.get(int(text)) if text.isdecimal() and len(text) < 9 else None
        if found is None:
            raise Refusal("that student is not in the class any more")
        return found

    # What each of them sees.

    async def place_of(self, student: Student) -> Place:
        """The laboratory that a student sees; their own is opened if need be. Raises Refusal."""
        if student.role is Role.WATCHING:
            if self.watching_place is None:
                raise Refusal("the teacher's flock is just beginning")
            return self.watching_place
        async with student.opening:
            if student.place is None:
                student.place = await self.open_own(student)
            return student.place

    async def open_own(self, student: Student) -> Place:
        """Open a student's own laboratory, on what they ran last or on the class's scene."""
        worker = student.worker = min(self.workers, key=self.crowd)
        scene = student.scene or self.first_scene(student, self.scene)
        try:
            port = await worker.ask("open", student.number, scene)
            if student.frozen:
                await worker.ask("pause", student.number)
        except Gone:
            raise Refusal("your flock is just beginning again") from None
        return Place(worker, port)

    def crowd(self, worker: WorkerProcess) -> int:
        """Laboratories that a worker has or is about to have."""
        return sum(one.worker is worker for one in self.students.values())

    def first_scene(self, student: Student, scene: SavedScene) -> str:
        """What a student begins with, TOML: a scene with a seed of their own.

        While a question is asked about it, it has their value.
        """
        asked = self.asking.begins(student.name, scene)
        if asked is None:
            seed = (scene.spec.seed or 0) + student.number
            asked = replace(scene, spec=scene.spec.but(seed=seed))
        return asked.to_toml()

    def connect(self, student: Student) -> None:
        """A page of a student's has connected."""
        student.lines += 1
        student.came = True
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

    def move_watchers(self) -> None:
        """Have the pages of all who watch connect anew."""
        for student in self.students.values():
            if student.role is Role.WATCHING:
                self.move(student)

    def tell(self) -> None:
        """Tell all pages that something has changed."""
        for listener in list(self.listeners):
            listener()

    # What the teacher does.

    def chosen(self, numbers: Iterable[int] | None) -> list[Student]:
        """Students by their numbers; all for None. Raises Refusal for a number nobody has."""
        if numbers is None:
            return list(self.students.values())
        found = [self.students.get(number) for number in numbers]
        if None in found:
            raise Refusal("that student is not in the class any more")
        return [one for one in found if one is not None]

    def give_role(self, role: Role, numbers: Iterable[int] | None = None) -> None:
        """Let students watch, or have flocks of their own; new ones too if it is said of all."""
        if numbers is None:
            self.first_role = role
        for student in self.chosen(numbers):
            if student.role is not role:
                student.role = role
                self.move(student)

    async def start_from(self, scene: SavedScene, numbers: Iterable[int] | None = None) -> None:
        """Have students begin with a scene, each with a seed of their own; a question is over."""
        self.allowance.demand(scene.spec, scene.beside, None)
        if numbers is None:
            self.scene = scene
            self.asking.end()
        await self.begin_anew(self.chosen(numbers), scene)

    async def ask(self, values: object) -> str:
        """Ask a question: all begin anew, each with a value of their own. Raises Refusal."""
        question = await self.asking.ask(values, self.scene)
        self.first_role = Role.OWN
        await self.begin_anew(self.chosen(None), self.scene)
        return f"asked: {question.title}"

    async def begin_anew(self, students: Iterable[Student], scene: SavedScene) -> None:
        """Have students begin with a scene, in flocks of their own."""
        for student in students:
            student.scene = self.first_scene(student, scene)
            if student.place is not None:
                try:
                    await student.place.worker.ask("open", student.number, student.scene)
                    if student.frozen:
                        await student.place.worker.ask("pause", student.number)
                except Gone:
                    student.place = None  # it is opened when their page asks for it
            if student.role is not Role.OWN:
                student.role = Role.OWN
                self.move(student)
        self.tell()

    async def hand_in(self, student: Student) -> str:
        """Take a student's run as an answer; the result in a sentence. Raises Refusal."""
        if student.role is not Role.OWN or student.place is None:
            raise Refusal("only who has a flock of their own hands in a result")
        try:
            ran = await student.place.worker.ask("scene", student.number)
        except Gone:
            raise Refusal("your flock is just beginning again") from None
        student.scene = ran
        collection = self.asking.demand()
        point = await self.asking.hand_in(student.name, ran)
        self.tell()
        return point.told(collection.question)

    async def open_point(self, number: int) -> str:
        """Open the run of a result in the teacher's laboratory. Raises Refusal."""
        scene = self.asking.point(number)
        assert self.own is not None
        try:
            await self.own.ask("open", TEACHER, scene.to_toml())
        except Gone:
            raise Refusal("your flock is just beginning again") from None
        return f"opened in your flock: {scene.title}"

    async def teachers_scene(self) -> SavedScene:
        """What the teacher's laboratory runs now. Raises Refusal."""
        assert self.own is not None
        try:
            return SavedScene.from_toml(await self.own.ask("scene", TEACHER), "the teacher's run")
        except Gone:
            raise Refusal("the teacher's flock is just beginning again") from None

    async def freeze(self, frozen: bool, numbers: Iterable[int] | None = None) -> None:
        """Hold flocks, or let them go on."""
        if numbers is None:
            self.frozen = frozen
        for student in self.chosen(numbers):
            student.frozen = frozen
            if student.place is not None:
                try:
                    await student.place.worker.ask("pause" if frozen else "go", student.number)
                except Gone:
                    continue
        self.tell()

    def say(self, word: str) -> None:
        """A word to all; empty takes it back. Raises Refusal."""
        text = " ".join(word.split())
        if len(text) > LONGEST_WORD or not text.isprintable():
            raise Refusal(f"a word to all has at most {LONGEST_WORD} letters that can be printed")
        self.word = text
        self.tell()

    # What goes on by itself.

    async def look(self) -> None:
        """Now and then: see how all laboratories stand, keep their scenes, close those left."""
        while True:
            await asyncio.sleep(LOOK)
            await self.draw_by_number()
            await asyncio.gather(*(self.look_at(one) for one in (*self.workers, self.own) if one))
            for student in self.students.values():
                if not student.is_here and time.monotonic() - student.left > WAITS:
                    self.leave_place(student)
            self.tell()

    async def draw_by_number(self) -> None:
        """Draw fewer pictures a second where there are many students."""
        here = sum(one.is_here and one.role is Role.OWN for one in self.students.values())
        pictures = PICTURES if here <= MANY else OF_MANY
        if pictures != self.allowance.pictures:
            self.allowance = replace(self.allowance, pictures=pictures)
            for worker in self.workers:
                with suppress(Gone):
                    await worker.ask("draw_at", pictures)

    async def look_at(self, worker: WorkerProcess) -> None:
        """See how the laboratories of a process stand, and keep their scenes."""
        try:
            self.seen.update(await worker.ask("seen"))
            changed: dict[int, str] = await worker.ask("changed")
        except (Gone, RuntimeError):
            return  # another process is about to begin
        for number, scene in changed.items():
            student = self.students.get(number)
            if student is not None and student.worker is worker:
                student.scene = scene

    def leave_place(self, student: Student) -> None:
        """Close a student's laboratory; what it ran is kept as a scene."""
        place, student.place, student.worker = student.place, None, None
        self.seen.pop(student.number, None)
        if place is not None:
            self.task(self.close_one(place.worker, student.number))

    async def close_one(self, worker: WorkerProcess, number: int) -> None:
        """Close a laboratory."""
        try:
            await worker.ask("close", number)
        except (Gone, RuntimeError):
            return
