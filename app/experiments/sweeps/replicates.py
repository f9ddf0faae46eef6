"""How many replicates a cell needs: a fixed number, or until the interval of its mean is narrow."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from app.experiments.sweeps.given.file import Precision, Replicates

Values = Callable[[int, int], list[float]]
"""The values of a cell's first replicates, without those that have none."""


def half_width(values: Sequence[float], confidence: float = 0.95) -> float:
    """Half of the interval of a mean by Student's t; infinite below two values.

    >>> round(half_width([1.0, 2.0, 3.0]), 3)
    2.484
    """
    if len(values) < 2:
        return math.inf
    from scipy.special import stdtrit

    error = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return float(stdtrit(len(values) - 1, 0.5 + 0.5 * confidence)) * error


def is_precise(values: Sequence[float], asked: Precision) -> bool:
    """Whether the interval of the mean is as narrow as is asked for."""
    width = half_width(values, asked.confidence)
    scale = abs(float(np.mean(values))) if asked.relative and len(values) else 1.0
    return width <= asked.within * scale


class Rounds:
    """Replicates of each cell, round by round; a round follows from the whole round before it.

    So it does not matter in which order runs end, or how often a sweep was stopped.
    """

    def __init__(self, asked: Replicates, cells: Sequence[int]):
        self.asked = asked
        self.cells = list(cells)
        self.wanted = dict.fromkeys(self.cells, asked.count)

    @property
    def total(self) -> int:
        """Runs that are asked for so far."""
        return sum(self.wanted.values())

    def more(self, values: Values) -> bool:
        """Ask for the replicates of the next round; False if there is none."""
        precision = self.asked.precision
        if precision is None:
            return False
        added = False
        for cell in self.cells:
            now = self.wanted[cell]
            room = min(precision.most - now, precision.step)
            if precision.budget is not None:
                room = min(room, precision.budget - self.total)
            if room > 0 and not is_precise(values(cell, now), precision):
                self.wanted[cell] = now + room
                added = True
        return added
