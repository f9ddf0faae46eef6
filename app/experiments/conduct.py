"""Carrying out an experiment: what is in the store is taken from it, the rest is run and kept."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.experiments.experiment import Case, Experiment
from app.experiments.kinds.settings import Number
from app.experiments.store import Key, Store, key_of
from app.experiments.trial import Result, Trial, fingerprint, flock_of
from app.experiments.workers.costs import Costs, guess
from app.experiments.workers.kernels import compile_loop
from app.experiments.workers.pool import run_all
from worlds.counting import counted, duration
from worlds.refusal import Refusal

ENOUGH, MOST_TICKS = 0.005, 4096
"""Seconds after which ticks that are timed are enough, and ticks."""
Tell = Callable[[str], object]
At = Callable[[float, float, str], object]


@dataclass(frozen=True)
class Measured:
    """A case with what its runs have given, each in the order of the seeds."""

    case: Case
    values: dict[str, list[Number | None]]
    """By measure; None for a run that has none."""


@dataclass(frozen=True)
class Done:
    """An experiment carried out."""

    measured: list[Measured]
    taken: int
    """Runs taken from the store."""
    made: int
    """Runs made now."""
    astray: list[str]
    """Of each run in which an agent was seen where it cannot be: which run, and which agent."""


class Plan:
    """Which runs an experiment needs, and which of them the store lacks."""

    def __init__(self, experiment: Experiment, runs: int, seed: int, store: Store):
        self.experiment = experiment
        self.store = store
        self.seeds = range(seed, seed + runs)
        cases = experiment.cases
        self.prints = [checked_fingerprint(case, experiment) for case in cases]
        self.paths = experiment.paths
        self.number = {id(cases[path[0]]): n for n, path in enumerate(self.paths)}
        self.missing = [
            [seed for seed in self.seeds if not self.has(path, seed)] for path in self.paths
        ]
        guesses = [sum(self.guess(cases[k]) for k in path) for path in self.paths]
        self.costs = Costs(guesses, self.left)

    def has(self, path: list[int], seed: int) -> bool:
        """Whether the store has a run in all of its cases."""
        return all(self.key(k, seed) in self.store.results for k in path)

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

    def key(self, case: int, seed: int) -> Key:
        """The key of a run of a case (by its number)."""
        return key_of(self.experiment.cases[case], seed, self.prints[case])

    @property
    def trials(self) -> list[Trial]:
        """The runs that the store lacks, the longest first."""
        order = sorted(range(len(self.paths)), key=lambda n: -self.costs.guesses[n])
        cases = self.experiment.cases
        along = [tuple(cases[k] for k in path) for path in self.paths]
        return [Trial(along[n], seed) for n in order for seed in self.missing[n]]

    def keep(self, trial: Trial, results: list[Result]) -> None:
        """Keep a run's results in the store and in the costs."""
        n = self.number[id(trial.cases[0])]
        for k, result in zip(self.paths[n], results, strict=True):
            self.store.add(self.key(k, trial.seed), result)
        self.costs.add(n, sum(result.seconds for result in results))

    @property
    def measured(self) -> list[Measured]:
        """All cases with their runs."""
        return [self.measured_of(k) for k in range(len(self.experiment.cases))]

    @property
    def astray(self) -> list[str]:
        """The runs in which an agent was seen where it cannot be, in words."""
        keys = [self.key(k, seed) for k in range(len(self.experiment.cases)) for seed in self.seeds]
        found = {key: self.store.results[key].astray for key in keys}
        return [
            f"{key.model}, N = {key.agents}, {key.parameters}, seed {key.seed}: {words}"
            for key, words in found.items()
            if words
        ]

    def measured_of(self, case: int) -> Measured:
        """A case (by its number) with its runs."""
        results = [self.store.results[self.key(case, seed)].measures for seed in self.seeds]
        names = [one.name for one in self.experiment.settings.measures]
        values = {name: [one[name] for one in results] for name in names}
        return Measured(self.experiment.cases[case], values)


def checked_fingerprint(case: Case, experiment: Experiment) -> str:
    """The case's fingerprint. Raises Refusal naming the experiment if it cannot be built."""
    try:
        return fingerprint(case, experiment.settings)
    except Refusal as refusal:
        raise Refusal(
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
) -> Done:
    """Carry out an experiment with the seeds `seed` to `seed + runs - 1` in each case.

    `at` hears of the share that is done, the seconds left and the runs done. Raises Refusal;
    after KeyboardInterrupt the finished runs are in the store.
    """
    with Store(folder / "runs.csv", experiment.settings.measures) as store:
        plan = Plan(experiment, runs, seed, store)
        trials = plan.trials
        taken = runs * len(plan.paths) - len(trials)
        if trials:
            if tell is not None:
                warn(experiment, tell)
            compile_models(experiment, tell)
            plan.time()
            if tell is not None:
                left = max(1.0, plan.costs.ahead / workers)
                tell(f"{counted(len(trials), 'run')} to make, about {duration(left)}")

        def keep(trial: Trial, results: list[Result]) -> None:
            plan.keep(trial, results)
            done = sum(plan.costs.done)
            at(
                plan.costs.share,
                plan.costs.ahead / workers,
                f"{done} of {counted(len(trials), 'run')}",
            )

        run_all(trials, experiment.settings, workers, keep)
        return Done(plan.measured, taken, len(trials), plan.astray)
