"""The results of a class for one question, as they come in, and which value each student has.

It belongs to one thread. What is slow is asked of it elsewhere: a result is made by `hand_in` in a
process, and a `Collection` can be sent to one that draws its picture.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from agents.spec import CompleteSpec
from app.classroom.collect.class_curve import ClassCurve
from app.classroom.collect.hand_in import Point, ResultGroup
from app.classroom.collect.question import Question
from app.studies.charts.axis_limits import (
    Limits,
    column_bounds,
    measure_limits,
    parameter_bounds,
    parameter_limits,
    spans_decades,
)
from app.viewer.gallery.saved_scene import SavedScene
from worlds.input_error import InputError
from worlds.number_text import counted as count

# Results at one value of the parameter, or near it: their mean and how far they spread.

MOST_ALONE = 12
"""Different values that are each a group, however few results there are of each."""
MOST_BINS = 15


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
    return [group_points(part) for part in parts if part]


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


def group_points(points: Sequence[Point]) -> ResultGroup:
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


MOST_POINTS = 5_000
"""Results of a question."""
MOST_OF_ONE = 100
"""Results of a student to a question."""
MOST_GIVEN = 1_000
"""Students that are given a value or a seed."""


@dataclass(frozen=True)
class StudentAssignment:
    """What a student begins with."""

    value: float | None
    """Of the parameter; None: students choose."""
    seed: int
    """One for each student: two runs of one seed and one value are the same run."""
    kind: str = ""
    """Which kind of agents they play; empty: all."""


def spread_order(count: int) -> list[int]:
    """The order in which so many values are given, so that few already cover the whole range.

    The ends come first, then always the value that is furthest from those that are taken.

    >>> spread_order(5)
    [0, 4, 2, 1, 3]
    """
    taken = [0, count - 1][:count]
    while len(taken) < count:
        free = (k for k in range(count) if k not in taken)
        taken.append(max(free, key=lambda k: (min(abs(k - one) for one in taken), -k)))
    return taken


@dataclass
class Collection:
    """The points of one question, in the order in which they came in."""

    question: Question
    points: list[Point] = field(default_factory=list)
    given: dict[str, StudentAssignment] = field(default_factory=dict)
    """By student."""
    curve: ClassCurve | None = None
    """What a sweep has of the question, once it is found or made."""
    scene: SavedScene | None = None
    """What the class had when it was asked; None: what the class has."""

    def give(self, student: str) -> StudentAssignment:
        """The value, the seed and the kind of a student, always the same. Raises InputError.

        Of the kinds the one that fewest play; of the values the one that fewest of them have, in an
        order that covers the range early.
        """
        if student in self.given:
            return self.given[student]
        if len(self.given) >= MOST_GIVEN:
            raise InputError(f"{MOST_GIVEN} students have been given a value: no more are")
        values, kinds = self.question.values, self.question.kinds
        played = Counter(one.kind for one in self.given.values())
        kind = min(kinds, key=lambda one: played[one]) if kinds else ""
        value = None
        if values:
            held = Counter(one.value for one in self.given.values() if one.kind == kind)
            order = [values[k] for k in spread_order(len(values))]
            value = min(order, key=lambda one: held[one])
        seed = 1 + max((one.seed for one in self.given.values()), default=0)
        self.given[student] = StudentAssignment(value, seed, kind)
        return self.given[student]

    def take_back(self, student: str) -> None:
        """Have the value of a student who goes without a result given to the next."""
        if not any(point.student == student for point in self.points):
            self.given.pop(student, None)

    def begins(self, student: str, scene: CompleteSpec) -> CompleteSpec:
        """The run that a student begins with: the class's, with their value and their seed."""
        given = self.give(student)
        spec = self.question.begun_scene(scene).with_values(seed=given.seed)
        return spec if given.value is None else self.question.with_value(spec, given.value)

    def demand_room(self, student: str, ended: int = 0) -> None:
        """Refuse a result before it is made, if there is no room for it. Raises InputError.

        `ended`: runs of the student that were ended, which count as well.
        """
        if len(self.points) >= MOST_POINTS:
            raise InputError(f"{MOST_POINTS:,} results are there: no more are taken")
        if ended + sum(point.student == student for point in self.points) >= MOST_OF_ONE:
            raise InputError(f"{MOST_OF_ONE} results of {student} are there: no more are taken")

    def add(self, point: Point) -> int:
        """Take a result; its number, from 0. Raises InputError."""
        self.demand_room(point.student)
        self.points.append(point)
        return len(self.points) - 1

    @property
    def counting(self) -> list[bool]:
        """Of each point, whether it counts: all, or the last one of each student."""
        if self.question.counts == "all":
            return [True] * len(self.points)
        last = {point.student: number for number, point in enumerate(self.points)}
        return [last[point.student] == number for number, point in enumerate(self.points)]

    @property
    def counted(self) -> list[Point]:
        """The points that count."""
        pairs = zip(self.points, self.counting, strict=True)
        return [point for point, counts in pairs if counts]

    def groups(self) -> list[ResultGroup]:
        """Mean and spread by value, rising, of the runs that are as the class's scene has them."""
        counted = [one for one in self.counted if not one.differs]
        return groups_of(counted, bool(self.question.values))

    def is_log(self, beside: Iterable[float] = ()) -> bool:
        """Whether the values, and those of a curve, are shown on a logarithmic axis."""
        return spans_decades([*self.question.values, *(one.value for one in self.counted), *beside])

    def axis_limits(self, curve: Sequence[ResultGroup] = ()) -> tuple[Limits, Limits]:
        """The ends of the axes of the parameter and of the result, a curve's groups among them."""
        question = self.question
        places = [*question.values, *(point.value for point in self.points)]
        places += [group.value for group in curve]
        groups = [group for group in (*self.groups(), *curve) if group.values]
        results = [point.result for point in self.points if point.result is not None]
        results += [group.mean for group in groups]
        ends = [end for group in groups for end in group.summary.interval]
        log = self.is_log([group.value for group in curve])
        along = parameter_bounds(question.model_of(question.parameter), question.parameter)
        up = column_bounds(question.column)
        return parameter_limits(places, along, log), measure_limits(results, up, ends)

    def told(self) -> str:
        """How many results there are, in words."""
        counted = self.counted
        students = len({point.student for point in counted})
        said = f"{count(len(counted), 'result')} of {count(students, 'student')}"
        without = Counter(point.status for point in counted)
        said += f"; {without['gave-up']} did not come to it" if without["gave-up"] else ""
        said += f"; {without['failed']} failed" if without["failed"] else ""
        twice = len(counted) - len(distinct(counted))
        said += f"; {count(twice, 'run')} handed in twice, counted once" if twice else ""
        other = sum(bool(point.differs) for point in counted)
        return said + (f"; {other} not of the class's scene, in no mean" if other else "")
