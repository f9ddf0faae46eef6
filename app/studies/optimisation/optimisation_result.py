"""What a search has come to: its best on fresh seeds, beside the default, and what ties with it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from app.studies.charts.run_group import label
from app.studies.judge.judge import ranges_of
from app.studies.judge.statistics import summary
from app.studies.optimisation.evaluations import EvaluatedPoint, Evaluations
from app.studies.optimisation.study import SearchGoal, Study, spec_at
from app.studies.search import End
from app.studies.sweeps.designs import Point
from app.studies.sweeps.sweep_file import Span
from worlds.number_text import counted

EDGE = 0.005
"""Share of an axis from its end within which a point lies on a bound."""
LITTLE = 0.02
"""Share of the gain over the default within which another point is as good."""
WIDE = 0.5
"""Share of an axis that ties have to span to be called a plateau."""
MOST_OF_FRONT = 20
"""Points of a front that are run with fresh seeds."""


@dataclass(frozen=True)
class Mean:
    """A mean with half of its 95 % interval."""

    value: float
    half: float
    interval: tuple[float, float] = (math.nan, math.nan)
    """All of it: its sides may be unlike."""

    @classmethod
    def of(cls, values: Sequence[float]) -> Mean:
        """That of values."""
        result = summary(ranges_of(values))
        return cls(result.mean, result.half_width, result.interval)

    def __str__(self) -> str:
        return f"{self.value:.4g}" + (f" ± {self.half:.2g}" if self.half == self.half else "")


@dataclass(frozen=True)
class ValidatedPoint:
    """A point on the fresh seeds."""

    what: str
    """The default, the best, ..."""
    point: Point
    means: list[Mean | None]
    """Of the objectives; None where a run has no value."""
    gains: list[Mean | None]
    """Over the default, seed by seed, above 0 where the point is better."""
    limits: list[Mean | None]
    """Of what the constraints are about."""
    on_search: list[float | None]
    """The means on the seeds of the search."""
    bounds: list[str]
    """The axes on whose bound it lies, with the bound."""
    spec: str
    """The run of it, as TOML."""


@dataclass(frozen=True)
class TiedPoints:
    """Points that are as good as the best, as far as the seeds of the search tell."""

    points: int
    of: int
    """Different points that have a value and keep to all constraints."""
    spans: dict[str, tuple[Any, Any, float]]
    """By axis: the least and the largest value among them, and the share of the axis."""
    furthest: ValidatedPoint | None
    """The one that is furthest from the best."""
    apart: Mean | None
    """By how much that is worse than the best, on the fresh seeds."""

    @property
    def is_plateau(self) -> bool:
        """Whether they span much of an axis: values can be compared, places cannot."""
        return self.points > 1 and any(share >= WIDE for *_, share in self.spans.values())


@dataclass(frozen=True)
class OptimisationResult:
    """What a search has come to."""

    goals: list[str]
    aims: list[str]
    limits: list[str]
    default: ValidatedPoint
    best: list[ValidatedPoint]
    """One; of several objectives the front, along the first."""
    ties: TiedPoints | None
    """Of a single objective."""
    evaluations: int
    different: int
    """Points that are not the same as another."""
    refused: int
    """Points that cannot be run, or that the condition leaves out."""
    valueless: int
    """Points some of whose runs gave up or failed: they count as worse than all others."""
    runs: int
    fresh_runs: int
    seeds: int
    fresh: int
    end: End

    @property
    def value(self) -> dict[str, Any]:
        """For JSON."""
        plateau = None if self.ties is None else self.ties.is_plateau
        return asdict(self) | {"plateau": plateau, "words": list(self.words())}

    def words(self) -> Iterator[str]:
        """The answer, a sentence each."""
        if not self.best:
            yield "no point has a value and keeps to all constraints: there is no best"
        elif len(self.goals) == 1:
            yield from self.describe_best()
        else:
            yield from self.describe_front()
        yield self.describe_effort()

    def describe_best(self) -> Iterator[str]:
        """The answer where there is one objective."""
        best, goal, aim = self.best[0], self.goals[0], self.aims[0]
        seeds = f"{self.fresh} fresh seeds"
        mean_text = best.means[0] or "not in every run"
        yield f"{aim} {goal}: {mean_text} at {label(best.point)} ({seeds})"
        yield self.describe_default(best, 0)
        if best.on_search[0] is not None:
            yield f"on the {self.seeds} seeds of the search it was {best.on_search[0]:.4g}"
        for name, mean in zip(self.limits, best.limits, strict=True):
            yield f"{name}: it is {mean or 'not there in every run'}"
        yield from describe_bounds(best)
        if self.ties is not None:
            yield from describe_ties(self.ties)

    def describe_default(self, point: ValidatedPoint, k: int) -> str:
        """A point beside the default."""
        text = (
            f"the default, {label(self.default.point)}, has {self.default.means[k] or 'no value'}"
        )
        gain, mean = point.gains[k], self.default.means[k]
        if gain is None or mean is None:
            return f"{text}: there is no gain to tell"
        share = f", {100.0 * abs(gain.value / mean.value):.2g}%" if mean.value else ""
        sure = gain.half == gain.half and abs(gain.value) > gain.half
        word = "gain" if gain.value > 0 else "loss"
        doubt = "" if sure else ": not told apart from chance"
        return f"{text}: a {word} of {Mean(abs(gain.value), gain.half)}{share}{doubt}"

    def describe_front(self) -> Iterator[str]:
        """The answer where there are several objectives."""
        goals = list(zip(self.goals, self.aims, strict=True))
        yield f"{counted(len(self.best), 'point')} on the front, told on {self.fresh} fresh seeds"
        for k, (goal, aim) in enumerate(goals):
            known_points = [point for point in self.best if point.means[k] is not None]
            if not known_points:
                continue
            sign = 1.0 if aim == "least" else -1.0
            end = min(known_points, key=lambda point: sign * point.means[k].value)  # type: ignore[union-attr]
            others = ", ".join(
                f"{other} {end.means[n]}" for n, (other, _) in enumerate(goals) if n != k
            )
            yield f"{aim} {goal}: {end.means[k]} with {others}, at {label(end.point)}"
            yield self.describe_default(end, k)
            yield from describe_bounds(end)

    def describe_effort(self) -> str:
        """What the search has cost, and why it is over."""
        text = f"{counted(self.evaluations, 'evaluation')} of {self.different} different points"
        text += f", {counted(self.runs, 'run')} of {self.seeds} seeds"
        text += f" and {self.fresh_runs} of fresh ones"
        if self.refused:
            text += f"; {counted(self.refused, 'point')} could not be run"
        if self.valueless:
            text += f"; of {counted(self.valueless, 'point')} a run gave up or failed"
        return (
            text
            + {
                "evaluations": "",
                "flat": "; it ended on a plateau: all points of a generation are equal",
                "converged": "; it ended by itself",
            }[self.end]
        )


def describe_bounds(point: ValidatedPoint) -> Iterator[str]:
    """On which bounds a point lies."""
    for bound in point.bounds:
        yield f"{bound}: there may be better beyond"


def describe_ties(ties: TiedPoints) -> Iterator[str]:
    """What ties with the best."""
    if ties.points < 2:
        yield f"none of {counted(ties.of, 'point')} ties with it"
        return
    spans = ", ".join(
        f"{name} from {format_value(low)} to {format_value(high)} ({share:.0%} of its range)"
        for name, (low, high, share) in ties.spans.items()
    )
    text = f"{ties.points - 1} of {ties.of - 1} other points tie with it: {spans}"
    yield text + (": a plateau, compare values and not places" if ties.is_plateau else "")
    if ties.furthest is not None and ties.apart is not None:
        where = label(ties.furthest.point)
        loss = describe_loss(ties.apart)
        yield f"the furthest of them, {where}, has {ties.furthest.means[0]}: {loss}"


def describe_loss(apart: Mean) -> str:
    """By how much a point is worse than the best."""
    word = "worse" if apart.value > 0 else "better"
    return f"{Mean(abs(apart.value), apart.half)} {word}"


def format_value(value: Any) -> str:
    """A value of an axis."""
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def make_result(
    study: Study, runs: Evaluations, course: list[EvaluatedPoint], end: End
) -> OptimisationResult:
    """The answer, for which fresh seeds are run. Raises HaltedError."""
    seeds = study.file.replicates
    good = [point for point in course if point.is_good]
    distinct = list({tuple(point.point.items()): point for point in reversed(good)}.values())[::-1]
    runs.run([study.default], seeds.search_seeds)
    chosen = front(study, distinct) if len(study.goals) > 1 else choose_best(study, distinct)
    ties, furthest = (
        (None, None) if len(study.goals) > 1 else find_ties(study, runs, distinct, chosen)
    )
    before = len(runs.used)
    told_of = [study.default, *(point.point for point in chosen)]
    runs.run([*told_of, *([furthest.point] if furthest else [])], seeds.fresh_seeds)
    default = evaluate_fresh(study, runs, "the default", study.default)
    best = [
        evaluate_fresh(
            study, runs, "on the front" if len(study.goals) > 1 else "the best", point.point, point
        )
        for point in chosen
    ]
    if ties is not None and furthest is not None:
        other = evaluate_fresh(study, runs, "the furthest that ties", furthest.point, furthest)
        apart = paired_loss(
            runs, study.goals[0], furthest.point, chosen[0].point, seeds.fresh_seeds
        )
        ties = TiedPoints(ties.points, ties.of, ties.spans, other, apart)
    return OptimisationResult(
        [goal.name for goal in study.goals],
        [goal.aim for goal in study.goals],
        [constraint.says for constraint in study.file.constraint],
        default,
        best,
        ties,
        len(course),
        len({tuple(point.point.items()) for point in course}),
        sum(bool(point.refused) for point in course),
        sum(point.without > 0.0 for point in course),
        before,
        len(runs.used) - before,
        seeds.count,
        seeds.fresh,
        end,
    )


def choose_best(study: Study, good: list[EvaluatedPoint]) -> list[EvaluatedPoint]:
    """The best point, the first of those that are equal; none if there is none."""
    sign = study.goals[0].sign
    return [min(good, key=lambda point: sign * point.means[0])] if good else []


def front(study: Study, good: list[EvaluatedPoint]) -> list[EvaluatedPoint]:
    """The points than which no other is better in all, along the first objective; at most 20."""
    if not good:
        return []
    values = np.array([point.means for point in good]) * [goal.sign for goal in study.goals]
    kept_indices: list[int] = []
    for k, row in enumerate(values):
        dominated = np.any(np.all(values <= row, axis=1) & np.any(values < row, axis=1))
        twice = any(np.array_equal(row, values[other]) for other in kept_indices)
        if not dominated and not twice:
            kept_indices.append(k)
    kept_indices.sort(key=lambda k: values[k, 0])
    if len(kept_indices) > MOST_OF_FRONT:
        places = np.linspace(0, len(kept_indices) - 1, MOST_OF_FRONT).round().astype(int)
        kept_indices = [kept_indices[k] for k in places]
    return [good[k] for k in kept_indices]


def find_ties(
    study: Study, runs: Evaluations, good: list[EvaluatedPoint], chosen: list[EvaluatedPoint]
) -> tuple[TiedPoints | None, EvaluatedPoint | None]:
    """The points that are as good as the best, and the furthest of them from it.

    As good is what is worse by little of what the best has gained over the default; where it has
    gained nothing, what is not told apart from it.
    """
    if not chosen:
        return None, None
    best, goal, seeds = chosen[0], study.goals[0], study.file.replicates.search_seeds
    gain = paired_loss(runs, goal, study.default, best.point, seeds)
    little = LITTLE * gain.value if gain is not None and gain.value > 0.0 else None
    same: list[EvaluatedPoint] = []
    for point in good:
        apart = paired_loss(runs, goal, point.point, best.point, seeds)
        if apart is None:
            continue
        sure = apart.half if math.isfinite(apart.half) else 0.0
        if apart.value <= (sure if little is None else little):
            same.append(point)
    spans: dict[str, tuple[Any, Any, float]] = {}
    for k, (name, axis) in enumerate(study.file.search.axes.items()):
        rising = sorted(same, key=lambda point: point.unit[k])
        first, last = rising[0], rising[-1]
        if isinstance(axis, Span):
            spans[name] = first.point[name], last.point[name], last.unit[k] - first.unit[k]
        else:
            values = {point.point[name] for point in same}
            share = len(values) / len(axis) if len(values) > 1 else 0.0
            spans[name] = first.point[name], last.point[name], share
    others = [point for point in same if point is not best]
    furthest = max(others, key=lambda point: math.dist(point.unit, best.unit), default=None)
    return TiedPoints(len(same), len(good), spans, None, None), furthest


def paired_loss(
    runs: Evaluations, goal: SearchGoal, point: Point, than: Point, seeds: range
) -> Mean | None:
    """By how much a point is worse than another, seed by seed; None if a run has no value."""
    values = [
        runs.values(candidate, goal.variant, goal.column, seeds) for candidate in (point, than)
    ]
    if any(value is None for row in values for value in row):
        return None
    first, second = np.array(values, float)
    return Mean.of((goal.sign * (first - second)).tolist())


def evaluate_fresh(
    study: Study,
    runs: Evaluations,
    what: str,
    point: Point,
    evaluated: EvaluatedPoint | None = None,
) -> ValidatedPoint:
    """A point on the fresh seeds."""
    seeds = study.file.replicates.fresh_seeds

    def mean(variant: int, column: str) -> Mean | None:
        values = runs.values(point, variant, column, seeds)
        numbers = [value for value in values if value is not None]
        return Mean.of(numbers) if len(numbers) == len(values) else None

    common = study.file.replicates.search_seeds
    searched = [runs.values(point, goal.variant, goal.column, common) for goal in study.goals]
    gains = [paired_loss(runs, goal, study.default, point, seeds) for goal in study.goals]
    return ValidatedPoint(
        what,
        dict(point),
        [mean(goal.variant, goal.column) for goal in study.goals],
        gains,
        [mean(limit.variant, limit.says.name) for limit in study.limits],
        [None if None in values else float(np.mean(values)) for values in searched],  # type: ignore[arg-type]
        bounds_reached(study, evaluated) if evaluated else [],
        spec_at(study, point).to_toml(),
    )


def bounds_reached(study: Study, point: EvaluatedPoint) -> list[str]:
    """The axes on whose bound a point lies, in words."""
    names = []
    for share, (name, axis) in zip(point.unit, study.file.search.axes.items(), strict=True):
        if isinstance(axis, Span) and not EDGE < share < 1.0 - EDGE:
            low = (share <= EDGE) == (axis.from_ < axis.to)
            bound = axis.from_ if share <= EDGE else axis.to
            names.append(f"{name} lies on its {'lower' if low else 'upper'} bound, {bound:g}")
    return names
