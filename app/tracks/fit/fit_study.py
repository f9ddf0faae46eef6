"""The evaluations of a fit: taken from the store of its folder, or made and kept there.

A cell is a model with values of its parameters; its run gives the cost of every frame, for each
sample of frames. The engine is that of all studies: processes where they pay, a commit every
quarter of a second, nothing lost by a stop but what was in flight.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.spec import versions
from app.studies.runs.database import Outcome
from app.studies.runs.store import canonical
from app.studies.runs.store_reader import StoreReader
from app.studies.study_runner import At, StudyRunner
from app.studies.workers.kernels import compile_loop
from app.studies.workers.run_executors import Task
from app.tracks.fit.frame_sample import FrameSample
from app.tracks.fit.one_step import OneStepPredictor
from worlds.input_error import InputError

KIND = "fit"
SEED = 0
"""A prediction has no noise, so a cell has one run."""


class FitStoppedError(Exception):
    """The fit was asked to stop; what it has evaluated is in its folder."""


@dataclass
class FitJob:
    """How cells are evaluated: the job of the processes."""

    predictors: tuple[OneStepPredictor, ...]
    samples: dict[str, FrameSample]
    """By column of the store."""

    def prepare(self) -> None:
        """Nothing: flocks are made by the first run of a thread."""

    def run(self, payload: tuple[int, Mapping[str, float]], seed: int) -> Outcome:  # noqa: ARG002
        """The costs of one cell: their means, and frame by frame."""
        number, point = payload
        predictor = self.predictors[number]
        series = {
            name: (sample.frame, predictor.costs(sample, point))
            for name, sample in self.samples.items()
        }
        values: dict[str, Any] = {
            name: float(np.nanmean(costs)) for name, (_, costs) in series.items()
        }
        return Outcome("ok", values, series=series)


@dataclass(frozen=True)
class RunnerSettings:
    """How the runs of a fit are made, and who hears of it."""

    workers: int = 1
    nice: int = 0
    limit: int | None = None
    """Runs to make now, at most."""
    tell: Callable[[str], Any] | None = None
    at: At = lambda *_: None
    """It hears of the share done, the seconds left, and words."""


DEFAULT_SETTINGS = RunnerSettings()


@dataclass(frozen=True)
class FitCell:
    """A run of a fit: what the job is given, and what the store knows it by."""

    payload: Any
    axes: dict[str, Any]
    """What differs from cell to cell."""
    identity: dict[str, Any]
    """All else that its numbers follow from."""
    basis: dict[str, Any]
    """Versions, code and world."""

    @property
    def stored(self) -> tuple[str, str]:
        """Its hash, another one if anything is different, and its JSON."""
        text = canonical({"axes": self.axes, "identity": self.identity, "basis": self.basis})
        return hashlib.sha256(text.encode()).hexdigest()[:24], text


def basis_of(flock: Flock) -> dict[str, Any]:
    """What the numbers of a flock's runs depend on."""
    return {
        "versions": versions(),
        "the world": hashlib.sha256(flock.world.to_toml().encode()).hexdigest()[:12],
        "the rule": flock.loop.cache_folder.name,
    }


@dataclass(frozen=True)
class EvaluatedCells:
    """Cells whose runs are all there."""

    numbers: list[int]
    """Of each cell in the store."""
    made: int
    """Runs made now."""
    taken: int
    """Runs that the store had."""


def evaluate_cells(
    title: str,
    folder: Path,
    job: Any,
    columns: Sequence[str],
    cells: Sequence[FitCell],
    prepare: Callable[[], None],
    settings: RunnerSettings,
) -> EvaluatedCells:
    """Have the runs of all cells in the store of a folder, made where they are not there.

    Raises FitStoppedError where it was asked to stop, and InputError.
    """
    axes = dict.fromkeys(name for cell in cells for name in cell.axes)
    runner = StudyRunner(
        folder,
        job,
        {"kind": KIND, "title": title, "axes": list(axes), "columns": list(columns)},
        prepare,
        workers=settings.workers,
        nice=settings.nice,
        limit=settings.limit,
        remembered=[],
        tell=settings.tell,
        at=settings.at,
    )
    with runner:
        numbers = runner.plan([cell.stored for cell in cells])
        tasks = [
            Task(number, SEED, cell.payload)
            for number, cell in zip(numbers, cells, strict=True)
            if (number, SEED) not in runner.outcomes
        ]
        runner.wanted = len(cells)
        is_complete = runner.run(tasks)
        failed = [
            outcome.reason
            for (number, _), outcome in runner.outcomes.items()
            if number in runner.cells and outcome.status != "ok"
        ]
    if not is_complete:
        raise FitStoppedError
    if len(failed) >= len(set(numbers)):
        raise InputError(f"no cell could be evaluated: {failed[0]}")
    return EvaluatedCells(numbers, runner.made, len(cells) - len(tasks))


@dataclass(frozen=True)
class FitCells:
    """The cells of a model, and their costs."""

    points: list[Mapping[str, float]]
    costs: dict[str, np.ndarray]
    """(C, F) by sample; NaN for a cell whose run failed."""


@dataclass
class FitStudy:
    """All cells of a fit by prediction."""

    title: str
    folder: Path
    predictors: Sequence[OneStepPredictor]
    samples: dict[str, FrameSample]
    points: Sequence[list[Mapping[str, float]]]
    """Of each predictor."""
    settings: RunnerSettings = DEFAULT_SETTINGS
    made: int = 0
    """Cells evaluated so far,"""
    taken: int = 0
    """and cells that the store had."""

    def any_flock(self, predictor: OneStepPredictor) -> Flock:
        """A flock of a model, of as many as are in the first frame."""
        sample = next(iter(self.samples.values()))
        return predictor.flock(int(sample.present[0].sum()))

    def compile_models(self) -> None:
        """Compile what the predictions call, once."""
        for predictor in self.predictors:
            compile_loop(self.any_flock(predictor), self.settings.tell)

    def cells(self) -> list[FitCell]:
        """The cells of all models."""
        cells = []
        for number, predictor in enumerate(self.predictors):
            identity = {
                "fixed": predictor.scaled.fixed,
                "most_angle": predictor.most_angle,
                "frames": {name: sample.digest for name, sample in self.samples.items()},
            }
            basis, name = basis_of(self.any_flock(predictor)), predictor.scaled.name
            cells += [
                FitCell((number, point), {"model": name, **point}, identity, basis)
                for point in self.points[number]
            ]
        return cells

    def evaluate(self) -> list[FitCells]:
        """The costs of all cells, model by model. Raises FitStoppedError and InputError."""
        job = FitJob(tuple(self.predictors), self.samples)
        done = evaluate_cells(
            self.title, self.folder, job, list(self.samples), self.cells(), self.compile_models,
            self.settings,
        )  # fmt: skip
        self.made, self.taken = self.made + done.made, self.taken + done.taken
        return self.collect(done.numbers)

    def collect(self, numbers: list[int]) -> list[FitCells]:
        """The costs of all cells from the store."""
        place = {cell: k for k, cell in enumerate(numbers)}
        tables = {
            name: np.full((len(numbers), len(sample.frame)), np.nan)
            for name, sample in self.samples.items()
        }
        for cell, _, name, _, values in StoreReader(self.folder).series():
            if name in tables and cell in place:
                tables[name][place[cell]] = values
        cells, begin = [], 0
        for points in self.points:
            end = begin + len(points)
            cells.append(FitCells(points, {n: table[begin:end] for n, table in tables.items()}))
            begin = end
        return cells
