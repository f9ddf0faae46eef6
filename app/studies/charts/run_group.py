"""Runs that a chart shows together: their summary, and how many of them have no value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from app.strict_table import Value
from app.studies.judge.judge import ranges_of
from app.studies.judge.statistics import MeasureSummary, summary


class RunGroup:
    """Runs of one place in a chart; subclasses say where that is, and hold these fields."""

    values: Sequence[float]
    """Of the runs that came to an end and have one."""
    gave_up: int
    """Runs that were given up; they are in no mean."""
    broken: int
    """Runs that failed or were killed."""

    @cached_property
    def summary(self) -> MeasureSummary:
        """Of the values: the only source of the numbers that charts and tables show."""
        return summary(ranges_of(self.values))

    @property
    def runs(self) -> int:
        """Runs with a value."""
        return len(self.values)

    @property
    def has_runs(self) -> bool:
        """Whether there is any run, with a value or without."""
        return bool(self.values or self.gave_up or self.broken)

    @property
    def mean(self) -> float:
        """Of the values; nan without any."""
        return self.summary.mean

    @property
    def sd(self) -> float:
        """Sample standard deviation (n - 1); nan below two values."""
        return self.summary.sd

    @property
    def half(self) -> float:
        """Half of the 95 % interval of the mean, its wider side; nan below two values, and of
        equal ones."""
        return self.summary.half_width


@dataclass(frozen=True)
class CellRuns(RunGroup):
    """The runs of a cell of a sweep."""

    axes: dict[str, Value]
    number: int
    """Of its cell in the store."""
    values: Sequence[float] = ()
    seeds: Sequence[int] = ()
    """Of the runs with a value, in their order."""
    gave_up: int = 0
    broken: int = 0


def is_number(value: Any) -> bool:
    """Whether a value has a place along an axis."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def values_of(groups: Sequence[CellRuns], axis: str) -> list[Value]:
    """The values that an axis takes, each once: numbers rising, words as they come."""
    values = list(dict.fromkeys(group.axes[axis] for group in groups if axis in group.axes))
    return sorted(values) if all(map(is_number, values)) else values


def varied_axes(groups: Sequence[CellRuns]) -> list[str]:
    """The axes that take more than one value, the one with most values first."""
    names = list(dict.fromkeys(name for group in groups for name in group.axes))
    counts = {name: len(values_of(groups, name)) for name in names}
    return sorted((name for name in names if counts[name] > 1), key=lambda name: -counts[name])


def label(axes: dict[str, Value]) -> str:
    """Axes with their values, for a legend.

    >>> label({"agents": 100, "eta": 0.5})
    'agents = 100, eta = 0.5'
    """
    return ", ".join(
        f"{name} = {value:g}" if is_number(value) else f"{name} = {value}"
        for name, value in axes.items()
    )
