"""Carrying out an experiment: what is in the store is taken from it, the rest is run and kept."""

from __future__ import annotations

import hashlib
import inspect
import json
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from agents.catalogue import is_built_in
from agents.engine.cache import fingerprint as feed
from agents.flock import Flock
from agents.spec import Spec, values_of, values_of_kinds, versions
from app.studies.experiment import Case, Experiment, flock_of
from app.studies.experiment_file import PLAIN
from app.studies.measure import Number, Settings
from app.studies.runs.database import BROKEN, FIXED, Outcome
from app.studies.runs.store import canonical
from app.studies.study_runner import At, StudyReport, StudyRunner, Tell
from app.studies.workers.flock_pool import FlockPool
from app.studies.workers.kernels import compile_loop
from app.studies.workers.run_executors import Task
from app.studies.workers.run_worker import stop_if_unwanted
from worlds.input_error import InputError
from worlds.number_text import counted, duration

# How long runs take: a guess from the published times, put right by the runs that are done.

PER_AGENT_TICK = 1e-7
"""Seconds per agent and tick to begin with."""
PER_SIGNAL = 3.0
"""How many times dearer a tick is for each signal of the rule."""


def guess_seconds(ticks: float, agents: int, signals: int) -> float:
    """Seconds that a run of so many ticks may take; `signals` of the rule."""
    return ticks * (agents + 1) * PER_AGENT_TICK * (1.0 + PER_SIGNAL * signals)


# One run of an experiment: a flock from its start to what the experiment waits for.


@dataclass(frozen=True)
class Result:
    """What a run has given in one of its cases."""

    measures: dict[str, Number | None]
    """By name; None where the run has none, such as k_con of a run that was given up."""
    seconds: float
    astray: str = ""
    """The first agent that was seen where it cannot be, in words; empty if none was."""


def run_cases(flock: Flock, cases: Sequence[Case], settings: Settings) -> list[Result]:
    """Run a flock to the end of each of its cases, the first of which it is made for.

    There are several where the run goes through several values of a parameter, in that order.
    """
    started = time.perf_counter()
    astray: list[str] = []

    def look() -> None:
        stop_if_unwanted()
        stray_agents = None if astray else flock.stray()
        if stray_agents is not None:
            astray.append(str(stray_agents))

    results: list[Result] = []
    for case in cases:
        if results:  # it has begun with the parameters of the first
            flock.set(**case.spec.parameters | case.spec.individuals)
        measures = settings.run(flock, look)
        ended = time.perf_counter()
        look()
        results.append(Result(measures, ended - started, "".join(astray)))
        started = ended
    return results


NAN = "nan"
"""What stands for nan in a store, where SQLite would keep nothing."""


@dataclass(frozen=True)
class Trials:
    """How the runs of an experiment are made; one is asked for by the number of its path."""

    paths: tuple[tuple[Case, ...], ...]
    settings: Settings
    flocks: FlockPool = field(default_factory=FlockPool, compare=False)

    def prepare(self) -> None:
        """There is nothing to prepare."""

    def run(self, path: int, seed: int) -> Outcome:
        """Make a run; what it gave in its later cases is the rest."""
        cases = self.paths[path]
        with self.flocks.begin(cases[0], seed, lambda: flock_of(cases[0], seed)) as flock:
            results = run_cases(flock, cases, self.settings)
        first, *rest = [outcome_of(result) for result in results]
        return first._replace(rest=tuple(rest))


def column_of(measure: str) -> str:
    """The column of a measure in the store, where another may have its name already."""
    return f"{measure}_measured" if measure in FIXED else measure


def outcome_of(result: Result) -> Outcome:
    """A result as the store keeps it."""
    measures = {
        column_of(name): NAN if isinstance(value, float) and math.isnan(value) else value
        for name, value in result.measures.items()
    }
    return Outcome("ok", measures, seconds=result.seconds, astray=result.astray)  # type: ignore[arg-type]


def result_of(outcome: Outcome, settings: Settings) -> Result:
    """What the store kept as a result."""
    values = {
        measure.name: outcome.values[column_of(measure.name)] for measure in settings.measures
    }
    measures = {name: math.nan if value == NAN else value for name, value in values.items()}
    return Result(measures, outcome.seconds, outcome.astray)


def fingerprint(case: Case, settings: Settings) -> str:
    """A hash of what a case's numbers depend on beside model, agents, parameters and seed.

    The world and the criterion, the way that a run has come, the versions, the compiled loop with
    all that it reaches, what measures it, and how a flock starts.
    """
    flock = flock_of(case, 0)
    shared = settings.model_dump(exclude={"parameters", "words"}) | {"size": case.spec.size}
    if case.sweep and case.way:
        shared |= {"way": case.way, "values": case.sweep.values}
    if case.tick is not None:
        shared |= {"tick": case.tick}
    if case.row and case.row.mission != PLAIN:
        shared |= {"mission": case.row.mission.model_dump()}
    shared |= case.spec.chosen
    if case.spec.kinds:
        shared |= {"kinds": values_of_kinds(case.spec.kinds), "to": values_of(case.spec.to)}
    digest = hashlib.sha256(json.dumps([shared, versions()], sort_keys=True).encode())
    digest.update(json.dumps(flock.parameters.model_dump(), sort_keys=True).encode())
    digest.update(inspect.getsource(type(settings)).encode())
    for one in flock.kind_models:
        digest.update(json.dumps(one.parameters.model_dump(), sort_keys=True).encode())
    for loop in flock.loops:
        digest.update(loop.cache_folder.name.encode())
    visited: set[int] = set()
    for kernel in settings.measured_by:
        feed(kernel, digest, visited)
    for array in flock.engine.surroundings:
        digest.update(np.asarray(array).tobytes())
    digest.update(flock.position.tobytes())
    digest.update(flock.heading.tobytes())
    return digest.hexdigest()[:12]


ENOUGH, MOST_TICKS = 0.002, 4096
"""Seconds after which ticks that are timed are enough, and ticks."""


@dataclass(frozen=True)
class MeasuredCase:
    """A case with what its runs have given, each in the order of the seeds."""

    case: Case
    values: dict[str, list[Number | None]]
    """By measure; None for a run that has none."""


@dataclass
class ExperimentReport(StudyReport):
    """An experiment carried out."""

    measured: list[MeasuredCase] = field(default_factory=list)
    astray: list[str] = field(default_factory=list)
    """Of each run in which an agent was seen where it cannot be: which run, and which agent."""
    failed: list[str] = field(default_factory=list)
    """Of each run that raised, or whose process was killed: which run, and why."""


class RunPlan:
    """Which runs an experiment needs, and which of them the store lacks."""

    def __init__(self, experiment: Experiment, runs: int, seed: int, runner: StudyRunner):
        self.experiment = experiment
        self.seeds = range(seed, seed + runs)
        self.numbers = runner.plan([cell_of(case, experiment) for case in experiment.cases])
        self.outcomes = runner.outcomes
        self.paths = experiment.paths
        self.missing = [
            [seed for seed in self.seeds if not self.has_run(path, seed)] for path in self.paths
        ]

    def has_run(self, path: list[int], seed: int) -> bool:
        """Whether the store has a run in all of its cases."""
        return all((self.numbers[k], seed) in self.outcomes for k in path)

    def guesses(self) -> dict[int, float]:
        """Seconds that a run of each path may take, where one is to be made, by its first ticks."""
        cases = self.experiment.cases
        return {
            n: sum(self.guess_seconds(cases[k]) for k in path) * slowness(cases[path[0]])
            for n, path in enumerate(self.paths)
            if self.missing[n]
        }

    def guess_seconds(self, case: Case) -> float:
        """Seconds that a run of a case may take."""
        from agents.catalogue import model

        settings = self.experiment.settings
        published = case.published(settings.measures[0].name)
        dt = flock_of(case, 0).dt
        ticks = settings.ticks(published.mean if published else None, dt)
        return guess_seconds(ticks, case.agents, len(model(case.spec.model).columns))

    def tasks(self, guesses: dict[int, float]) -> list[Task]:
        """The runs that the store lacks, the longest first."""
        order = sorted(guesses, key=lambda n: -guesses[n])
        return [Task(n, seed, n) for n in order for seed in self.missing[n]]

    def parts(self, task: Task, outcome: Outcome) -> list[tuple[int, Outcome]]:
        """The cases of a run, each with its outcome; a broken one is broken in all of them."""
        path = self.paths[task.payload]
        parts = [outcome, *outcome.rest] if outcome.status == "ok" else [outcome] * len(path)
        return [(self.numbers[k], part) for k, part in zip(path, parts, strict=True)]

    @property
    def sound_seeds(self) -> list[int]:
        """The seeds whose runs all came to an end: a mean over others would compare unlike runs."""
        broken = {
            seed
            for number in self.numbers
            for seed in self.seeds
            if self.outcomes[number, seed].status in BROKEN
        }
        return [seed for seed in self.seeds if seed not in broken]

    @property
    def measured_cases(self) -> list[MeasuredCase]:
        """All cases with their runs. Raises InputError if a run of every seed is broken."""
        seeds = self.sound_seeds
        if not seeds:
            raise InputError(
                f"{self.experiment.name}: of every seed a run failed: {self.failed_runs[0]}"
            )
        return [self.measured_case(k, seeds) for k in range(len(self.experiment.cases))]

    @property
    def stray_runs(self) -> list[str]:
        """The runs in which an agent was seen where it cannot be, in words."""
        return self.describe_runs(lambda outcome: outcome.astray)

    @property
    def failed_runs(self) -> list[str]:
        """The runs that failed or were killed, in words."""
        return self.describe_runs(lambda outcome: outcome.reason)

    def describe_runs(self, words: Callable[[Outcome], str]) -> list[str]:
        """Each run of which there is something to tell, with that."""
        messages: dict[tuple[int, int], str] = {}
        for number, case in zip(self.numbers, self.experiment.cases, strict=True):
            spec = case.spec
            parameters = json.dumps(written(spec), sort_keys=True, separators=(",", ":"))
            for seed in self.seeds:
                message = words(self.outcomes[number, seed])
                if message:
                    run = f"{spec.model}, N = {case.agents}, {parameters}, seed {seed}"
                    messages[number, seed] = f"{run}: {message}"
        return list(messages.values())

    def measured_case(self, case: int, seeds: list[int]) -> MeasuredCase:
        """A case (by its number) with its runs."""
        number = self.numbers[case]
        settings = self.experiment.settings
        outcomes = [self.outcomes[number, seed] for seed in seeds]
        results = [result_of(outcome, settings).measures for outcome in outcomes]
        names = [measure.name for measure in settings.measures]
        values = {name: [result[name] for result in results] for name in names}
        return MeasuredCase(self.experiment.cases[case], values)


def cell_of(case: Case, experiment: Experiment) -> tuple[str, str]:
    """The hash and the JSON of a case, as the store has them. Raises InputError."""
    spec = case.spec
    identity = {"model": spec.model, "agents": case.agents, "parameters": written(spec)}
    basis = {"all else": named_fingerprint(case, experiment)}
    key = canonical({"identity": identity, "basis": basis})
    axes = {"label": case.label, "agents": case.agents, **written(spec)}
    content = {"axes": axes, "identity": identity, "basis": basis}
    return hashlib.sha256(key.encode()).hexdigest()[:24], canonical(content)


def written(spec: Spec) -> dict[str, Any]:
    """The parameters of a run as a table has them: distributions as text."""
    return spec.parameters | {name: d.to_text() for name, d in spec.individuals.items()}


def named_fingerprint(case: Case, experiment: Experiment) -> str:
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
        started = time.perf_counter()
        flock.run(ticks)
        seconds = time.perf_counter() - started
        ticks *= 2
    return 2.0 * seconds / guess_seconds(ticks, case.agents, len(model(case.spec.model).columns))


def compile_models(experiment: Experiment, tell: Tell | None) -> None:
    """Compile the loop of every model before the threads start: numba compiles one at a time."""
    for case in {
        (case.spec.model, str(case.spec.chosen), bool(case.spec.kinds)): case
        for case in experiment.cases
    }.values():
        flock = flock_of(case, 0)
        compile_loop(flock, tell)
        experiment.settings.compile(flock)


def warn_of_passing(experiment: Experiment, tell: Tell) -> None:
    """Tell of each model of an experiment whose agents go through what is solid, and of numbers of
    agents that were drawn again."""
    flocks = [flock_of(case, 0) for case in experiment.cases]
    for words in dict.fromkeys(flock.warning for flock in flocks if flock.warning):
        tell(f"flockscope: {words}")


def run_experiment(
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
    that failed or were killed are made again. Raises InputError; after KeyboardInterrupt, as which
    a request to stop is raised too, the finished runs are in the store.
    """
    cases, settings = experiment.cases, experiment.settings
    axes = dict.fromkeys(["label", "agents"])
    axes |= dict.fromkeys(name for case in cases for name in case.spec.parameters)
    runner = StudyRunner(
        folder,
        Trials(tuple(tuple(cases[k] for k in path) for path in experiment.paths), settings),
        {
            "kind": "paper",
            "title": experiment.title,
            "axes": list(axes),
            "columns": [column_of(measure.name) for measure in settings.measures],
        },
        lambda: None,
        workers=workers,
        retry=retry,
        is_own_code=not all(is_built_in(name) for case in cases for name in case.spec.models),
        tell=tell,
        at=at,
    )
    with runner:
        plan = RunPlan(experiment, runs, seed, runner)
        runner.parts = plan.parts
        runner.wanted = runs * len(set(plan.numbers))
        runner.store.tell(runs=runner.wanted)
        tasks: list[Task] = []
        if any(plan.missing):
            if tell is not None:
                warn_of_passing(experiment, tell)
            compile_models(experiment, tell)
            runner.progress.guesses = plan.guesses()
            tasks = plan.tasks(runner.progress.guesses)
            runner.progress.expect(task.cell for task in tasks)
            if tell is not None:
                left = max(1.0, runner.progress.seconds / workers)
                tell(f"{counted(len(tasks), 'run')} to make, about {duration(left)}")
        if not runner.run(tasks):
            raise KeyboardInterrupt
        return ExperimentReport(
            len(tasks),
            runs * len(plan.paths) - len(tasks),
            runner.failed_count,
            measured=plan.measured_cases,
            astray=plan.stray_runs,
            failed=plan.failed_runs,
        )
