"""What a set of runs says: mean, spread, quartiles, and how far it is from a published mean."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

PUBLISHED_RUNS = 100
"""Runs behind each published mean (Liu et al. 2021, section 3.1)."""
NOTE = (
    "z = (measured mean - published mean) / sqrt(s^2/n + s^2/100): the paper gives no spread, "
    "so s is the measured standard deviation for both samples"
)


@dataclass(frozen=True)
class Summary:
    """k_con over the runs of a cell."""

    runs: int
    """Runs that have converged."""
    given_up: int
    """Runs that have not converged within the limit; they count in no number here."""
    mean: float
    sd: float
    """Standard deviation, n - 1; NaN below two runs."""
    quartiles: tuple[float, float, float]

    @property
    def median(self) -> float:
        """The second quartile."""
        return self.quartiles[1]

    @property
    def standard_error(self) -> float:
        """Of the mean."""
        return self.sd / math.sqrt(self.runs) if self.runs else math.nan


def summary(times: Sequence[int | None]) -> Summary:
    """Summary of convergence times; None stands for a run that was given up.

    >>> summary([1, 2, 3, 4, None]).quartiles
    (1.75, 2.5, 3.25)
    """
    came = np.array([k for k in times if k is not None], float)
    if came.size == 0:
        return Summary(0, len(times), math.nan, math.nan, (math.nan,) * 3)
    low, middle, high = (float(q) for q in np.percentile(came, (25, 50, 75)))
    sd = float(came.std(ddof=1)) if came.size > 1 else math.nan
    return Summary(came.size, len(times) - came.size, float(came.mean()), sd, (low, middle, high))


def z_score(measured: Summary, published_mean: float) -> float:
    """Distance from a published mean in standard errors of the difference; NaN without spread."""
    error = math.hypot(measured.standard_error, measured.sd / math.sqrt(PUBLISHED_RUNS))
    return (measured.mean - published_mean) / error if error > 0.0 else math.nan


def difference(a: Summary, b: Summary) -> tuple[float, float]:
    """Mean of b minus mean of a, with its standard error, taken as independent samples."""
    return b.mean - a.mean, math.hypot(a.standard_error, b.standard_error)
