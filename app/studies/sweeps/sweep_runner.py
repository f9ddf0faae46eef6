"""Carrying out a sweep: how many replicates a cell needs; what the store lacks is run, and kept."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agents.catalogue import is_built_in
from agents.flock import Flock
from agents.observables.catalogue import BUILT_IN
from app.studies.cluster.cluster_options import Cluster
from app.studies.judge import statistics
from app.studies.judge.judge import INTERVAL_CONFIDENCE, ranges_of
from app.studies.judge.statistics import interval_of_mean
from app.studies.runs.store import canonical
from app.studies.study_runner import At, StudyReport, StudyRunner, Tell
from app.studies.sweeps.checked_sweep import Sweep
from app.studies.sweeps.sweep_cells import Cell, changes
from app.studies.sweeps.sweep_file import Precision, Replicates
from app.studies.workers.kernels import compile_loop
from app.studies.workers.run_executors import Task
from worlds.number_text import counted

Values = Callable[[int, int], list[float]]
"""The values of a cell's first replicates, without those that have none."""


FIRST_LOOK = 10
"""Replicates before the interval of a mean is looked at: fewer show too little of their spread."""


def half_width(values: Sequence[float], confidence: float = INTERVAL_CONFIDENCE) -> float:
    """Half of the interval of a mean, the wider side; nan of equal values, which show no spread.

    >>> round(half_width([1.0, 2.0, 3.0]), 3)
    9.901
    """
    interval = interval_of_mean(ranges_of(values), confidence)
    return statistics.half_width(float(np.mean(values)) if len(values) else math.nan, interval)


def is_precise(values: Sequence[float], precision: Precision) -> bool:
    """Whether the interval of the mean is as narrow as is asked for.

    Values that are all equal count as precise from the first look on: a measure without noise would
    otherwise be run for ever.
    """
    if len(values) >= FIRST_LOOK and ranges_of(values).are_equal:
        return True
    width = half_width(values, precision.confidence)
    scale = abs(float(np.mean(values))) if precision.relative and len(values) else 1.0
    return width <= precision.within * scale


class Rounds:
    """Replicates of each cell, round by round; a round follows from the whole round before it.

    So it does not matter in which order runs end, or how often a sweep was stopped.
    """

    def __init__(self, replicates: Replicates, cells: Sequence[int]):
        self.asked = replicates
        self.cells = list(cells)
        self.wanted = dict.fromkeys(self.cells, replicates.count)

    @property
    def total(self) -> int:
        """Runs that are asked for so far."""
        return sum(self.wanted.values())

    def ask_for_more(self, values: Values) -> bool:
        """Ask for the replicates of the next round; False if there is none."""
        precision = self.asked.precision
        if precision is None:
            return False
        added = False
        for cell in self.cells:
            now = self.wanted[cell]
            step = max(precision.step, FIRST_LOOK - now)
            room = min(precision.most - now, step)
            if precision.budget is not None:
                room = min(room, precision.budget - self.total)
            looked = now >= FIRST_LOOK and is_precise(values(cell, now), precision)
            if room > 0 and not looked:
                self.wanted[cell] = now + room
                added = True
        return added


@dataclass
class SweepRounds:
    """What a sweep lacks, round by round, until its means are as precise as is asked."""

    sweep: Sweep
    runner: StudyRunner
    numbers: list[int]
    """The number of each cell in the store."""

    def __post_init__(self) -> None:
        self.cells: dict[int, Cell] = {}
        for number, cell in zip(self.numbers, self.sweep.cells, strict=True):
            self.cells.setdefault(number, cell)
        self.places = {number: place for place, number in enumerate(self.cells, 1)}
        self.rounds = Rounds(self.sweep.file.replicates, list(self.cells))
        self.runner.wanted = self.rounds.total
        while self.is_complete and self.ask_for_more():
            pass

    def missing_tasks(self) -> Iterator[Task]:
        """The runs that this round lacks, replicate by replicate."""
        for replicate in range(max(self.rounds.wanted.values())):
            for number, cell in self.cells.items():
                if replicate < self.rounds.wanted[number]:
                    seed = self.sweep.seed(cell, replicate)
                    if (number, seed) not in self.runner.outcomes:
                        place, folder = self.places[number], self.runner.folder
                        request = self.sweep.run_request(cell, place, replicate, folder)
                        yield Task(number, seed, request)

    @property
    def is_complete(self) -> bool:
        """Whether this round has all its runs."""
        return next(self.missing_tasks(), None) is None

    def stored_count(self) -> int:
        """Runs of this round that the store has."""
        return sum(
            (number, seed) in self.runner.outcomes
            for number, cell in self.cells.items()
            for seed in self.sweep.seeds(cell, self.rounds.wanted[number])
        )

    def ask_for_more(self) -> bool:
        """Ask for the runs of the next round; False if there is none."""
        added = self.rounds.ask_for_more(self.first_values)
        self.runner.wanted = self.rounds.total
        return added

    def first_values(self, number: int, replicates: int) -> list[float]:
        """What the precision is asked of, of the first replicates of a cell."""
        (column,) = self.runner.remembered or ("",)
        seeds = self.sweep.seeds(self.cells[number], replicates)
        outcomes = [self.runner.outcomes.get((number, seed)) for seed in seeds]
        values = [
            outcome.values[column]
            for outcome in outcomes
            if outcome is not None and outcome.status == "ok"
        ]
        return [value for value in values if value is not None]

    def run(self) -> bool:
        """Make all rounds; False if it was stopped or reached its limit."""
        while self.runner.run(self.missing_tasks()):
            if not self.ask_for_more():
                return True
        return False


def run_sweep(
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
) -> StudyReport:
    """Carry out a sweep in a folder: spec.toml, runs.sqlite and recordings.

    `retry`: whether runs that failed or were killed are made again. `limit`: runs to make now.
    `cluster`: what makes them, by default that of the file, or `workers` processes.
    `at` hears of the share that is done, the seconds left and the runs. Raises InputError; after
    KeyboardInterrupt what was finished is in the store.
    """
    file = sweep.file
    precision = file.replicates.precision
    runner = StudyRunner(
        folder,
        sweep.making,
        {
            "kind": "sweep",
            "title": sweep.title,
            "axes": sweep.axes,
            "columns": sweep.making.columns,
            "base": sweep.base.to_toml(),
            "from_folder": str(sweep.folder.absolute()),
            "limit": file.run.ticks,
        },
        lambda: prepare(sweep, tell),
        workers=workers,
        nice=nice,
        retry=retry,
        limit=limit,
        cluster=cluster or file.cluster,
        timeout=file.run.timeout,
        is_own_code=is_own_code(sweep),
        spec=sweep.text,
        remembered=[precision.observable] if precision else [],
        tell=tell,
        at=at,
    )
    with runner:
        numbers = runner.plan([(cell.hash, cell.stored_text) for cell in sweep.cells])
        runner.store.tell(runs=file.replicates.count * len(set(numbers)))
        runner.store.commit()
        if tell is not None:
            tell_changes(sweep, runner, numbers, tell)
        rounds = SweepRounds(sweep, runner, numbers)
        runs_taken, is_complete = rounds.stored_count(), rounds.is_complete
        if not is_complete:
            if tell is not None:
                tell(
                    f"{counted(rounds.rounds.total - runs_taken, 'run')} to make, "
                    f"{runs_taken} are there"
                )
            is_complete = rounds.run()
        runner.store.tell(runs=rounds.rounds.total)
        gave_up = runner.statuses["gave-up"]
        return StudyReport(runner.made, runs_taken, runner.failed_count, gave_up, is_complete)


def is_own_code(sweep: Sweep) -> bool:
    """Whether its runs call a rule, a body or a measure that is not flockscope's."""
    models = {*sweep.base.models, *(name for cell in sweep.cells for name in cell.spec.models)}
    until = sweep.making.until
    observables = {measure.name for measure in sweep.making.measures}  # "": of a file
    observables |= {until.says.name} if until else set()
    return not (all(map(is_built_in, models)) and observables <= BUILT_IN.keys())


def tell_changes(sweep: Sweep, runner: StudyRunner, numbers: list[int], tell: Tell) -> None:
    """Say what has changed since runs of the same cells were made that are in the store."""
    before = runner.store.others(numbers)
    if not before:
        return
    now = {canonical(cell.identity): cell for cell in sweep.cells}
    counts: dict[str, int] = {}
    for identity, basis, runs in before:
        cell = now.get(canonical(identity))
        for words in changes(basis, cell.basis) if cell else ():
            counts[words] = counts.get(words, 0) + runs
    for words, runs in counts.items():
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
    reported: set[str] = set()
    for cell in chosen.values():
        flock = Flock(cell.spec.but(seed=sweep.file.replicates.first))
        if flock.passing and tell is not None and flock.warning not in reported:
            reported.add(flock.warning)
            tell(f"flockscope: {flock.warning}")
        compile_loop(flock, tell)
        with contextlib.suppress(Exception):  # of a run's own making: the run itself will tell
            sweep.making.try_out(flock)
