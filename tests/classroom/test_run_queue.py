"""No student's runs take the others' time, whatever they hand in; the class is always kept."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import threading
import time

import pytest

from app.classroom import run_queue
from app.classroom.class_file import ClassState, SavedStudent, load
from app.classroom.question_service import QuestionService
from app.classroom.run_queue import RunQueue
from app.classroom.student import Role
from app.classroom.workers.measuring import MadeRun, ProcessorTimeLimit
from app.classroom.workers.worker_process import WorkerProcess
from app.processes import ProcessLostError, ProcessTimeoutError
from app.viewer.gallery.saved_scene import SavedScene, pack_scene
from app.viewer.run.run_preset import preset_spec
from tests.classroom.running import BUSY, COMPILES, roster, running
from tests.classroom.small import SCENE
from tests.viewer.waiting import until
from worlds.input_error import InputError

ASKED = {
    "title": "Order against agents",
    "parameter": "agents",
    "measure": {"observe": "polarisation", "over": 10},
    "ticks": 500,
    "values": [20.0, 30.0],
}
ENDLESS = preset_spec("squashing-best", agents=500, size=20.0, world="wrap")
"""Of few pairs, each of which takes it a thousand times what one takes other models."""
SLOW = preset_spec("hwvem", agents=2000, size=9.0)
"""As much as may be handed in: a few seconds of a core."""
NICE = 5
"""Niceness of the process for unusual runs: on a busy machine a nicer one would hardly run."""
SHORT = f"from app.classroom import run_queue as q; q.SECONDS, q.NICENESS = 2.0, {NICE}"
"""What a class does first whose runs are ended early."""


class Tasks:
    """Tasks of known length."""

    def echo(self, text):
        return text

    def sleep(self, seconds):
        time.sleep(seconds)

    def burn(self):
        with ProcessorTimeLimit(0.2):
            while True:
                pass

    def crash(self):
        os._exit(1)


def hand_in(person):
    """Hand in, however long that takes on a busy machine."""
    with contextlib.suppress(TimeoutError):
        person.send("/class/hand-in", {})


def noted(teacher):
    """What the teacher's page says of the runs of each student."""
    return {one["name"]: one["note"] for one in roster(teacher)["students"]}


def toml(spec):
    return SavedScene("A run", spec).to_toml()


def test_the_time_of_a_request_is_counted_from_when_the_worker_turns_to_it():
    async def asked():
        worker = WorkerProcess(Tasks)
        try:
            await worker.do("echo", "it is there", timeout=BUSY)
            each = [worker.do("sleep", 1.5, timeout=5.0) for _ in range(4)]
            await asyncio.gather(*each)  # six seconds in all
            assert await worker.do("echo", "and on time") == "and on time"
            with pytest.raises(ProcessTimeoutError):
                await worker.do("sleep", BUSY, timeout=0.5)
        finally:
            worker.kill()
            await worker.close()

    asyncio.run(asked())


@pytest.mark.parametrize(
    ("ends", "how"), [("burn", ProcessTimeoutError), ("crash", ProcessLostError)]
)
def test_a_task_that_is_ended_takes_no_other_with_it(ends, how):
    async def done():
        process = WorkerProcess(Tasks, restarts=True)
        try:
            asked = ["echo", ends, "echo", ends, "echo"]
            given = [(name, *(["x"] if name == "echo" else [])) for name in asked]
            found = await asyncio.gather(
                *(process.do(*one, timeout=BUSY) for one in given), return_exceptions=True
            )
        finally:
            await process.close()
        assert [one if one == "x" else type(one) for one in found] == ["x", how, "x", how, "x"]

    asyncio.run(done())


def test_of_those_who_wait_the_one_who_has_had_least_is_next():
    order = []

    async def asked(process, rank, seconds=0.0):
        await process.do("sleep", seconds, rank=rank)
        order.append(rank)

    async def done():
        process = WorkerProcess(Tasks, restarts=True)
        try:
            first = asyncio.create_task(asked(process, 9.0, 1.0))
            while process.pid is None:
                await asyncio.sleep(0.01)
            await asyncio.gather(first, *(asked(process, rank) for rank in (3.0, 2.0, 7.0, 2.0)))
        finally:
            await process.close()

    asyncio.run(done())
    assert order == [9.0, 2.0, 2.0, 3.0, 7.0]  # the first found nobody there


def test_those_who_wait_for_a_process_that_is_closed_hear_of_it():
    async def closed():
        process = WorkerProcess(Tasks, restarts=True)
        waiting = [asyncio.create_task(process.do("sleep", BUSY)) for _ in range(3)]
        while process.pid is None:
            await asyncio.sleep(0.01)
        await process.close()
        found = await asyncio.gather(*waiting, return_exceptions=True)
        assert [type(one) for one in found] == 3 * [ProcessLostError]

    asyncio.run(closed())


class SlowMeasure:
    """A process whose measure of a usual run ends when the test says so."""

    def __init__(self):
        self.measured = asyncio.Event()

    async def do(self, name, *_given, **_options):
        if name == "measure_usual":
            await self.measured.wait()
            return 0.1
        return MadeRun(name, 0.2)


def test_a_run_that_waits_is_made_though_the_teacher_asks_something_else_meanwhile():
    async def asked_again():
        queue = RunQueue()
        queue.usual = queue.slow = process = SlowMeasure()
        queue.begin("a question", SCENE)
        run = asyncio.create_task(queue.make("Ada", "a question", toml(SCENE), SCENE))
        await asyncio.sleep(0)
        queue.begin("another", SCENE)
        await asyncio.sleep(0)
        process.measured.set()
        assert await run == "make_usual"

    asyncio.run(asked_again())


@pytest.mark.parametrize("dishonest", [1, 3, 10])
def test_others_have_their_results_while_the_runs_of_some_never_end(
    dishonest, tmp_path, monkeypatch
):
    monkeypatch.setattr(run_queue, "SECONDS", 3.0)
    monkeypatch.setattr(run_queue, "NICENESS", NICE)
    names = [f"Eve {k}" for k in range(dishonest)]
    over = []

    async def handed(asking, name, spec):
        try:
            return await asking.hand_in(name, toml(spec))
        finally:
            over.append(name)

    async def honest(asking, number):
        for again in range(3):
            point = await handed(asking, f"Ada {number}", SCENE.but(seed=10 * number + again))
            assert point.status == "ok"

    async def attacked():
        asking = QuestionService(tmp_path / "results")
        scene = SavedScene("A class", SCENE)
        await asking.ask(ASKED, scene)
        evil = [asyncio.create_task(handed(asking, name, ENDLESS)) for name in names]
        slow = asyncio.create_task(handed(asking, "Slow", SLOW))
        try:
            await asyncio.gather(*(honest(asking, number) for number in range(4)))
            file = tmp_path / "class.zip"
            student = SavedStudent(Role.OWN, scene)
            state = ClassState("A class", scene, {"Ada": student}, list(asking.all))
            await asking.draw("save", state, file)
            assert await asking.picture("png")
            assert len(load(file).questions[0].points) == 12
            assert not set(over) & {*names}, over
            with pytest.raises(InputError, match="your last result is still being made"):
                await asking.hand_in(names[0], toml(ENDLESS))
            await asyncio.wait(evil, return_when="FIRST_COMPLETED")
            first = next(one for one in evil if one.done())
            name = names[evil.index(first)]
            assert str(first.exception()) == (
                "your run took more than 3 s of processor time and was ended: wait 10 s before "
                "the next"
            )
            assert asking.runs.note(name).startswith("a run took more than 3 s of processor")
            with pytest.raises(InputError, match=r"was refused or ended: hand in again in \d+ s"):
                await asking.hand_in(name, toml(ENDLESS))
            assert (await handed(asking, "Ada 1", SCENE)).status == "ok"
            assert {one.student for one in asking.demand().points} >= {f"Ada {k}" for k in range(4)}
        finally:
            for task in (*evil, slow):
                task.cancel()
            await asking.close()

    asyncio.run(attacked())


def test_a_page_that_is_left_has_no_second_run(tmp_path):
    async def left():
        asking = QuestionService(tmp_path / "results")
        await asking.ask(ASKED, SavedScene("A class", SCENE))
        try:
            first = asyncio.create_task(asking.hand_in("Eve", toml(SCENE)))
            await asyncio.sleep(0)
            first.cancel()
            with pytest.raises(InputError, match="your last result is still being made"):
                await asking.hand_in("Eve", toml(SCENE))
            while not asking.demand().points:
                await asyncio.wait(asking.handed, timeout=BUSY)
        finally:
            await asking.close()

    asyncio.run(left())


def test_the_pause_grows_and_runs_that_were_ended_count():
    queue = run_queue.RunQueue()
    record = queue.record("Eve")
    told = [str(queue.ended(record, "ended with its process")) for _ in range(7)]
    assert [float(one.split()[-5]) for one in told] == [10, 20, 40, 80, 160, 300, 300]
    assert "7 times so far" in queue.note("Eve")
    assert queue.note("Ada") == ""


def test_the_teacher_sees_whose_run_was_ended_and_why(tmp_path):
    with running(tmp_path, first=SHORT) as ours:
        teacher, ada, eve = ours.teacher(), ours.student("Ada"), ours.student("Eve")
        assert teacher.do("ask", question=ASKED | {"values": []}).status == 200
        with ada.connect(), eve.connect():
            scene = pack_scene(SavedScene("Endless", ENDLESS))
            marked = {"X-Flockscope": "scene", "Sec-Fetch-Site": "same-origin"}
            assert until(
                lambda: eve.ask(f"/open?scene={scene}&sure=1", headers=marked).status == 200, BUSY
            )
            until(lambda: "squashing" in json.loads(eve.ask("/scene.json").text)["command"], BUSY)
            waits = threading.Thread(target=hand_in, args=(eve,))
            waits.start()
            assert ada.send("/class/hand-in", {}).status == 200
            assert until(lambda: noted(teacher)["Eve"], COMPILES)
            again = eve.send("/class/hand-in", {})
            waits.join()
        assert (again.status, "hand in again in" in again.text) == (400, True), again.text
        assert noted(teacher) == {
            "Ada": "",
            "Eve": "a run took more than 2 s of processor time and was ended: "
            "waits 10 s before the next",
        }
        assert "is not kept" not in ours.stop()


def test_a_curve_that_begins_late_is_not_shown_with_the_next_question(tmp_path):
    async def late():
        asking = QuestionService(tmp_path / "results")
        begun = asyncio.Event()
        asked: list[str] = []

        async def have(_process, what, *_):
            asked.append(what)
            if what == "begin_curve":
                await begun.wait()
                return "vem-eta"
            return None

        asking.have = have
        try:
            scene = SavedScene("A class", SCENE)
            await asking.ask(ASKED, scene)
            made = asyncio.create_task(asking.make_curve())
            while "begin_curve" not in asked:
                await asyncio.sleep(0)
            await asking.ask(ASKED, scene)
            followed = asking.curves
            begun.set()
            assert (await made).endswith("for the question before: its curve is not shown")
            assert asking.curves is followed
        finally:
            await asking.close()

    asyncio.run(late())
