"""The course of a search: which points it has proposed, and what they are worth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.studies.optimisation.evaluations import Evaluations
from app.studies.optimisation.study import Study
from app.studies.search import PENALTY, PointScores
from app.studies.sweeps.given.designs import Point
from worlds.input_error import InputError

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
        return bool(self.means) and all(one <= 0.0 for one in self.violations)


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
        study, seeds = self.study, self.study.file.replicates.common
        points = [study.point(row) for row in units]
        refused = [self.refusal(point) for point in points]
        self.tell()
        self.runs.run([p for p, why in zip(points, refused, strict=True) if not why], seeds)
        for unit, point, why in zip(units.tolist(), points, refused, strict=True):
            self.evaluated.append(self.worth(tuple(unit), point, why))
        self.generation += 1
        self.tell()
        new = self.evaluated[-len(points) :]
        signs = [goal.sign for goal in study.goals]
        objectives = [
            [sign * mean for sign, mean in zip(signs, one.means, strict=True)]
            if one.means
            else [PENALTY] * len(signs)
            for one in new
        ]
        none = (0.0,) * len(study.limits)
        violations = [
            [1.0 if one.refused else one.without, *(one.violations or none)] for one in new
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

    def worth(self, unit: tuple[float, ...], point: Point, refused: str) -> EvaluatedPoint:
        """What a point is worth, whose runs are made."""
        if refused:
            return EvaluatedPoint(unit, point, self.generation, refused=refused)
        seeds = self.study.file.replicates.common
        found = [
            self.runs.values(point, goal.variant, goal.column, seeds) for goal in self.study.goals
        ]
        limits = [
            self.runs.values(point, one.variant, one.says.name, seeds) for one in self.study.limits
        ]
        every = [value for values in (*found, *limits) for value in values]
        missing = sum(value is None for value in every)
        if missing:
            share = missing / len(every)
            return EvaluatedPoint(unit, point, self.generation, without=share)
        return EvaluatedPoint(
            unit,
            point,
            self.generation,
            tuple(float(np.mean(values)) for values in found),  # type: ignore[arg-type]
            tuple(
                one.violation(float(np.mean(values)))  # type: ignore[arg-type]
                for one, values in zip(self.study.limits, limits, strict=True)
            ),
        )

    def tell(self) -> None:
        """Tell how far it is."""
        asked = self.study.file.search.evaluations
        done = len(self.evaluated)
        seeds = self.study.file.replicates
        runs = len(self.study.variants) * seeds.count
        left = max(0, asked - done) * runs
        made = self.runs.made
        self.runs.store.tell(runs=len(self.runs.used) + left)
        self.at(done / (asked + 1), f"{done} of {asked} points, {made} runs made{self.best_word()}")

    def best_word(self) -> str:
        """The best so far, of a single objective."""
        goal = self.study.goals[0]
        good = [goal.sign * one.means[0] for one in self.evaluated if one.is_good]
        if len(self.study.goals) > 1 or not good:
            return ""
        return f", {goal.aim} {goal.name} {goal.sign * min(good):.4g}"
