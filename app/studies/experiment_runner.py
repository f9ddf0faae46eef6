"""Carrying out an experiment: what is in the store is taken from it, the rest is run and kept."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.studies.experiment import Case, Experiment
from app.studies.kinds.kind_settings import Number
from app.studies.runs.run_outcome import BROKEN, Outcome
from app.studies.runs.store import Store, canonical
from app.studies.trial import Trials, column_of, fingerprint, flock_of, result_of
from app.studies.workers.costs import Costs, guess
from app.studies.workers.kernels import compile_loop
from app.studies.workers.processes import Processes
from app.studies.workers.run_executors import InlineExecutor, RunExecutor, Task
from worlds.input_error import InputError
from worlds.number_text import counted, duration

SOON = 2.0
"""Seconds of work that are done before other processes have begun."""
ENOUGH, MOST_TICKS = 0.005, 4096
"""Seconds after which ticks that are timed are enough, and ticks."""
Tell = Callable[[str], object]
At = Callable[[float, float, str], object]


@dataclass(frozen=True)
class MeasuredCase:
    """A case with what its runs have given, each in the order of the seeds."""

    case: Case
    values: dict[str, list[Number | None]]
    """By measure; None for a run that has none."""


@dataclass(frozen=True)
class ExperimentReport:
    """An experiment carried out."""

    measured: list[MeasuredCase]
    taken: int
    """Runs taken from the store."""
    made: int
    """Runs made now."""
    astray: list[str]
    """Of each run in which an agent was seen where it cannot be: which run, and which agent."""
    failed: list[str]
    """Of each run that raised, or whose process was killed: which run, and why."""


class RunPlan:
    """Which runs an experiment needs, and which of them the store lacks."""

    def __init__(self, experiment: Experiment, runs: int, seed: int, store: Store):
        self.experiment = experiment
        self.store = store
        self.seeds = range(seed, seed + runs)
        cases = experiment.cases
        self.numbers = store.lay_out([cell_of(case, experiment) for case in cases])
        self.outcomes = store.outcomes(self.numbers)
        self.paths = experiment.paths
        self.missing = [
            [seed for seed in self.seeds if not self.has(path, seed)] for path in self.paths
        ]
        guesses = [sum(self.guess(cases[k]) for k in path) for path in self.paths]
        self.costs = Costs(guesses, self.left)

    def has(self, path: list[int], seed: int) -> bool:
        """Whether the store has a run in all of its cases."""
        return all((self.numbers[k], seed) in self.outcomes for k in path)

    def guess(self, case: Case) -> float:
        """Seconds that a run of a case may take."""
        from agents.catalogue import model

        settings = self.experiment.settings
        published = case.published(settings.measures[0].name)
        dt = flock_of(case, 0).dt
        ticks = settings.ticks(published.mean if published else None, dt)
        return guess(ticks, case.agents, len(model(case.spec.model).columns))

    def time(self) -> None:
        """Put the guesses right by the first ticks of a run of each path that is to be made."""
        for n, path in enumerate(self.paths):
            if self.missing[n]:
                self.costs.guesses[n] *= slowness(self.experiment.cases[path[0]])

    @property
    def left(self) -> list[int]:
        """Runs that each path lacks."""
        return [len(seeds) for seeds in self.missing]

    @property
    def job(self) -> Trials:
        """How the runs are made."""
        cases = self.experiment.cases
        paths = tuple(tuple(cases[k] for k in path) for path in self.paths)
        return Trials(paths, self.experiment.settings)

    @property
    def tasks(self) -> list[Task]:
        """The runs that the store lacks, the longest first."""
        order = sorted(range(len(self.paths)), key=lambda n: -self.costs.guesses[n])
        return [Task(n, seed, n) for n in order for seed in self.missing[n]]

    def keep(self, task: Task, outcome: Outcome) -> None:
        """Keep a run in the store and in the costs; one that is broken is so in all its cases."""
        path = self.paths[task.payload]
        parts = [outcome, *outcome.rest] if outcome.status == "ok" else [outcome] * len(path)
        for k, part in zip(path, parts, strict=True):
            self.outcomes[self.numbers[k], task.seed] = part
            self.store.add(self.numbers[k], task.seed, part)
        self.costs.add(task.payload, outcome.seconds)

    @property
    def sound(self) -> list[int]:
        """The seeds whose runs all came to an end: a mean over others would compare unlike runs."""
        broken = {
            seed
            for number in self.numbers
            for seed in self.seeds
            if self.outcomes[number, seed].status in BROKEN
        }
        return [seed for seed in self.seeds if seed not in broken]

    @property
    def measured(self) -> list[MeasuredCase]:
        """All cases with their runs. Raises InputError if a run of every seed is broken."""
        seeds = self.sound
        if not seeds:
            raise InputError(
                f"{self.experiment.name}: of every seed a run failed: {self.failed[0]}"
            )
        return [self.measured_of(k, seeds) for k in range(len(self.experiment.cases))]

    @property
    def astray(self) -> list[str]:
        """The runs in which an agent was seen where it cannot be, in words."""
        return self.told(lambda outcome: outcome.astray)

    @property
    def failed(self) -> list[str]:
        """The runs that failed or were killed, in words."""
        return self.told(lambda outcome: outcome.reason)

    def told(self, words: Callable[[Outcome], str]) -> list[str]:
        """Each run of which there is something to tell, with that."""
        found: dict[tuple[int, int], str] = {}
        for number, case in zip(self.numbers, self.experiment.cases, strict=True):
            spec = case.spec
            parameters = json.dumps(spec.parameters, sort_keys=True, separators=(",", ":"))
            for seed in self.seeds:
                said = words(self.outcomes[number, seed])
                if said:
                    run = f"{spec.model}, N = {case.agents}, {parameters}, seed {seed}"
                    found[number, seed] = f"{run}: {said}"
        return list(found.values())

    def measured_of(self, case: int, seeds: list[int]) -> MeasuredCase:
        """A case (by its number) with its runs."""
        number = self.numbers[case]
        settings = self.experiment.settings
        found = [self.outcomes[number, seed] for seed in seeds]
        results = [result_of(one, settings).measures for one in found]
        names = [one.name for one in settings.measures]
        values = {name: [one[name] for one in results] for name in names}
        return MeasuredCase(self.experiment.cases[case], values)


def cell_of(case: Case, experiment: Experiment) -> tuple[str, str]:
    """The hash and the JSON of a case, as the store has them. Raises InputError."""
    spec = case.spec
    identity = {"model": spec.model, "agents": case.agents, "parameters": spec.parameters}
    basis = {"all else": checked_fingerprint(case, experiment)}
    key = canonical({"identity": identity, "basis": basis})
    axes = {"label": case.label, "agents": case.agents, **spec.parameters}
    kept = {"axes": axes, "identity": identity, "basis": basis}
    return hashlib.sha256(key.encode()).hexdigest()[:24], canonical(kept)


def checked_fingerprint(case: Case, experiment: Experiment) -> str:
    """The case's fingerprint. Raises InputError naming the experiment if it cannot be built."""
    try:
        return fingerprint(case, experiment.settings)
    except InputError as refusal:
        raise InputError(
            f"{refusal} ({experiment.name}, {case.spec.model} with N = {case.agents})"
        ) from None


def slowness(case: Case) -> float:
    """How many times longer the first ticks of a case take than guessed."""
    from agents.catalogue import model

    flock = flock_of(case, 0)
    flock.run(1)
    ticks, seconds = 1, 0.0
    while seconds < ENOUGH and ticks < MOST_TICKS:
        begun = time.perf_counter()
        flock.run(ticks)
        seconds = time.perf_counter() - begun
        ticks *= 2
    return 2.0 * seconds / guess(ticks, case.agents, len(model(case.spec.model).columns))


def compile_models(experiment: Experiment, tell: Tell | None) -> None:
    """Compile the loop of every model before the threads start: numba compiles one at a time."""
    for case in {
        (case.spec.model, str(case.spec.chosen)): case for case in experiment.cases
    }.values():
        flock = flock_of(case, 0)
        compile_loop(flock, tell)
        experiment.settings.compile(flock)


def warn(experiment: Experiment, tell: Tell) -> None:
    """Tell of each model of an experiment whose agents go through what is solid."""
    flocks = [flock_of(case, 0) for case in experiment.cases]
    for words in dict.fromkeys(flock.warning for flock in flocks if flock.passing):
        tell(f"flockscope: {words}")


def conduct(
    experiment: Experiment,
    folder: Path,
    *,
    runs: int,
    seed: int,
    workers: int,
    tell: Tell | None,
    at: At,
    retry: bool = False,
) -> ExperimentReport:
    """Carry out an experiment with the seeds `seed` to `seed + runs - 1` in each case.

    `at` hears of the share that is done, the seconds left and the runs done. `retry`: whether runs
    that failed or were killed are made again. Raises InputError; after KeyboardInterrupt the
    finished runs are in the store.
    """
    with Store(folder, [column_of(one.name) for one in experiment.settings.measures]) as store:
        if retry:
            store.forget_broken()
        plan = RunPlan(experiment, runs, seed, store)
        tasks = plan.tasks
        taken = runs * len(plan.paths) - len(tasks)
        axes = dict.fromkeys(["label", "agents"])
        axes |= dict.fromkeys(name for case in experiment.cases for name in case.spec.parameters)
        store.tell(
            kind="paper",
            title=experiment.title,
            axes=list(axes),
            columns=list(store.columns),
            runs=runs * len(set(plan.numbers)),
        )
        if tasks:
            if tell is not None:
                warn(experiment, tell)
            compile_models(experiment, tell)
            plan.time()
            if tell is not None:
                left = max(1.0, plan.costs.ahead / workers)
                tell(f"{counted(len(tasks), 'run')} to make, about {duration(left)}")

        def keep(task: Task, outcome: Outcome) -> None:
            plan.keep(task, outcome)
            done = sum(plan.costs.done)
            at(
                plan.costs.share,
                plan.costs.ahead / workers,
                f"{done} of {counted(len(tasks), 'run')}",
            )

        def beat() -> bool:
            store.beat()
            return False

        soon = plan.costs.ahead < SOON
        made_by: RunExecutor = InlineExecutor(plan.job) if soon else Processes(plan.job, workers)
        with made_by as makers:
            makers.run(tasks, keep, beat)
        return ExperimentReport(plan.measured, taken, len(tasks), plan.astray, plan.failed)
