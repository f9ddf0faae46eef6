"""The flocks of a class: processes with laboratories, and which of them each student sees.

The teacher's laboratory has a process of its own, so that nothing that students do makes it wait.
A process that dies is replaced; what ran in it begins again from its last scene.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

from agents.catalogue import model as find_model
from agents.flock_world import find_world
from app.classroom.student import LaboratoryAddress, Role, Student
from app.classroom.workers.laboratory_status import LaboratoryStatus
from app.classroom.workers.laboratory_worker import NICENESS, Laboratories
from app.classroom.workers.worker_process import WorkerProcess
from app.processes import ChildError, ProcessLostError
from app.studies.workers.process_executor import cores
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.panels.step_progress import LessonLead
from app.viewer.run.allowance import Allowance
from worlds.input_error import InputError

TEACHER = 0
"""The number of the teacher's laboratory; students count from 1."""
PICTURES, MANY, OF_MANY = 16.0, 20, 10.5
"""Pictures a second of a student's flock, for so many students, and of more."""
LEAST, MOST = 0.1, 0.15
"""Share of a core for one student's flock, and as much for drawing it."""
BEGINS = "the teacher's flock is just beginning"


def allowance(scene: SavedScene, seats: int) -> Allowance:
    """What each student's flock may take: the scene of the class in any case."""
    model = find_model(scene.spec.model)
    beside = 1 if scene.beside is None else 2
    return Allowance(
        agents=max(Allowance.agents, beside * scene.spec.agents),
        obstacles=max(Allowance.obstacles, len(find_world(scene.spec, model).obstacles)),
        share=min(max(LEAST, cores() / seats), MOST),
        pictures=PICTURES,
    )


class Flocks:
    """Those of one class; on one event loop.

    `count`: processes for students' flocks, of which each may take what `allowance` says; none
    where flocks run in browsers. `ended` is called when a process has died, and when the teacher's
    has been begun again. `lead` says how the class leads a student through its lesson now.
    """

    def __init__(
        self,
        count: int,
        allowance: Allowance,
        ended: Callable[[WorkerProcess], None],
        lead: Callable[[Student], LessonLead],
    ):
        self.count = count
        self.allowance = allowance
        self.ended = ended
        self.lead = lead
        self.workers: list[WorkerProcess] = []
        self.own: WorkerProcess | None = None
        """The process of the teacher's laboratory."""
        self.first = ""
        """What the teacher's laboratory begins with, TOML."""
        self.teacher: LaboratoryAddress | None = None
        self.watching: LaboratoryAddress | None = None
        """The page of those who watch the teacher's run."""
        self.seen: dict[int, LaboratoryStatus] = {}
        """How each laboratory stood when it was looked at last."""
        self.tasks: set[asyncio.Task[Any]] = set()
        self.closing = False

    async def open(self, scene: SavedScene) -> None:
        """Begin the processes and the teacher's laboratory. Raises InputError."""
        self.first = scene.to_toml()
        self.begin_workers(self.count)
        await self.open_teacher()

    def begin_workers(self, count: int) -> None:
        """Begin so many processes for students' flocks."""
        self.workers = [self.new_worker() for _ in range(count)]

    async def close(self) -> None:
        """End all processes."""
        self.closing = True
        for task in self.tasks:
            task.cancel()
        await asyncio.gather(*(one.close() for one in (*self.workers, self.own) if one))

    def new_worker(self) -> WorkerProcess:
        """A process for students' flocks."""
        worker = WorkerProcess(
            Laboratories, self.allowance, niceness=NICENESS, ended=self.has_ended
        )
        worker.start()
        return worker

    async def open_teacher(self) -> WorkerProcess:
        """Open the teacher's laboratory, and the page of those who watch it, in a new process."""
        self.own = own = WorkerProcess(Laboratories, ended=self.has_ended)
        self.teacher = LaboratoryAddress(own, await own.do("open", TEACHER, self.first))
        self.watching = LaboratoryAddress(own, await own.do("watch", TEACHER))
        return own

    def task[T](self, work: Coroutine[Any, Any, T]) -> asyncio.Task[T]:
        """Have something done, whoever waits for it or waits no more."""
        task = asyncio.get_running_loop().create_task(work)
        self.tasks.add(task)
        task.add_done_callback(self.tasks.discard)
        return task

    def has_ended(self, worker: WorkerProcess) -> None:
        """A process has died: begin another; pages connect to new laboratories by themselves."""
        if self.closing:
            return
        if worker is self.own:
            self.task(self.open_teacher_again())
        else:
            self.workers[self.workers.index(worker)] = self.new_worker()
        self.ended(worker)

    async def open_teacher_again(self) -> None:
        """Open the teacher's laboratory anew; pages that wait for it connect to it."""
        self.ended(await self.open_teacher())

    # What each student sees.

    def shown(self, student: Student) -> LaboratoryAddress | None:
        """The laboratory that a student sees, if it is open."""
        return self.watching if student.role is Role.WATCHING else student.place

    async def place_of(self, student: Student, first: Callable[[], str]) -> LaboratoryAddress:
        """The laboratory that a student sees; their own is opened if need be. Raises InputError.

        `first` makes the scene of one who has had none.
        """
        if student.role is Role.WATCHING:
            if self.watching is None:
                raise InputError(BEGINS)
            return self.watching
        return await asyncio.shield(self.task(self.own_place(student, first)))

    async def own_place(self, student: Student, first: Callable[[], str]) -> LaboratoryAddress:
        """A student's own laboratory, whether or not the page that first asked still waits."""
        async with student.opening:
            if student.place is None or student.place.worker.is_gone:
                student.place = await self.open_own(student, student.scene or first())
            return student.place

    async def open_own(self, student: Student, scene: str) -> LaboratoryAddress:
        """Open a student's own laboratory, in the process with the fewest. Raises InputError."""
        worker = student.worker = min(self.workers, key=lambda one: one.held)
        worker.held += 1
        try:
            address = await self.tell(worker, "open", student.number, scene, student.kind)
            await self.catch_up(worker, student)
            if student.worker is not worker:
                raise InputError("this flock has been closed")
        except Exception:
            self.drop(worker, student)
            raise
        return LaboratoryAddress(worker, address)

    async def catch_up(self, worker: WorkerProcess, student: Student) -> None:
        """Hold a laboratory that has just been opened, and lead it, as the class is now.

        The class may change while the process answers: nobody else tells a laboratory that has no
        place yet.
        """
        is_held, lead = False, LessonLead()
        while (is_held, lead) != (student.frozen, self.lead(student)):
            if is_held != student.frozen:
                is_held = student.frozen
                await self.tell(worker, "pause" if is_held else "go", student.number)
            else:
                lead = self.lead(student)
                await self.tell(worker, "lead", student.number, lead)

    async def tell(self, worker: WorkerProcess, what: str, *given: Any) -> Any:
        """What a process answers. Raises InputError if it is gone."""
        try:
            return await worker.do(what, *given)
        except ProcessLostError:
            raise InputError("the flock is just beginning again") from None

    async def tell_own(self, student: Student, what: str, *given: Any) -> Any:
        """What a student's own laboratory answers. Raises InputError if there is none."""
        if student.place is None:
            raise InputError("only who has a flock of their own can do that")
        return await self.tell(student.place.worker, what, student.number, *given)

    async def tell_teacher(self, what: str, *given: Any) -> Any:
        """What the teacher's laboratory answers. Raises InputError."""
        if self.own is None:
            raise InputError(BEGINS)
        return await self.tell(self.own, what, TEACHER, *given)

    def leave(self, student: Student) -> None:
        """Close a student's laboratory; what it ran is kept as a scene."""
        place, student.place, student.worker = student.place, None, None
        self.seen.pop(student.number, None)
        if place is not None:
            self.drop(place.worker, student)

    def drop(self, worker: WorkerProcess, student: Student) -> None:
        """Have a process close a student's laboratory."""
        worker.held -= 1
        self.task(self.close_one(worker, student.number))

    async def close_one(self, worker: WorkerProcess, number: int) -> None:
        """Close a laboratory."""
        with suppress(ProcessLostError, ChildError):
            await worker.do("close", number)

    # How they stand.

    async def look(self, students: Mapping[int, Student]) -> None:
        """See how all laboratories stand, keep their scenes, and draw them by their number."""
        here = sum(one.is_here and one.role is Role.OWN for one in students.values())
        pictures = PICTURES if here <= MANY else OF_MANY
        if pictures != self.allowance.pictures:
            self.allowance = replace(self.allowance, pictures=pictures)
            for worker in self.workers:
                with suppress(ProcessLostError, ChildError):
                    await worker.do("draw_at", pictures)
        processes = [one for one in (*self.workers, self.own) if one is not None]
        await asyncio.gather(*(self.look_at(one, students) for one in processes))

    async def look_at(self, worker: WorkerProcess, students: Mapping[int, Student]) -> None:
        """See how the laboratories of a process stand, and keep their scenes."""
        try:
            self.seen.update(await worker.do("seen"))
            changed: dict[int, str] = await worker.do("changed")
        except (ProcessLostError, ChildError):
            return  # another process is about to begin
        for number, scene in changed.items():
            student = students.get(number)
            if student is not None and student.worker is worker:
                student.scene = scene
