"""Runs in processes of their own that live as long as there is work: none of them ends the work.

A process that is killed is replaced, and the run that it was at is made once more; one that kills
its process twice is recorded as `killed`, and so is one that takes longer than it may. A process
that stands still, halted or hung as a whole, is killed; one that is slow shows that it lives.
"""

from __future__ import annotations

import math
import mmap
import os
import queue
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

from app.process_worker import ProcessLimits
from app.processes import ChildProcess, describe_exit
from app.studies.runs.database import Outcome
from app.studies.workers.run_executors import LOOK, AwakeClock, Beat, Keep, Task
from app.studies.workers.run_worker import RunWorker, WorkerSetup
from worlds.input_error import InputError

AHEAD = 0.2
"""Seconds of work that a process has waiting."""
BEAT = 0.25
"""Seconds between two calls of `beat` at most."""
TRIES = 2
"""Times that a run may kill its process."""
STILLBORN = 3
"""Processes in a row that may die before they have made a run."""
SILENT = 60.0
"""Seconds for which a process that has work may show no sign of life, of which there is one a
second."""
UNBORN = 5.0
"""How many times as long before its first one: it may wait for a slow disk."""
FIRST_GUESS = 0.05
"""Seconds that a run is taken to last until one is done."""


@dataclass
class RunProcess:
    """One worker, the runs that were sent to it, and how far it is."""

    started: mmap.mmap
    """Its first eight bytes: how many runs it has begun; the next: its signs of life so far."""
    child: ChildProcess = field(init=False)
    waiting: deque[Task] = field(default_factory=deque)
    """Sent, and not yet reported."""
    reported: int = 0
    heard: float = 0.0
    """When it last reported, or was sent something with nothing to do, by a clock that is awake."""
    seen: int = 0
    """How many runs it had begun when it was last looked at,"""
    since: float = 0.0
    """and since when."""
    overran: bool = False
    """Whether it was killed because its run took too long."""
    beats: int = 0
    """Signs of life that it had given when it was last looked at,"""
    lived: float | None = None
    """and since when; None: it was not looked at."""
    halted: bool = False
    """Whether it was killed because it gave none."""

    @property
    def runs_begun(self) -> int:
        """Runs that it has begun."""
        return int.from_bytes(self.started[:8], "little")

    def is_late(self, now: float, limit: float) -> bool:
        """Whether the run that it is at has taken longer than it may."""
        runs_begun = self.runs_begun
        if runs_begun != self.seen:
            self.seen, self.since = runs_begun, now
        return runs_begun > self.reported and now - self.since > limit

    def is_silent(self, now: float) -> bool:
        """Whether it has work, and has shown no sign of life for too long."""
        beats = int.from_bytes(self.started[8:16], "little")
        if beats != self.beats or self.lived is None or not self.waiting:
            self.beats, self.lived = beats, now
        return now - self.lived > (SILENT if beats else UNBORN * SILENT)

    def remaining_tasks(self) -> tuple[Task | None, list[Task]]:
        """The run that it died at, if it was at one, and those that it had not begun."""
        ahead = list(self.waiting)
        at = self.runs_begun - self.reported - 1
        if 0 <= at < len(ahead):
            return ahead[at], ahead[:at] + ahead[at + 1 :]
        return None, ahead


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class ProcessExecutor:
    """So many processes of this machine, which make the runs of one job.

    `job` is pickled to each of them. `limit`: seconds that a run may take. `timeout`: seconds
    after which a process that is asked for nothing ends. `tell` hears of one that stands still.
    Leaving it ends the processes at once.
    """

    def __init__(
        self,
        job: Any,
        workers: int,
        nice: int = 0,
        limit: float | None = None,
        timeout: float | None = None,
        tell: Callable[[str], None] | None = None,
    ):
        self.tell = tell or print_line
        self.setup = job if isinstance(job, WorkerSetup) else WorkerSetup.of(job, nice)
        self.timeout = timeout
        self.workers = workers
        self.limit = math.inf if limit is None else limit
        self.processes: list[RunProcess] = []
        self.events: queue.SimpleQueue[tuple[RunProcess, list[Outcome] | None]] = (
            queue.SimpleQueue()
        )
        self.stillborn = 0
        self.seconds = FIRST_GUESS
        """What a run takes, lately."""
        self.awake = AwakeClock()

    def __enter__(self) -> ProcessExecutor:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self.processes:
            process.child.kill()
        for process in self.processes:
            process.child.end(0.0)
            process.started.close()
        self.processes.clear()

    def run(self, tasks: Iterable[Task], keep: Keep, beat: Beat = lambda: False) -> bool:
        """Make the runs, begun in their order; False if `beat` wanted them stopped.

        `keep` receives each in the calling thread. Raises InputError if no process can be begun.
        """
        ahead = deque(tasks)
        beaten = time.monotonic()
        while ahead or any(process.waiting for process in self.processes):
            while len(self.processes) < min(self.workers, max(1, len(ahead))) and ahead:
                self.processes.append(self.start_process())
            self.send_tasks(ahead)
            with suppress(queue.Empty):
                process, outcomes = self.events.get(timeout=BEAT)
                self.take_report(process, outcomes, ahead, keep)
                while True:
                    process, outcomes = self.events.get_nowait()
                    self.take_report(process, outcomes, ahead, keep)
            self.end_late(self.awake.read())
            if time.monotonic() - beaten >= BEAT:
                beaten = time.monotonic()
                if beat():
                    return False
        return True

    def end_late(self, now: float) -> None:
        """End the processes whose run takes longer than it may, and those that stand still."""
        for process in self.processes:
            if not process.overran and process.is_late(now, self.limit):
                process.overran = True
                process.child.kill()
            elif not process.halted and process.is_silent(now):
                process.halted = True
                process.child.kill()
                at, _ = process.remaining_tasks()
                what = "a process for runs"
                if at is not None:
                    what = f"the process of cell {at.cell}, seed {at.seed}"
                self.tell(
                    f"{what} has stood still for {now - (process.lived or 0.0):.0f} s: it is "
                    "killed, and another one takes its runs"
                )

    def start_process(self) -> RunProcess:
        """A new process."""
        named = tempfile.NamedTemporaryFile(prefix="flockscope-", delete=False)  # noqa: SIM115
        with named:
            named.truncate(mmap.PAGESIZE)
        with open(named.name, "r+b") as file:
            process = RunProcess(mmap.mmap(file.fileno(), mmap.PAGESIZE))
        process.child = ChildProcess(
            RunWorker,
            self.setup,
            named.name,
            # It may compile as long as it likes; whether it stands still is seen here.
            limits=ProcessLimits(niceness=self.setup.nice, start=math.inf, idle=self.timeout),
            ended=lambda: self.events.put((process, None)),
            environment={"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        ).start()
        return process

    def send(self, process: RunProcess, tasks: list[Task]) -> None:
        """Send runs to a process; one that is gone has said so in `events`."""
        process.waiting.extend(tasks)
        future = process.child.ask(
            "make",
            [(task.payload, task.seed) for task in tasks],
            receive=lambda outcomes: self.events.put((process, outcomes)),
        )
        # Of runs that cannot be reported nothing would come: they count as having killed it.
        future.add_done_callback(
            lambda done: process.child.kill() if done.exception() is not None else None
        )

    def send_tasks(self, ahead: deque[Task]) -> None:
        """Give each process as much as keeps it busy for a while, the order kept."""
        for process in self.processes:
            busy = len(process.waiting) * self.seconds
            if not ahead or (process.waiting and busy >= AHEAD):
                continue
            share = -(-len(ahead) // (2 * self.workers))
            if not process.waiting:
                process.heard = self.awake.seconds
            some = max(1, min(int((2.0 * AHEAD - busy) / self.seconds), share, 1000))
            self.send(process, [ahead.popleft() for _ in range(min(some, len(ahead)))])

    def take_report(
        self, process: RunProcess, outcomes: list[Outcome] | None, ahead: deque[Task], keep: Keep
    ) -> None:
        """Take what a process reports, or that it is gone."""
        if outcomes is None:
            self.replace_process(process, ahead, keep)
            return
        self.stillborn = 0
        most = self.awake.read() - process.heard + LOOK
        process.heard = self.awake.seconds
        for outcome in outcomes:
            task = process.waiting.popleft()
            process.reported += 1
            if outcome.seconds > most:  # the machine was asleep meanwhile
                outcome = outcome._replace(seconds=most)
            self.seconds += 0.1 * (max(outcome.seconds, 1e-5) - self.seconds)
            keep(task, outcome)

    def replace_process(self, process: RunProcess, ahead: deque[Task], keep: Keep) -> None:
        """Put the runs of a process that is gone back, the one that it was at with its count."""
        self.processes.remove(process)
        code, reason = process.child.exit_code, process.child.reason
        how = reason if code is None else describe_exit(code)
        at, rest = process.remaining_tasks()
        process.started.close()
        ahead.extendleft(reversed(rest))
        if at is None:
            self.stillborn += code != 0 and not process.overran  # 0: it was asked for nothing
            if self.stillborn >= STILLBORN * self.workers:
                why = f" ({reason})" if reason and code is not None else ""
                raise InputError(f"no process for runs can start: they end with {how}{why}")
            return
        at = replace(at, tries=at.tries + 1)
        if process.overran:
            keep(at, Outcome("killed", reason=f"it took longer than {self.limit:g} s"))
        elif at.tries < TRIES:
            ahead.appendleft(at)
        else:
            what = "stood still" if process.halted else "ended"
            keep(at, Outcome("killed", reason=f"its process {what} twice, with {how}"))


def print_line(line: str) -> None:
    """A line on stderr."""
    print(f"flockscope: {line}", file=sys.stderr, flush=True)
