"""What a set of runs says: mean, spread, quartiles."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from app.studies.judge.judge import INTERVAL_CONFIDENCE, RunRanges


@dataclass(frozen=True)
class MeasureSummary:
    """A measure over the runs of a case; a run that was given up counts as its limit."""

    runs: int
    """Runs that have a value."""
    absent: int
    """Runs without one."""
    limit: float | None
    """What those are at least, if they were given up; None where they count in no number here."""
    mean: float
    """With `limit`: of min(value, limit), and the true one is at least this."""
    sd: float
    """Standard deviation, n - 1; NaN below two runs, and where runs were given up."""
    quartiles: tuple[float, float, float]
    interval: tuple[float, float]
    """95 % confidence interval of the mean, NaN where nothing is known; infinite above where runs
    were given up."""
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

    @property
    def half_width(self) -> float:
        """Half of the interval, as `half_width` has it."""
        return half_width(self.mean, self.interval)


def summary(values: RunRanges) -> MeasureSummary:
    """Summary of what runs gave.

    >>> from app.studies.judge.judge import ranges_of
    >>> summary(ranges_of([1, 2, 3, 4, None])).quartiles
    (1.75, 2.5, 3.25)
    >>> summary(ranges_of([1, 2, 3, 4, None], limit=10)).mean
    4.0
    """
    ended = values.least == values.most
    absent = values.runs - int(ended.sum())
    is_limited = values.are_limited
    present = values.least if is_limited else values.least[ended]
    nan = math.nan
    if present.size == 0:
        return MeasureSummary(0, absent, None, nan, nan, (nan, nan, nan), (nan, nan), nan, nan)
    low, middle, high = (float(q) for q in np.percentile(present, (25, 50, 75)))
    ranges = values if is_limited else replace(values, least=present, most=present)
    return MeasureSummary(
        int(ended.sum()),
        absent,
        float(values.least[~ended].max()) if is_limited else None,
        float(present.mean()),
        float(present.std(ddof=1)) if present.size > 1 and not is_limited else nan,
        (low, middle, high),
        interval_of_mean(ranges),
        float(present.min()),
        float(present.max()),
    )


def interval_of_mean(
    values: RunRanges, confidence: float = INTERVAL_CONFIDENCE
) -> tuple[float, float]:
    """Confidence interval of the mean, for all who show one; NaN where the runs are equal or one.

    >>> from app.studies.judge.judge import ranges_of
    >>> low, high = interval_of_mean(ranges_of([1.0, 2.0, 3.0]))
    >>> round(low, 3), round(high, 3)
    (-7.901, 11.901)
    """
    low, high = values.interval(confidence)
    return (low, high) if math.isfinite(low) or math.isfinite(high) else (math.nan, math.nan)


def half_width(mean: float, interval: tuple[float, float]) -> float:
    """Half of the interval of a mean where one number has to say it: the wider side; NaN where the
    interval is not finite.

    >>> half_width(2.0, (1.5, 3.0)), half_width(2.0, (1.5, math.inf))
    (1.0, nan)
    """
    low, high = interval
    return max(mean - low, high - mean) if math.isfinite(high - low) else math.nan
