"""Carrying out a sweep: what the store lacks is run, replicate by replicate, and kept."""

from __future__ import annotations

import contextlib
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

from agents.flock import Flock
from app.studies.cluster.cluster_options import Cluster
from app.studies.runs.database import BROKEN, Outcome, Status
from app.studies.runs.store import Store, canonical
from app.studies.runs.store_reader import StoreReader, readable
from app.studies.sweeps.checked_sweep import Sweep
from app.studies.sweeps.replicates import Rounds
from app.studies.sweeps.sweep_cells import Cell, changes
from app.studies.workers.kernels import compile_loop
from app.studies.workers.processes import Processes
from app.studies.workers.run_executors import RunExecutor, Task
from worlds.file_writer import write_text
from worlds.input_error import InputError
from worlds.number_text import counted

# How far a sweep is: runs, their rate, and the time left from what each cell's runs have cost.

LATELY = 0.2
"""How much the last second weighs in the rate."""


class SweepProgress:
    """What is done and what is left of the runs that are expected."""

    def __init__(self) -> None:
        self.ahead: Counter[int] = Counter()
        self.done: Counter[int] = Counter()
        self.spent: dict[int, float] = {}
        self.count = 0
        self.all = 0
        self.rate = 0.0
        self.began = self.looked = time.monotonic()
        self.seen = 0

    def expect(self, cells: Sequence[int]) -> None:
        """Expect these runs, each given by its cell."""
        self.ahead = Counter(cells)
        self.all = self.count + len(cells)

    def add(self, cell: int, seconds: float) -> None:
        """Count a run that is over."""
        self.ahead[cell] -= 1
        self.done[cell] += 1
        self.spent[cell] = self.spent.get(cell, 0.0) + seconds
        self.count += 1

    @property
    def seconds(self) -> float:
        """Seconds of one core for what is left; cells of which no run is done cost the mean."""
        total = sum(self.spent.values())
        mean = total / self.count if self.count else 0.0
        return sum(
            left * (self.spent[cell] / self.done[cell] if self.done[cell] else mean)
            for cell, left in self.ahead.items()
        )

    @property
    def share(self) -> float:
        """Share of the work that is done, in [0, 1]."""
        spent, ahead = sum(self.spent.values()), self.seconds
        return spent / (spent + ahead) if spent + ahead else 0.0

    def pace(self) -> float:
        """Runs a second, lately."""
        now = time.monotonic()
        if now - self.looked >= 1.0:
            latest = (self.count - self.seen) / (now - self.looked)
            first = self.rate == 0.0
            self.rate = latest if first else self.rate + LATELY * (latest - self.rate)
            self.looked, self.seen = now, self.count
        return self.rate or self.count / max(now - self.began, 1e-9)

    def words(self, broken: int, gave_up: int) -> str:
        """How far it is, for people."""
        said = f"{self.count} of {self.all} runs, {self.pace():.3g} a second"
        said += f", {gave_up} gave up" if gave_up else ""
        return said + (f", {broken} failed" if broken else "")

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


SPEC = "spec.toml"
STOP = ".stop"
"""A file that asks the process that runs a sweep to stop."""
Tell = Callable[[str], Any]
At = Callable[[float, float, str], Any]


@dataclass
class SweepReport:
    """A sweep carried out, or stopped on the way."""

    made: int = 0
    """Runs made now."""
    taken: int = 0
    """Runs that the store had."""
    broken: int = 0
    """Runs that failed or were killed, of all."""
    gave_up: int = 0
    whole: bool = True
    """Whether there is nothing left to run."""


@dataclass
class SweepRunner:
    """One call: the sweep, its store, and what is done so far."""

    sweep: Sweep
    store: Store
    numbers: list[int]
    """The number of each cell in the store."""
    at: At
    limit: int | None
    done: dict[tuple[int, int], Status] = field(default_factory=dict)
    values: dict[tuple[int, int], float | None] = field(default_factory=dict)
    """What the precision is asked of."""
    stopped: bool = False

    def __post_init__(self) -> None:
        self.cells: dict[int, Cell] = {}
        for number, cell in zip(self.numbers, self.sweep.cells, strict=True):
            self.cells.setdefault(number, cell)
        self.places = {number: place for place, number in enumerate(self.cells, 1)}
        self.rounds = Rounds(self.sweep.file.replicates, list(self.cells))
        self.done = self.store.done(self.numbers)
        self.statuses = Counter(self.done.values())
        self.left = SweepProgress()
        precision = self.sweep.file.replicates.precision
        self.column = precision.observable if precision else None
        if self.column is not None:
            self.values = self.store.values(self.column, self.numbers)
        self.made = 0
        self.workers = 1
        """Runs that are made at a time."""

    def lacking(self) -> Iterator[tuple[int, int, int]]:
        """Cell, replicate and seed of what this round lacks, replicate by replicate."""
        for replicate in range(max(self.rounds.wanted.values())):
            for number, cell in self.cells.items():
                if replicate < self.rounds.wanted[number]:
                    seed = self.sweep.seed(cell, replicate)
                    if (number, seed) not in self.done:
                        yield number, replicate, seed

    def task(self, number: int, replicate: int, seed: int) -> Task:
        """A run as a process is asked for it."""
        cell, place = self.cells[number], self.places[number]
        return Task(number, seed, self.sweep.wanted(cell, place, replicate, self.store.folder))

    @property
    def is_whole(self) -> bool:
        """Whether this round has all its runs."""
        return next(self.lacking(), None) is None

    def taken(self) -> int:
        """Runs of this round that the store has."""
        return sum(
            (number, seed) in self.done
            for number, cell in self.cells.items()
            for seed in self.sweep.seeds(cell, self.rounds.wanted[number])
        )

    def keep(self, task: Task, outcome: Outcome) -> None:
        """Take a run that is over."""
        self.store.add(task.cell, task.seed, outcome)
        self.done[task.cell, task.seed] = outcome.status
        self.statuses[outcome.status] += 1
        if self.column is not None:
            self.values[task.cell, task.seed] = outcome.values.get(self.column)
        self.made += 1
        self.left.add(task.cell, outcome.seconds)

    def beat(self) -> bool:
        """Commit, tell how far it is; whether it is to stop."""
        self.store.tell(progress=self.left.value(self.workers), runs=self.rounds.total)
        self.store.beat()
        words = self.left.words(self.broken, self.statuses["gave-up"])
        self.at(self.left.share, self.left.seconds / self.workers, words)
        self.stopped = self.stopped or (self.store.folder / STOP).exists()
        return self.stopped

    @property
    def broken(self) -> int:
        """Runs that failed or were killed."""
        return sum(self.statuses[one] for one in BROKEN)

    def first_values(self, number: int, replicates: int) -> list[float]:
        """What the precision is asked of, of the first replicates of a cell."""
        seeds = self.sweep.seeds(self.cells[number], replicates)
        found = [self.values.get((number, seed)) for seed in seeds]
        ok = [self.done.get((number, seed)) == "ok" for seed in seeds]
        return [one for one, good in zip(found, ok, strict=True) if good and one is not None]

    def run(self, makers: RunExecutor) -> bool:
        """Make all rounds; False if it was stopped or reached its limit."""

        def beat() -> bool:
            self.workers = max(1, makers.workers)
            return self.beat()

        while True:
            room = None if self.limit is None else max(0, self.limit - self.made)
            tasks = [self.task(*one) for one in islice(self.lacking(), room)]
            self.left.expect([task.cell for task in tasks])
            if not makers.run(tasks, self.keep, beat):
                return False
            beat()
            if not self.is_whole:
                return False
            if not self.rounds.more(self.first_values):
                return True


def conduct(
    sweep: Sweep,
    folder: Path,
    *,
    workers: int,
    nice: int = 0,
    retry: bool = False,
    limit: int | None = None,
    cluster: Cluster | None = None,
    tell: Tell | None = None,
    at: At = lambda *_: None,
) -> SweepReport:
    """Carry out a sweep in a folder: spec.toml, runs.sqlite and recordings.

    `retry`: whether runs that failed or were killed are made again. `limit`: runs to make now.
    `cluster`: what makes them, by default that of the file, or `workers` processes.
    `at` hears of the share that is done, the seconds left and the runs. Raises InputError; after
    KeyboardInterrupt what was finished is in the store.
    """
    demand_no_paper(folder)
    with Store(folder, sweep.making.columns) as store:
        with contextlib.suppress(FileNotFoundError):
            (folder / STOP).unlink()
        write_text("spec", folder / SPEC, sweep.text)
        numbers = store.lay_out([(cell.hash, cell.kept) for cell in sweep.cells])
        store.tell(
            kind="sweep",
            title=sweep.title,
            axes=sweep.axes,
            columns=sweep.making.columns,
            base=sweep.base.to_toml(),
            from_folder=str(sweep.folder.absolute()),
            limit=sweep.file.run.ticks,
            runs=sweep.file.replicates.count * len(set(numbers)),
        )
        store.keep()
        if retry:
            store.forget_broken()
        if tell is not None:
            tell_changes(sweep, store, numbers, tell)
        call = SweepRunner(sweep, store, numbers, at, limit)
        while call.is_whole and call.rounds.more(call.first_values):
            pass
        taken = call.taken()
        whole = call.is_whole
        if not whole:
            prepare(sweep, tell)
            if tell is not None:
                tell(f"{counted(call.rounds.total - taken, 'run')} to make, {taken} are there")
            asked, seconds = cluster or sweep.file.cluster, sweep.file.run.timeout
            with makers_of(sweep.making, asked, workers, nice, seconds, tell) as makers:
                whole = call.run(makers)
        store.tell(progress=None, runs=call.rounds.total)
        return SweepReport(call.made, taken, call.broken, call.statuses["gave-up"], whole)


def makers_of(
    job: Any, cluster: Cluster, workers: int, nice: int, seconds: float | None, tell: Tell | None
) -> RunExecutor:
    """What makes the runs of a job: a cluster if there is one, or processes of this machine."""
    if cluster.kind:
        # Imports Dask: 0.4 s, and an extra that other sweeps do without.
        from app.studies.cluster.cluster_executor import ClusterExecutor

        return ClusterExecutor(job, cluster, workers, nice, seconds, tell)
    return Processes(job, workers, nice, seconds, tell=tell)


def demand_no_paper(folder: Path) -> None:
    """Refuse a folder whose runs are those of a paper, before anything there is changed."""
    if readable(folder) and StoreReader(folder).state.get("kind") == "paper":
        raise InputError(f"{str(folder)!r} has the runs of a paper: give the sweep another folder")


def tell_changes(sweep: Sweep, store: Store, numbers: list[int], tell: Tell) -> None:
    """Say what has changed since runs of the same cells were made that are in the store."""
    before = store.others(numbers)
    if not before:
        return
    now = {canonical(cell.identity): cell for cell in sweep.cells}
    said: dict[str, int] = {}
    for identity, basis, runs in before:
        cell = now.get(canonical(identity))
        for words in changes(basis, cell.basis) if cell else ():
            said[words] = said.get(words, 0) + runs
    for words, runs in said.items():
        tell(
            f"flockscope: {words} since {counted(runs, 'run')} of the same cells: they are kept, "
            "and made anew beside them"
        )


def prepare(sweep: Sweep, tell: Tell | None) -> None:
    """Compile what the runs call, once, and warn of agents that go through what is solid."""
    chosen: dict[str, Cell] = {}
    for cell in sweep.cells:
        spec = cell.identity["spec"]
        rule = cell.basis[f"the rule of {spec['model']}"]
        late = any(spec[name] for name in ("delay", "jitter", "lost", "place_error"))
        chosen.setdefault(f"{rule} {spec['activation']} {late}", cell)
    told: set[str] = set()
    for cell in chosen.values():
        flock = Flock(cell.spec.but(seed=sweep.file.replicates.first))
        if flock.warning and tell is not None and flock.warning not in told:
            told.add(flock.warning)
            tell(f"flockscope: {flock.warning}")
        compile_loop(flock, tell)
        with contextlib.suppress(Exception):  # of a run's own making: the run itself will tell
            sweep.making.try_out(flock)
