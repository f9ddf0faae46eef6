"""Results at one value of the parameter, or near it: their mean and how far they spread."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.classroom.collect.hand_in import Point
from app.studies.charts.axis_limits import spans_decades
from app.studies.charts.run_group import RunGroup

MOST_ALONE = 12
"""Different values that are each a group, however few results there are of each."""
MOST_BINS = 15


@dataclass(frozen=True)
class ResultGroup(RunGroup):
    """Results that are taken together."""

    value: float
    """Of the parameter: theirs, or in the middle of theirs, its mean."""
    low: float
    high: float
    """Between which theirs lie."""
    values: tuple[float, ...] = ()
    """Results of different runs: one that two students handed in counts once."""
    gave_up: int = 0
    """Runs in which it did not happen; they are in no mean."""
    broken: int = 0


def distinct(points: Sequence[Point]) -> list[Point]:
    """The points without those whose run another has been already: they tell nothing new."""
    found: dict[str, Point] = {}
    for point in points:
        found.setdefault(point.spec, point)
    return list(found.values())


def groups_of(points: Sequence[Point], given: bool) -> list[ResultGroup]:
    """Points by the value of the parameter, rising; where values are free, near ones together.

    `given`: whether students were given values: then each value is a group by itself.
    """
    runs = distinct(points)
    values = sorted({point.value for point in runs})
    if given or len(values) <= MOST_ALONE:
        parts = [[point for point in runs if point.value == value] for value in values]
    else:
        parts = binned(runs, edges_of(values, len(runs)))
    return [grouped(part) for part in parts if part]


def edges_of(values: Sequence[float], runs: int) -> np.ndarray:
    """Edges (bins + 1,) of bins of equal width, or of equal ratio where values span decades."""
    bins = min(MOST_BINS, max(4, math.isqrt(runs)))
    between = np.geomspace if spans_decades(list(values)) else np.linspace
    return between(values[0], values[-1], bins + 1)


def binned(points: Sequence[Point], edges: np.ndarray) -> list[list[Point]]:
    """The points of each bin; the last one has its upper edge."""
    parts: list[list[Point]] = [[] for _ in edges[1:]]
    for point in points:
        place = int(np.searchsorted(edges, point.value, side="right")) - 1
        parts[min(max(place, 0), len(parts) - 1)].append(point)
    return parts


def grouped(points: Sequence[Point]) -> ResultGroup:
    """Points as a group."""
    values = [point.value for point in points]
    middle = values[0] if min(values) == max(values) else float(np.mean(values))
    return ResultGroup(
        middle,
        min(values),
        max(values),
        tuple(point.result for point in points if point.result is not None),
        sum(point.status == "gave-up" for point in points),
        sum(point.status == "failed" for point in points),
    )
