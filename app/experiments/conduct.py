"""Carrying out an experiment: what is in the store is taken from it, the rest is run and kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.experiments.experiment import Cell, Experiment
from app.experiments.kinds.settings import Number
from app.experiments.store import Key, Store, key_of
from app.experiments.trial import Result, Trial, fingerprint, flock_of
from app.experiments.workers.costs import Costs, guess
from app.experiments.workers.kernels import compile_loop
from app.experiments.workers.pool import run_all
from worlds.counting import counted
from worlds.refusal import Refusal

Tell = Callable[[str], object]
At = Callable[[float, float, str], object]


@dataclass(frozen=True)
class Measured:
    """A cell with what its runs have given, each in the order of the seeds."""

    cell: Cell
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
        cells = experiment.cells
        self.prints = [checked_fingerprint(cell, experiment) for cell in cells]
        self.paths = experiment.paths
        self.number = {id(cells[path[0]]): n for n, path in enumerate(self.paths)}
        self.missing = [
            [seed for seed in self.seeds if not self.has(path, seed)] for path in self.paths
        ]
        guesses = [sum(self.guess(cells[k]) for k in path) for path in self.paths]
        self.costs = Costs(guesses, self.left)

    def has(self, path: list[int], seed: int) -> bool:
        """Whether the store has a run in all of its cells."""
        return all(self.key(k, seed) in self.store.results for k in path)

    def guess(self, cell: Cell) -> float:
        """Seconds that a run of a cell may take."""
        from agents.catalogue import model

        settings = self.experiment.settings
        published = cell.published(settings.measures[0].name)
        dt = flock_of(cell, settings, 0).dt
        ticks = settings.ticks(published.mean if published else None, dt)
        return guess(ticks, cell.agents, len(model(cell.model).columns))

    @property
    def left(self) -> list[int]:
        """Runs that each path lacks."""
        return [len(seeds) for seeds in self.missing]

    def key(self, cell: int, seed: int) -> Key:
        """The key of a run of a cell (by its number)."""
        return key_of(self.experiment.cells[cell], seed, self.prints[cell])

    @property
    def trials(self) -> list[Trial]:
        """The runs that the store lacks, the longest first."""
        order = sorted(range(len(self.paths)), key=lambda n: -self.costs.guesses[n])
        cells = self.experiment.cells
        along = [tuple(cells[k] for k in path) for path in self.paths]
        return [Trial(along[n], seed) for n in order for seed in self.missing[n]]

    def keep(self, trial: Trial, results: list[Result]) -> None:
        """Keep a run's results in the store and in the costs."""
        n = self.number[id(trial.cells[0])]
        for k, result in zip(self.paths[n], results, strict=True):
            self.store.add(self.key(k, trial.seed), result)
        self.costs.add(n, sum(result.seconds for result in results))

    @property
    def measured(self) -> list[Measured]:
        """All cells with their runs."""
        return [self.measured_of(k) for k in range(len(self.experiment.cells))]

    @property
    def astray(self) -> list[str]:
        """The runs in which an agent was seen where it cannot be, in words."""
        keys = [self.key(k, seed) for k in range(len(self.experiment.cells)) for seed in self.seeds]
        found = {key: self.store.results[key].astray for key in keys}
        return [
            f"{key.model}, N = {key.agents}, {key.parameters}, seed {key.seed}: {words}"
            for key, words in found.items()
            if words
        ]

    def measured_of(self, cell: int) -> Measured:
        """A cell (by its number) with its runs."""
        results = [self.store.results[self.key(cell, seed)].measures for seed in self.seeds]
        names = [one.name for one in self.experiment.settings.measures]
        values = {name: [one[name] for one in results] for name in names}
        return Measured(self.experiment.cells[cell], values)


def checked_fingerprint(cell: Cell, experiment: Experiment) -> str:
    """The cell's fingerprint. Raises Refusal naming the experiment if it cannot be built."""
    try:
        return fingerprint(cell, experiment.settings)
    except Refusal as refusal:
        raise Refusal(
            f"{refusal} ({experiment.name}, {cell.model} with N = {cell.agents})"
        ) from None


def compile_models(experiment: Experiment, tell: Tell | None) -> None:
    """Compile the loop of every model before the threads start: numba compiles one at a time."""
    for cell in {(cell.model, cell.activation): cell for cell in experiment.cells}.values():
        flock = flock_of(cell, experiment.settings, 0)
        compile_loop(flock, tell)
        experiment.settings.compile(flock)


def warn(experiment: Experiment, tell: Tell) -> None:
    """Tell of each model of an experiment whose agents go through what is solid."""
    flocks = [flock_of(cell, experiment.settings, 0) for cell in experiment.cells]
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
    """Carry out an experiment with the seeds `seed` to `seed + runs - 1` in each cell.

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
