"""Carrying out an optimisation: the search, and then its best on seeds that it has not seen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.studies.optimisation.evaluations import (
    At,
    EvaluatedPoint,
    Evaluations,
    HaltedError,
    SearchHistory,
)
from app.studies.optimisation.optimisation_result import OptimisationResult, make_result
from app.studies.optimisation.study import Study
from app.studies.search import search
from app.studies.workers.process_executor import cores


@dataclass
class OptimisationReport:
    """An optimisation carried out, or stopped on the way."""

    made: int
    """Runs made now."""
    taken: int
    """Runs that the store had."""
    broken: list[str]
    """Each run that failed or was killed, in words."""
    answer: OptimisationResult | None
    """None where it was stopped."""
    course: list[EvaluatedPoint]


def optimise(
    study: Study,
    folder: Path,
    *,
    workers: int | None = None,
    nice: int = 0,
    retry: bool = False,
    limit: int | None = None,
    tell: Callable[[str], Any] | None = None,
    at: At = lambda *_: None,
) -> OptimisationReport:
    """Carry out an optimisation in a folder: spec.toml and runs.sqlite.

    Begun again it proposes what it has proposed before, and takes those runs from the store: so it
    goes on after any stop. `retry`: whether runs that failed are made again. `limit`: runs to make
    now. `at` hears of the share that is done, and words. Raises InputError.
    """
    settings = study.file.search
    runs = Evaluations(
        study, folder, workers=workers or cores(), nice=nice, retry=retry, limit=limit, tell=tell
    )
    course = SearchHistory(study, runs, at)
    answer = None
    with runs:
        try:
            end = search(
                settings.algorithm,
                len(settings.axes),
                len(study.goals),
                1 + len(study.limits),
                course.judge,
                evaluations=settings.evaluations,
                population=settings.generation,
                seed=settings.seed,
            )
            answer = make_result(study, runs, course.evaluated, end)
            runs.runner.store.tell(runs=len(runs.used))
        except HaltedError:
            pass
    return OptimisationReport(
        runs.runner.made, runs.taken, runs.failed_runs, answer, course.evaluated
    )
