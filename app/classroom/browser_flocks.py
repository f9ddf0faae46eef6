"""Flocks in students' browsers: a process compiles and writes pages, the class serves them.

Whatever a page then says is only values of sliders, and which step of the lesson its flock began
with; its run is made anew by the class.
"""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from app.classroom.collect.question import Question
from app.classroom.student import Student
from app.classroom.workers.page_worker import PageWorker, StudentPage
from app.classroom.workers.worker_process import WorkerProcess
from app.processes import ChildError, ProcessLostError
from app.studies.run_axes import is_whole_axis
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_steps import SceneStep, step_spec
from app.viewer.lab.sweeps.sweep_request import allowed
from worlds.input_error import InputError, unknown

MOST_MODULES = 16
"""That are kept: one for each model and kind of world that the class has begun with."""
MOST_WATCHING = 200
"""Students who look at the teacher's flock at once, which the class sends them as pictures."""
COMPILING = "the students' page is being compiled: some ten seconds"


class BrowserFlocks:
    """The pages of one class; on one event loop."""

    def __init__(self) -> None:
        self.process = WorkerProcess(PageWorker, restarts=True)
        self.modules: dict[str, bytes] = {}
        """By their names, packed by gzip."""
        self.progress = COMPILING
        """What is being compiled, in words; empty: nothing is."""
        self.name = secrets.token_hex(4)
        """Of this class while it runs: after a restart all pages are loaded anew."""

    async def close(self) -> None:
        """End the process."""
        await self.process.close()

    async def compile(self, scene: SavedScene) -> None:
        """Compile what a scene runs, so that pages of it are written in milliseconds. Raises
        InputError for what cannot run in a browser."""
        self.progress = COMPILING
        try:
            await self.keep_module(await self.have("compile", scene.to_toml()))
        finally:
            self.progress = ""

    def is_waiting(self, student: Student) -> bool:
        """Whether a student's page is written only once something has been compiled."""
        return student.page is None and bool(self.progress)

    def flock_of(self, student: Student) -> str:
        """What tells a page whether it still has the student's flock; empty: wait."""
        return "" if self.is_waiting(student) else f"{self.name}.{student.begun}"

    async def page_of(self, student: Student, question: Question | None) -> StudentPage:
        """The page of a student whose `scene` is known. Raises InputError.

        It is written once for each beginning, whether or not the page that asked still waits.
        """
        async with student.opening:
            while student.page is None:
                begun = student.begun
                said = {"flock": f"{self.name}.{begun}", "name": student.name}
                page: StudentPage = await self.have("write", student.scene, question, said)
                await self.keep_module(page.module)
                if student.begun == begun:  # else the flock began anew meanwhile
                    student.page = page
            return student.page

    async def keep_module(self, name: str) -> None:
        """Have a module at hand; the oldest goes."""
        if name not in self.modules:
            self.modules[name] = await self.have("module", name)
            for oldest in list(self.modules)[:-MOST_MODULES]:
                del self.modules[oldest]

    async def have(self, name: str, *given: Any) -> Any:
        """What the process answers. Raises InputError."""
        try:
            return await self.process.do(name, *given)
        except ProcessLostError:
            raise InputError("the process that writes pages was ended: try again") from None
        except ChildError as error:
            raise InputError(f"this flock cannot run in a browser: {error}") from None


def moved_scene(
    student: Student, page: StudentPage, values: Mapping[str, float], step: SceneStep | None = None
) -> str:
    """The scene of a student, TOML, with what their sliders say. Raises InputError for a value that
    no slider of their page has.

    `step`: the step of the lesson that their flock began with. What it sets beside sliders, such as
    the number of agents, is the flock's too.
    """
    scene = SavedScene.from_toml(student.scene, f"the flock of {student.name}")
    spec = scene.spec if step is None else step_spec(scene.spec, step)
    parameters = spec.all_parameters
    for name, value in values.items():
        if name not in page.sliders:
            raise unknown("slider", name, page.sliders)
        low, high = allowed(spec.model, name)
        if not low <= value <= high:
            raise InputError(f"{name} = {value:g} is not in [{low:g}, {high:g}]")
        parameters[name] = round(value) if is_whole_axis(spec.model, name) else value
    return replace(scene, spec=spec.with_parameters(parameters)).to_toml()
