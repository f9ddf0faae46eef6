"""How many replicates a cell needs: a fixed number, or until the interval of its mean is narrow."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from app.studies.judge import statistics
from app.studies.judge.judge import INTERVAL_CONFIDENCE, ranges_of
from app.studies.judge.statistics import interval_of_mean
from app.studies.sweeps.sweep_file import Precision, Replicates

Values = Callable[[int, int], list[float]]
"""The values of a cell's first replicates, without those that have none."""


FIRST_LOOK = 10
"""Replicates before the interval of a mean is looked at: fewer show too little of their spread."""


def half_width(values: Sequence[float], confidence: float = INTERVAL_CONFIDENCE) -> float:
    """Half of the interval of a mean, the wider side; nan of equal values, which show no spread.

    >>> round(half_width([1.0, 2.0, 3.0]), 3)
    9.901
    """
    interval = interval_of_mean(ranges_of(values), confidence)
    return statistics.half_width(float(np.mean(values)) if len(values) else math.nan, interval)


def is_precise(values: Sequence[float], precision: Precision) -> bool:
    """Whether the interval of the mean is as narrow as is asked for.

    Values that are all equal count as precise from the first look on: a measure without noise would
    otherwise be run for ever.
    """
    if len(values) >= FIRST_LOOK and ranges_of(values).are_equal:
        return True
    width = half_width(values, precision.confidence)
    scale = abs(float(np.mean(values))) if precision.relative and len(values) else 1.0
    return width <= precision.within * scale


class Rounds:
    """Replicates of each cell, round by round; a round follows from the whole round before it.

    So it does not matter in which order runs end, or how often a sweep was stopped.
    """

    def __init__(self, replicates: Replicates, cells: Sequence[int]):
        self.asked = replicates
        self.cells = list(cells)
        self.wanted = dict.fromkeys(self.cells, replicates.count)

    @property
    def total(self) -> int:
        """Runs that are asked for so far."""
        return sum(self.wanted.values())

    def ask_for_more(self, values: Values) -> bool:
        """Ask for the replicates of the next round; False if there is none."""
        precision = self.asked.precision
        if precision is None:
            return False
        added = False
        for cell in self.cells:
            now = self.wanted[cell]
            step = max(precision.step, FIRST_LOOK - now)
            room = min(precision.most - now, step)
            if precision.budget is not None:
                room = min(room, precision.budget - self.total)
            looked = now >= FIRST_LOOK and is_precise(values(cell, now), precision)
            if room > 0 and not looked:
                self.wanted[cell] = now + room
                added = True
        return added
