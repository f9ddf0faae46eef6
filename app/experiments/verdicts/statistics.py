"""What a set of runs says: mean, spread, quartiles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

RESAMPLES = 2000
"""Resamples of a bootstrap."""


@dataclass(frozen=True)
class Summary:
    """A measure over the runs of a case."""

    runs: int
    """Runs that have a value."""
    absent: int
    """Runs without one, such as those given up; they count in no number here."""
    mean: float
    sd: float
    """Standard deviation, n - 1; NaN below two runs."""
    quartiles: tuple[float, float, float]
    interval: tuple[float, float]
    """95 % confidence interval of the mean, by bootstrap."""
    least: float
    most: float

    @property
    def median(self) -> float:
        """The second quartile."""
        return self.quartiles[1]

    @property
    def standard_error(self) -> float:
        """Of the mean."""
        return self.sd / math.sqrt(self.runs) if self.runs else math.nan


def summary(values: Sequence[float | None]) -> Summary:
    """Summary of a measure's values; None stands for a run that has none.

    >>> summary([1, 2, 3, 4, None]).quartiles
    (1.75, 2.5, 3.25)
    """
    there = np.array([k for k in values if k is not None], float)
    absent = len(values) - there.size
    nan = math.nan
    if there.size == 0:
        return Summary(0, absent, nan, nan, (nan, nan, nan), (nan, nan), nan, nan)
    low, middle, high = (float(q) for q in np.percentile(there, (25, 50, 75)))
    sd = float(there.std(ddof=1)) if there.size > 1 else nan
    return Summary(
        there.size,
        absent,
        float(there.mean()),
        sd,
        (low, middle, high),
        interval_of_mean(there),
        float(there.min()),
        float(there.max()),
    )


def interval_of_mean(values: np.ndarray) -> tuple[float, float]:
    """95 % confidence interval of the mean: 2.5 and 97.5 % of the means of resamples, (R,) -> 2.

    The resamples are drawn with a fixed seed: the same values give the same interval. NaN below two
    values.
    """
    if values.size < 2:
        return math.nan, math.nan
    rows = np.random.default_rng(0).integers(0, values.size, (RESAMPLES, values.size))
    low, high = np.percentile(values[rows].mean(axis=1), (2.5, 97.5))
    return float(low), float(high)
