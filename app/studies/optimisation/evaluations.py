"""The runs of the points that a search proposes: taken from the store, or made and kept there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from app.studies.optimisation.study import Study
from app.studies.runs.database import BROKEN, Outcome
from app.studies.search import PENALTY, PointScores
from app.studies.study_runner import StudyRunner, Tell
from app.studies.sweeps.designs import Point
from app.studies.sweeps.sweep_cells import Cell
from app.studies.sweeps.sweep_job import RunRequest, SweepJob
from app.studies.sweeps.sweep_runner import is_own_code, prepare
from app.studies.workers.run_executors import Task
from worlds.input_error import InputError


class HaltedError(Exception):
    """The runs were to stop, or as many as were allowed are made."""


@dataclass
class OptimisationJob:
    """How runs of several variants are made: the job of the processes."""

    parts: tuple[SweepJob, ...]

    def prepare(self) -> None:
        """Find what measures. Raises InputError."""
        for part in self.parts:
            part.prepare()

    def run(self, task: tuple[int, RunRequest], seed: int) -> Outcome:
        """Make a run of a variant."""
        part, request = task
        return self.parts[part].run(request, seed)


class Evaluations:
    """A context manager: the store of an optimisation, and processes once there are runs to make.

    `at` hears of the seconds left and the runs. `limit`: runs to make now, at most.
    """

    def __init__(
        self,
        study: Study,
        folder: Path,
        *,
        workers: int,
        nice: int = 0,
        retry: bool = False,
        limit: int | None = None,
        tell: Tell | None = None,
    ):
        self.study = study
        names = [*study.default, *(name for variant in study.variants for name in variant.at)]
        self.runner = StudyRunner(
            folder,
            OptimisationJob(tuple(variant.sweep.making for variant in study.variants)),
            {
                "kind": "optimisation",
                "title": study.title,
                "axes": list(dict.fromkeys(names)),
                "columns": study.columns,
                "base": study.variants[0].sweep.base.to_toml(),
                "from_folder": str(study.folder.absolute()),
                "limit": study.file.run.ticks,
            },
            self.prepare,
            workers=workers,
            nice=nice,
            retry=retry,
            limit=limit,
            cluster=study.file.cluster,
            timeout=study.file.run.timeout,
            is_own_code=any(is_own_code(variant.sweep) for variant in study.variants),
            spec=study.text,
            tell=tell,
        )
        self.cells: dict[str, Cell] = {}
        """Those of the points so far, by their hash, in the order in which they were asked for."""
        self.numbers: dict[str, int] = {}
        self.by_point: dict[tuple, list[Cell]] = {}
        self.refused: dict[tuple, str] = {}
        self.taken = 0
        self.used: set[tuple[int, int]] = set()

    def __enter__(self) -> Evaluations:
        self.runner.__enter__()
        self.runner.plan([])
        return self

    def __exit__(self, *reason: Any) -> None:
        self.runner.__exit__(*reason)

    def prepare(self) -> None:
        """Compile what the runs of all variants call."""
        for variant in self.study.variants:
            prepare(variant.sweep, self.runner.tell)

    def cells_of(self, point: Point) -> list[Cell]:
        """The cells of a point, one for each variant. Raises InputError if they cannot be."""
        key = tuple(point.items())
        if key in self.refused:
            raise InputError(self.refused[key])
        if key not in self.by_point:
            try:
                self.by_point[key] = [variant.cell(point) for variant in self.study.variants]
            except InputError as refusal:
                self.refused[key] = str(refusal)
                raise
        return self.by_point[key]

    def run(self, points: Sequence[Point], seeds: range) -> None:
        """Have the runs of points with these seeds. Raises HaltedError where they are not all."""
        cells = [cell for point in points for cell in self.cells_of(point)]
        before = len(self.cells)
        for cell in cells:
            self.cells.setdefault(cell.hash, cell)
        if len(self.cells) > before:
            numbers = self.runner.plan(
                [(cell.hash, cell.stored_text) for cell in self.cells.values()]
            )
            self.numbers = dict(zip(self.cells, numbers, strict=True))
        distinct = {cell.hash: cell for cell in cells}
        parts = {cell.hash: k for point in points for k, cell in enumerate(self.cells_of(point))}
        tasks = []
        for seed in seeds:
            for name, cell in distinct.items():
                key = self.numbers[name], seed
                if key not in self.runner.outcomes:
                    tasks.append(Task(*key, (parts[name], RunRequest(cell.spec))))
                elif key not in self.used:
                    self.taken += 1
                self.used.add(key)
        if not self.runner.run(tasks):
            raise HaltedError

    def values(self, point: Point, variant: int, column: str, seeds: range) -> list[float | None]:
        """A column of the runs of a point, None for a run that gave up, failed or has none."""
        cell = self.numbers[self.cells_of(point)[variant].hash]
        outcomes = [self.runner.outcomes[cell, seed] for seed in seeds]
        column_values = [
            outcome.values.get(column) if outcome.status == "ok" else None for outcome in outcomes
        ]
        return [None if value is None else float(value) for value in column_values]

    @property
    def failed_runs(self) -> list[str]:
        """Of each run that failed or was killed: which, and why."""
        outcomes = self.runner.outcomes
        return [
            f"cell {cell}, seed {seed}: {outcomes[cell, seed].reason}"
            for cell, seed in sorted(self.used & outcomes.keys())
            if outcomes[cell, seed].status in BROKEN
        ]


# The course of a search: which points it has proposed, and what they are worth.

At = Callable[[float, str], Any]


@dataclass(frozen=True)
class EvaluatedPoint:
    """A point that was proposed, and what it is worth on the seeds of the search."""

    unit: tuple[float, ...]
    """Where it is in the unit cube."""
    point: Point
    generation: int
    means: tuple[float, ...] = ()
    """Of the objectives; empty where one has no value."""
    violations: tuple[float, ...] = ()
    """Of the constraints, above 0 where one is not kept."""
    without: float = 0.0
    """Share of its runs that have no value."""
    refused: str = ""
    """Why it cannot be run."""

    @property
    def is_good(self) -> bool:
        """Whether it has a value and keeps to all constraints."""
        return bool(self.means) and all(violation <= 0.0 for violation in self.violations)


@dataclass
class SearchHistory:
    """What a search has seen so far."""

    study: Study
    runs: Evaluations
    at: At
    evaluated: list[EvaluatedPoint] = field(default_factory=list)
    generation: int = 0

    def judge(self, units: np.ndarray) -> PointScores:
        """What the points of a generation are worth. Raises HaltedError."""
        study, seeds = self.study, self.study.file.replicates.search_seeds
        points = [study.point(row) for row in units]
        refused = [self.refusal(point) for point in points]
        self.tell()
        later = max(0, study.file.search.evaluations - len(self.evaluated) - len(points))
        each = len(study.variants) * study.file.replicates.count
        self.runs.runner.progress.later = later * each
        self.runs.run([p for p, why in zip(points, refused, strict=True) if not why], seeds)
        for unit, point, why in zip(units.tolist(), points, refused, strict=True):
            self.evaluated.append(self.evaluate(tuple(unit), point, why))
        self.generation += 1
        self.tell()
        new = self.evaluated[-len(points) :]
        signs = [goal.sign for goal in study.goals]
        objectives = [
            [sign * mean for sign, mean in zip(signs, point.means, strict=True)]
            if point.means
            else [PENALTY] * len(signs)
            for point in new
        ]
        none = (0.0,) * len(study.limits)
        violations = [
            [1.0 if point.refused else point.without, *(point.violations or none)] for point in new
        ]
        return PointScores(np.array(objectives), np.array(violations))

    def refusal(self, point: Point) -> str:
        """Why a point is not run, "" if it can be."""
        try:
            if not self.study.is_allowed(point):
                return f"{self.study.file.search.where} does not hold"
            self.runs.cells_of(point)
        except InputError as refusal:
            return str(refusal)
        return ""

    def evaluate(self, unit: tuple[float, ...], point: Point, refused: str) -> EvaluatedPoint:
        """What a point is worth, whose runs are made."""
        if refused:
            return EvaluatedPoint(unit, point, self.generation, refused=refused)
        seeds = self.study.file.replicates.search_seeds
        values = [
            self.runs.values(point, goal.variant, goal.column, seeds) for goal in self.study.goals
        ]
        limits = [
            self.runs.values(point, limit.variant, limit.says.name, seeds)
            for limit in self.study.limits
        ]
        every = [value for values in (*values, *limits) for value in values]
        missing = sum(value is None for value in every)
        if missing:
            share = missing / len(every)
            return EvaluatedPoint(unit, point, self.generation, without=share)
        return EvaluatedPoint(
            unit,
            point,
            self.generation,
            tuple(float(np.mean(values)) for values in values),  # type: ignore[arg-type]
            tuple(
                limit.violation(float(np.mean(values)))  # type: ignore[arg-type]
                for limit, values in zip(self.study.limits, limits, strict=True)
            ),
        )

    def tell(self) -> None:
        """Tell how far it is."""
        planned = self.study.file.search.evaluations
        done = len(self.evaluated)
        seeds = self.study.file.replicates
        runs = len(self.study.variants) * seeds.count
        left = max(0, planned - done) * runs
        run_count = self.runs.runner.made
        self.runs.runner.wanted = len(self.runs.used) + left
        self.runs.runner.store.tell(runs=self.runs.runner.wanted)
        self.at(
            done / (planned + 1),
            f"{done} of {planned} points, {run_count} runs made{self.best_word()}",
        )

    def best_word(self) -> str:
        """The best so far, of a single objective."""
        goal = self.study.goals[0]
        good = [goal.sign * point.means[0] for point in self.evaluated if point.is_good]
        if len(self.study.goals) > 1 or not good:
            return ""
        return f", {goal.aim} {goal.name} {goal.sign * min(good):.4g}"
