"""The runs of a study: taken from its store, or made and kept there, and stopped at any time.

Papers, sweeps and searches are alike in this: cells with seeds, a job that makes their runs, and a
store that keeps them. What each wants next, it says itself.
"""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

from app.studies.cluster.cluster_options import Cluster
from app.studies.runs.database import BROKEN, Outcome
from app.studies.runs.store import Store, number
from app.studies.runs.store_reader import StoreReader, readable
from app.studies.workers.process_executor import ProcessExecutor
from app.studies.workers.run_executors import RunExecutor, Task
from app.studies.workers.thread_executor import ThreadExecutor
from worlds.file_writer import write_text
from worlds.input_error import InputError

SPEC = "spec.toml"
STOP = ".stop"
"""A file that asks the process that makes runs to stop."""
LATELY = 0.2
"""How much the last second weighs in the rate."""
Tell = Callable[[str], Any]
At = Callable[[float, float, str], Any]
"""It hears of the share that is done, the seconds left, and both in words."""


@dataclass
class StudyReport:
    """The runs of a study that is carried out, or was stopped on the way."""

    made: int = 0
    """Runs made now."""
    taken: int = 0
    """Runs that the store had."""
    broken: int = 0
    """Runs that failed or were killed, of all."""
    gave_up: int = 0
    whole: bool = True
    """Whether there is nothing left to run."""


class StudyProgress:
    """What is done and what is left of the runs that are expected, by cell."""

    def __init__(self) -> None:
        self.guesses: dict[int, float] = {}
        """Seconds that a run of a cell is thought to take; no other cell has a guess then."""
        self.later = 0
        """Runs that will be asked for beside those that are expected now."""
        self.ahead: Counter[int] = Counter()
        self.done: Counter[int] = Counter()
        self.spent: dict[int, float] = {}
        self.count = 0
        self.all = 0
        self.rate = 0.0
        self.began = self.looked = time.monotonic()
        self.seen = 0

    def expect(self, cells: Iterable[int]) -> None:
        """Expect these runs, each given by its cell."""
        self.ahead = Counter(cells)
        self.all = self.count + self.ahead.total() + self.later

    def add(self, cell: int, seconds: float) -> None:
        """Count a run that is over."""
        self.ahead[cell] -= 1
        self.done[cell] += 1
        self.spent[cell] = self.spent.get(cell, 0.0) + seconds
        self.count += 1

    @property
    def slowness(self) -> float:
        """How many times longer runs take than guessed; without guesses, seconds of a run."""
        guessed = sum(n * self.guesses.get(cell, 1.0) for cell, n in self.done.items())
        if guessed:
            return sum(self.spent.values()) / guessed
        return 1.0 if self.guesses else 0.0

    @property
    def seconds(self) -> float:
        """Seconds of one core for what is left; cells of which no run is done cost their guess."""
        slowness = self.slowness
        return self.later * slowness + sum(
            left
            * (
                self.spent[cell] / self.done[cell]
                if self.done[cell]
                else slowness * self.guesses.get(cell, 1.0)
            )
            for cell, left in self.ahead.items()
        )

    @property
    def share(self) -> float:
        """Share of the work that is done, in [0, 1]."""
        spent, ahead = sum(self.spent.values()), self.seconds
        if spent + ahead:
            return spent / (spent + ahead)
        return 0.0 if self.ahead.total() else 1.0

    def pace(self) -> float:
        """Runs a second, lately."""
        now = time.monotonic()
        if now - self.looked >= 1.0:
            latest = (self.count - self.seen) / (now - self.looked)
            first = self.rate == 0.0
            self.rate = latest if first else self.rate + LATELY * (latest - self.rate)
            self.looked, self.seen = now, self.count
        return self.rate or self.count / max(now - self.began, 1e-9)

    def describe(self, broken: int, gave_up: int) -> str:
        """How far it is, for people."""
        text = f"{self.count} of {self.all} runs, {self.pace():.3g} a second"
        text += f", {gave_up} gave up" if gave_up else ""
        return text + (f", {broken} failed" if broken else "")

    def value(self, workers: int) -> dict[str, Any]:
        """How far it is, for who reads the store."""
        return {
            "pid": os.getpid(),
            "workers": workers,
            "made": self.count,
            "of": self.all,
            "rate": round(self.pace(), 3),
            "seconds_left": round(self.seconds / workers, 3),
            "updated": round(time.time(), 3),
        }


@dataclass
class StudyRunner:
    """A context manager over the store of a folder; what makes runs begins with the first of them.

    Raises InputError if the folder has the runs of another kind of study, or is being written.
    """

    folder: Path
    job: Any
    """How runs are made: `prepare()`, and `run(payload, seed)` that returns an Outcome."""
    state: dict[str, Any]
    """What the store says of the study: `kind`, `title`, `columns` and whatever readers need."""
    prepare: Callable[[], None]
    """Called before the first run is made: it compiles."""
    workers: int
    nice: int = 0
    retry: bool = False
    """Whether runs that failed or were killed are made again."""
    limit: int | None = None
    """Runs to make now, at most."""
    cluster: Cluster = field(default_factory=Cluster)
    """What makes the runs, instead of processes of this machine."""
    timeout: float | None = None
    """Seconds that a run may take."""
    is_own_code: bool = False
    """Whether runs call code that is not flockscope's: it may hang, or crash its process."""
    spec: str = ""
    """The study's own text, kept beside its runs."""
    remembered: Sequence[str] | None = None
    """The columns that `outcomes` has; None for all."""
    parts: Callable[[Task, Outcome], Iterable[tuple[int, Outcome]]] = lambda task, outcome: (
        (task.cell, outcome),
    )
    """The cells that a run has an outcome for: one, but of a run that goes from cell to cell."""
    tell: Tell | None = None
    at: At = lambda *_: None

    def __post_init__(self) -> None:
        self.progress = StudyProgress()
        self.wanted = 0
        """Runs that the study asks for so far, those that are there with them."""
        self.cells: set[int] = set()
        self.statuses: Counter[str] = Counter()
        """How the runs of the planned cells ended."""
        self.made = 0
        self.stopped = False
        self.executor: RunExecutor | None = None

    def __enter__(self) -> StudyRunner:
        columns = self.state["columns"]
        demand_kind(self.folder, self.state["kind"])
        with ExitStack() as stack:
            self.store = stack.enter_context(Store(self.folder, columns))
            with suppress(FileNotFoundError):
                (self.folder / STOP).unlink()
            if self.spec:
                write_text("spec", self.folder / SPEC, self.spec)
            if self.retry:
                self.store.forget_broken()
            self.store.tell(**self.state)
            if self.remembered is None:
                self.remembered = columns
            self.outcomes = self.store.outcomes(self.remembered)
            self.stack = stack.pop_all()
        return self

    def __exit__(self, kind: type[BaseException] | None, *rest: Any) -> None:
        if kind is None or not issubclass(kind, Exception):
            self.store.tell(progress=None)
        self.stack.__exit__(kind, *rest)

    def plan(self, cells: Sequence[tuple[str, str]]) -> list[int]:
        """Take a plan: the hash and the JSON of each of its cells; their numbers in the store."""
        numbers = self.store.store_plan(cells)
        self.cells = set(numbers)
        self.statuses = Counter(
            outcome.status for (cell, _), outcome in self.outcomes.items() if cell in self.cells
        )
        return numbers

    def run(self, tasks: Iterable[Task]) -> bool:
        """Make runs; False if it was stopped, or as many as were allowed are made."""
        room = None if self.limit is None else max(0, self.limit - self.made)
        next_tasks = list(islice(tasks, None if room is None else room + 1))
        allowed = next_tasks[:room]
        if allowed:
            if self.stopped:
                return False
            if not self.progress.guesses:
                self.progress.expect(task.cell for task in allowed)
            if not self.make_executor().run(allowed, self.store_outcome, self.commit_and_report):
                return False
            self.commit_and_report()
            self.store.commit()
        return len(allowed) == len(next_tasks)

    def make_executor(self) -> RunExecutor:
        """What makes runs, which begins with the first of them."""
        if self.executor is None:
            self.prepare()
            self.executor = self.stack.enter_context(executor_of(self))
        return self.executor

    def store_outcome(self, task: Task, outcome: Outcome) -> None:
        """Take a run that is over."""
        for cell, part in self.parts(task, outcome):
            self.store.add(cell, task.seed, part)
            values = {name: number(part.values.get(name)) for name in self.remembered or ()}
            self.outcomes[cell, task.seed] = part._replace(values=values, series={}, rest=())
            self.statuses[part.status] += 1
        self.made += 1
        self.progress.add(task.cell, outcome.seconds)

    def commit_and_report(self) -> bool:
        """Commit, tell how far it is; whether it is to stop."""
        workers = max(1, self.executor.workers if self.executor else 1)
        progress = self.progress
        self.store.tell(progress=progress.value(workers), runs=self.wanted)
        self.store.commit_if_due()
        words = progress.describe(self.failed_count, self.statuses["gave-up"])
        self.at(progress.share, progress.seconds / workers, words)
        self.stopped = self.stopped or (self.folder / STOP).exists()
        return self.stopped

    @property
    def failed_count(self) -> int:
        """Runs of the planned cells that failed or were killed."""
        return sum(self.statuses[status] for status in BROKEN)


def executor_of(runner: StudyRunner) -> RunExecutor:
    """A cluster if one is asked for, or processes, or threads as long as those do not pay.

    Only a process of its own can be ended as a run takes too long, or be nicer than this one, or
    crash and leave this one and the runs that are made.
    """
    if runner.cluster.kind:
        # Imports Dask: 0.4 s, and an extra that other studies do without.
        from app.studies.cluster.cluster_executor import ClusterExecutor

        return ClusterExecutor(
            runner.job, runner.cluster, runner.workers, runner.nice, runner.timeout, runner.tell
        )

    def begin_processes() -> ProcessExecutor:
        return ProcessExecutor(
            runner.job, runner.workers, runner.nice, runner.timeout, tell=runner.tell
        )

    if runner.is_own_code or runner.nice or runner.timeout is not None:
        return begin_processes()
    expected = runner.progress.seconds if runner.progress.guesses else 0.0
    return ThreadExecutor(runner.job, runner.workers, begin_processes, expected)


def demand_kind(folder: Path, kind: str) -> None:
    """Refuse a folder that has the runs of a paper for other runs, and others' for a paper."""
    stored_kind = StoreReader(folder).state.get("kind") if readable(folder) else None
    if stored_kind is None or (stored_kind == "paper") == (kind == "paper"):
        return
    if stored_kind == "paper":
        raise InputError(f"{str(folder)!r} has the runs of a paper: give the sweep another folder")
    raise InputError(f"{str(folder)!r} has other runs: give the paper another folder")
