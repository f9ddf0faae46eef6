"""Makes the runs that students hand in so that no student's take the others' time.

A usual run, of no more work than the class was asked for, and any other are made by two processes.
The other kind has much more time and less of the machine, so that what takes long is made as well,
and nobody waits for it but those who hand in the like. In either who has had the least processor
time for this question is next. A student has one run at a time, and waits after one that was ended.
"""

from __future__ import annotations

import asyncio
import math
import time
from contextlib import suppress
from dataclasses import dataclass

from agents.spec import CompleteSpec
from app.classroom.collect.hand_in import SECONDS, Point
from app.classroom.collect.question import Question
from app.classroom.workers.measuring import MadeRun, QuestionRunWorker
from app.classroom.workers.worker_process import WorkerProcess
from app.processes import ProcessLostError, ProcessTimeoutError
from worlds.input_error import InputError

NICENESS = 15
"""Of the process for runs that are not usual: even flocks go before it."""
USUAL_SECONDS, USUAL_TIMES = 0.3, 3.0
"""Processor time of a usual run at most: seconds, and times what the question's dearest took."""
PAUSE, LONGEST_PAUSE = 10.0, 300.0
"""Seconds that a student waits after a run that was ended; twice as many after each further one."""
REFUSED_PAUSE = 3.0
"""Seconds after a run that was refused: to read what is wrong with it takes time as well."""


@dataclass
class RunRecord:
    """What a student's runs for one question have taken."""

    busy: bool = False
    """Whether one is being made; set by who has it made, before anything is waited for."""
    seconds: float = 0.0
    """Of processor time."""
    is_slow: bool = False
    """Whether one was no usual run though it looked like one: the next are not tried as such."""
    ended: int = 0
    """Runs that were ended."""
    free_at: float = 0.0
    """When the next may be handed in, s of the monotonic clock."""
    note: str = ""
    """What the teacher should know, in a line."""


class RunQueue:
    """For one class, and one question after the other; on one event loop."""

    def __init__(self) -> None:
        self.usual = WorkerProcess(QuestionRunWorker, restarts=True)
        self.slow = WorkerProcess(QuestionRunWorker, niceness=NICENESS, restarts=True)
        self.records: dict[str, RunRecord] = {}
        """By student."""
        self.usual_seconds: asyncio.Task[float] | None = None

    def begin(self, question: Question, scene: CompleteSpec) -> None:
        """Make runs for another question: compile them, and see what a usual one takes."""
        self.records = {}
        self.usual.first = ("warm_up", question, scene)
        # What is measured for the question before is not cancelled: students' runs wait for it.
        self.usual_seconds = asyncio.create_task(self.measure_usual(question, scene))

    async def measure_usual(self, question: Question, scene: CompleteSpec) -> float:
        """Processor time (s) that a usual run of a question may take."""
        took = SECONDS
        with suppress(Exception):  # what fails here fails in the runs too, and is told of those
            took = await self.usual.do("measure_usual", question, scene, SECONDS)
        return min(SECONDS, USUAL_SECONDS + USUAL_TIMES * took)

    async def close(self) -> None:
        """End the processes."""
        if self.usual_seconds is not None:
            self.usual_seconds.cancel()
        await asyncio.gather(self.usual.close(), self.slow.close())

    def record(self, student: str) -> RunRecord:
        """What a student's runs have taken."""
        return self.records.setdefault(student, RunRecord())

    def note(self, student: str) -> str:
        """What the teacher should know of a student's runs; empty for nothing."""
        found = self.records.get(student)
        return "" if found is None else found.note

    def demand_turn(self, student: str) -> None:
        """Refuse a run of a student who has one already, or has to wait. Raises InputError."""
        record = self.record(student)
        if record.busy:
            raise InputError("your last result is still being made")
        left = record.free_at - time.monotonic()
        if left > 0.0:
            raise InputError(
                f"your last run was refused or ended: hand in again in {math.ceil(left)} s"
            )

    async def make(self, student: str, question: Question, ran: str, scene: CompleteSpec) -> Point:
        """The result of a student's run, the scene `ran` as TOML. Raises InputError."""
        record = self.record(student)
        try:
            made = await self.try_usual(record, question, student, ran, scene)
            if made is None:
                made = await self.make_slow(record, question, student, ran, scene)
            record.seconds += made.seconds
            return made.point
        except InputError:
            record.free_at = max(record.free_at, time.monotonic() + REFUSED_PAUSE)
            raise
        finally:
            record.busy = False

    async def try_usual(
        self, record: RunRecord, question: Question, student: str, ran: str, scene: CompleteSpec
    ) -> MadeRun | None:
        """The result of a usual run; None for one that is not. Raises InputError."""
        if record.is_slow or self.usual_seconds is None:
            return None
        limit = await asyncio.shield(self.usual_seconds)
        try:
            made: MadeRun | None = await self.usual.do(
                "make_usual", question, student, ran, scene, limit, rank=record.seconds
            )
        except ProcessLostError:
            record.is_slow = True
            record.seconds += limit
            return None
        return made

    async def make_slow(
        self, record: RunRecord, question: Question, student: str, ran: str, scene: CompleteSpec
    ) -> MadeRun:
        """The result of any run. Raises InputError, and for one that is ended has the student
        wait."""
        try:
            made: MadeRun = await self.slow.do(
                "make_any", question, student, ran, scene, SECONDS, rank=record.seconds
            )
        except ProcessLostError as gone:
            why = (
                f"took more than {SECONDS:g} s of processor time and was ended"
                if isinstance(gone, ProcessTimeoutError)
                else "ended with its process"
            )
            record.seconds += SECONDS
            raise self.ended(record, why) from None
        return made

    def ended(self, record: RunRecord, why: str) -> InputError:
        """Note a run that was ended; what the student is told."""
        record.is_slow = True
        record.ended += 1
        pause = min(LONGEST_PAUSE, PAUSE * 2.0 ** (record.ended - 1))
        record.free_at = time.monotonic() + pause
        times = "" if record.ended == 1 else f", {record.ended} times so far"
        record.note = f"a run {why}{times}: waits {pause:g} s before the next"
        return InputError(f"your run {why}: wait {pause:g} s before the next")
