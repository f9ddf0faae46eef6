"""A class whose flocks run on the server is led through its lesson as one in browsers is."""

from __future__ import annotations

import asyncio
import csv
import io
import os
import signal
import time
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from app.classroom import classroom, flocks
from app.classroom.class_keeper import restore_class, state_of
from app.classroom.classroom import Classroom
from app.classroom.front.teacher_requests import TeacherRequests
from app.classroom.lesson_prediction import LessonPrediction
from app.classroom.student import Role, Student
from app.classroom.workers.laboratory_worker import Laboratories
from app.viewer.gallery.saved_scene import SavedScene
from tests.classroom.running import BUSY, SCENE
from tests.classroom.test_class_lessons import STEPS
from worlds.input_error import InputError

LESSON = "speed = 1000\n" + SCENE + STEPS


class PressedLaboratories(Laboratories):
    """Laboratories whose buttons are pressed from here."""

    def predict(self, whose: int, choice: int) -> None:
        """Choose an answer of the step that is shown, and run it."""
        panel = self.all[whose].lesson
        asyncio.run(panel.choose(choice, None))  # type: ignore[arg-type]
        asyncio.run(panel.begin(None))  # type: ignore[arg-type]

    def go_to(self, whose: int, number: int) -> None:
        """Go to a step by oneself."""
        panel = self.all[whose].lesson
        with panel.lock:
            panel.number = number - 1
            panel.show()

    def lesson_of(self, whose: int) -> tuple[int, int, int]:
        """How many steps one has, which is shown, from 1, and which the class shows; 0: none."""
        panel = self.all[whose].lesson
        with panel.lock:
            return len(panel.steps), panel.number + 1, panel.led

    def process_number(self) -> int:
        """The number of the process."""
        return os.getpid()


async def until(holds: Callable[[], bool]) -> None:
    """Wait until something holds."""
    end = time.monotonic() + BUSY
    while not holds():
        assert time.monotonic() < end
        await asyncio.sleep(0.05)


async def until_told(what: Callable[[], Awaitable[Any]], wanted: object) -> None:
    """Wait until what a process answers is what is wanted."""
    end, answer = time.monotonic() + BUSY, None
    while answer != wanted:
        assert time.monotonic() < end, (answer, wanted)
        answer = await what()
        await asyncio.sleep(0.02)


@pytest.fixture
def run_class(tmp_path, monkeypatch):
    """Runs a scenario with a class on the server."""
    monkeypatch.setattr(classroom, "LOOK", 0.2)
    monkeypatch.setattr(flocks, "Laboratories", PressedLaboratories)

    def run(scenario, made: Classroom | None = None) -> None:
        room = made or Classroom(SavedScene.from_toml(LESSON, "lesson.toml"), 4, 1, tmp_path)
        room.first_role = Role.OWN

        async def whole() -> None:
            await room.open()
            try:
                await scenario(room)
            finally:
                await room.close()

        asyncio.run(whole())

    return run


async def come(room: Classroom, name: str) -> Student:
    """A student who has come, and whose flock is open on the lesson."""
    student, _ = room.admit(room.code, name)
    await open_flock(room, student)
    return student


async def open_flock(room: Classroom, student: Student) -> None:
    """Have a student's flock opened, until it shows the lesson."""
    room.connect(student)
    await room.place_of(student)
    end = time.monotonic() + BUSY
    while not (await lesson_of(room, student))[0]:
        assert time.monotonic() < end
        await asyncio.sleep(0.02)


async def lesson_of(room: Classroom, student: Student) -> tuple[int, int, int]:
    """Steps, the one that is shown, and the one that the class shows."""
    return await room.flocks.tell_own(student, "lesson_of")


def shown_to_teacher(room: Classroom) -> dict[str, Any]:
    """The lesson on the teacher's page."""
    found = TeacherRequests(room, []).roster()["lesson"]
    assert found is not None
    return found


def test_all_flocks_show_the_step_of_the_teacher_and_those_that_open_later_too(run_class):
    async def scenario(room: Classroom) -> None:
        ada = await come(room, "Ada")
        assert await lesson_of(room, ada) == (3, 1, 0)
        await room.show_step(3)
        assert await lesson_of(room, ada) == (3, 3, 3)
        bo = await come(room, "Bo")
        assert await lesson_of(room, bo) == (3, 3, 3)
        assert shown_to_teacher(room)["step"] == 3
        await room.begin_anew([ada], room.scene)
        await until_told(lambda: lesson_of(room, ada), (3, 3, 3))
        await room.show_step(0)
        assert await lesson_of(room, ada) == (3, 3, 0)
        with pytest.raises(InputError, match="step = 4 is not allowed: 0 to 3"):
            await room.show_step(4)

    run_class(scenario)


def test_a_step_that_changes_while_a_flock_opens_is_the_one_it_shows(run_class):
    async def scenario(room: Classroom) -> None:
        ada, _ = room.admit(room.code, "Ada")
        tell, changes = room.flocks.tell, [(2, True), (3, False)]

        async def tell_late(worker, what, *given):
            answer = await tell(worker, what, *given)
            # The class goes on after the process was told, and before anybody knows the place.
            if what in ("open", "lead") and given[0] == ada.number and changes:
                step, frozen = changes.pop(0)
                assert ada.place is None
                await room.show_step(step)
                await room.freeze(frozen)
            return answer

        room.flocks.tell = tell_late
        await open_flock(room, ada)
        assert not changes
        assert await lesson_of(room, ada) == (3, 3, 3)
        await until(lambda: ada.number in room.flocks.seen)
        await until(lambda: room.flocks.seen[ada.number].running)

    run_class(scenario)


def test_a_flock_whose_process_died_is_led_again_and_its_prediction_stays(run_class):
    async def scenario(room: Classroom) -> None:
        ada = await come(room, "Ada")
        await room.show_step(2)
        await room.flocks.tell_own(ada, "predict", 1)
        await until(lambda: 2 in ada.predictions and ada.predictions[2].shown is not None)
        before = ada.predictions[2]
        gone = ada.place.worker
        os.kill(await room.flocks.tell(gone, "process_number"), signal.SIGKILL)
        await until(lambda: gone.is_gone)
        await open_flock(room, ada)
        assert ada.place.worker is not gone
        assert await lesson_of(room, ada) == (3, 2, 2)
        await room.flocks.tell_own(ada, "predict", 0)
        status = (await room.flocks.tell(ada.place.worker, "seen"))[ada.number]
        assert status.predictions[0][:2] == (2, 1)  # the first choice stays in the laboratory too
        assert ada.predictions[2] == before

    run_class(scenario)


def test_predictions_are_counted_and_in_the_tables(run_class):
    async def scenario(room: Classroom) -> None:
        ada, bo = await come(room, "Ada"), await come(room, "Bo")
        await room.show_step(2)
        await room.flocks.tell_own(ada, "predict", 1)
        await room.flocks.tell_own(bo, "predict", 0)
        await until(
            lambda: all(2 in one.predictions and one.predictions[2].shown is not None
                        for one in (ada, bo))
        )  # fmt: skip
        shown = ada.predictions[2].shown
        counted = shown_to_teacher(room)["steps"][1]
        assert counted["predicted"] == [1, 1]
        assert sum(counted["shown"]) == 2
        words = room.scene.steps[1].choices
        rows = list(csv.DictReader(io.StringIO(room.predictions_csv())))
        assert rows[0] == {
            "student": "Ada",
            "step": "2",
            "predicted": words[1],
            "shown": words[shown],
        }
        assert (len(rows), rows[1]["predicted"]) == (2, words[0])

    run_class(scenario)


def test_a_prediction_beyond_the_step_of_the_class_counts_once_the_class_is_there(run_class):
    async def scenario(room: Classroom) -> None:
        ada = await come(room, "Ada")
        await room.flocks.tell_own(ada, "go_to", 2)
        await room.show_step(1)
        await room.flocks.tell_own(ada, "go_to", 2)  # as if it was pressed just before
        await room.flocks.tell_own(ada, "predict", 0)
        await until(lambda: bool(room.flocks.seen[ada.number].predictions))
        room.take_predictions()
        assert ada.predictions == {}
        await room.show_step(2)
        room.take_predictions()
        assert ada.predictions[2].choice == 0

    run_class(scenario)


def test_what_is_predicted_in_another_lesson_is_not_that_of_the_class(run_class):
    async def scenario(room: Classroom) -> None:
        ada = await come(room, "Ada")
        await room.show_step(2)
        other = LESSON.replace("Much noise.", "Very much noise.")
        await room.flocks.tell_own(ada, "open", other)
        await until_told(lambda: lesson_of(room, ada), (3, 1, 0))
        await room.flocks.tell_own(ada, "go_to", 2)
        await room.flocks.tell_own(ada, "predict", 0)
        await until(lambda: bool(room.flocks.seen[ada.number].predictions))
        room.take_predictions()
        assert ada.predictions == {}
        # The class goes over to that lesson: it begins anew, and nobody is led.
        await room.start_from(SavedScene.from_toml(other, "other.toml"))
        await until_told(lambda: lesson_of(room, ada), (3, 1, 0))
        assert (room.step, ada.predictions) == (0, {})
        await room.show_step(3)
        assert await lesson_of(room, ada) == (3, 3, 3)

    run_class(scenario)


def test_a_class_that_is_opened_again_goes_on_at_its_step(run_class, tmp_path):
    room = Classroom(SavedScene.from_toml(LESSON, "lesson.toml"), 4, 1, tmp_path)
    ida, _ = room.admit(room.code, "Ida")
    ida.role, room.step = Role.OWN, 2
    ida.predictions = {2: LessonPrediction(1, 0)}
    again = restore_class(state_of(room), tmp_path / "kept.zip", 1, tmp_path)

    async def scenario(opened: Classroom) -> None:
        (student,) = opened.students.values()
        await open_flock(opened, student)
        assert await lesson_of(opened, student) == (3, 2, 2)
        await until(lambda: student.number in opened.flocks.seen)
        assert student.predictions == {2: LessonPrediction(1, 0)}
        assert shown_to_teacher(opened)["steps"][1]["predicted"] == [0, 1]

    run_class(scenario, again)


def test_a_class_without_steps_has_none_to_show(run_class, tmp_path):
    async def scenario(room: Classroom) -> None:
        with pytest.raises(InputError, match="this class has no lesson with steps"):
            await room.show_step(1)
        assert TeacherRequests(room, []).roster()["lesson"] is None

    run_class(scenario, Classroom(SavedScene.from_toml(SCENE, "plain.toml"), 4, 1, tmp_path))
