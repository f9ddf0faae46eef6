"""How long the control loop takes: its periods, and how old its commands' poses are when sent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

KEPT = 1000
"""Values that a summary is of: 10 s at 100 Hz."""


@dataclass(frozen=True)
class DurationSummary:
    """Median, 99th percentile and maximum of the last durations, s; NaN where there are none."""

    median: float
    late: float
    """Exceeded by one in a hundred."""
    worst: float

    @staticmethod
    def of(durations: np.ndarray) -> DurationSummary:
        """The summary of durations (N,), s; those that are NaN are left out."""
        kept = durations[np.isfinite(durations)]
        if not len(kept):
            return DurationSummary(np.nan, np.nan, np.nan)
        return DurationSummary(
            float(np.median(kept)),
            float(np.quantile(kept, 0.99, method="higher")),
            float(kept.max()),
        )


class Durations:
    """The last durations of something that recurs."""

    def __init__(self) -> None:
        self.values = np.empty(KEPT)
        self.count = 0

    def add(self, seconds: float) -> None:
        """Add a duration, s."""
        self.values[self.count % KEPT] = seconds
        self.count += 1

    def summary(self) -> DurationSummary:
        """Their summary.

        >>> durations = Durations()
        >>> for seconds in (0.01, 0.01, 0.04):
        ...     durations.add(seconds)
        >>> durations.summary().median, durations.summary().worst
        (0.01, 0.04)
        """
        return DurationSummary.of(self.values[: min(self.count, KEPT)])
