"""The run of a lesson's step: what is measured of it after each tick that counts, and where it
ends."""

from __future__ import annotations

import math

from agents.flock import Flock

CHANGED = "The flock was changed"
ANOTHER = "Another run was begun"


class StepTrial:
    """One observable of a run, after each tick from `first` to `last`.

    The simulation's thread measures; whoever shows it reads. A tick that is run twice, as after a
    look back, counts once.
    """

    def __init__(self, measure: str, first: int, last: int, kind: str = ""):
        self.measure, self.first, self.last = measure, first, last
        self.kind = kind
        """Of which agents it is measured; empty: of all."""
        self.values: dict[int, float] = {}
        """By tick."""
        self.fault = ""
        """Why it is not the run that was meant, a clause; empty: it is."""
        self.has_paused = False
        """Whether the flock was made to stand at its end, which it is once."""

    @property
    def is_over(self) -> bool:
        """Whether nothing more is measured."""
        return bool(self.fault) or self.last in self.values

    @property
    def mean(self) -> float:
        """The mean over the ticks that count; NaN where the observable has no value at one."""
        return sum(self.values.values()) / len(self.values) if self.values else math.nan

    def cancel(self, why: str) -> None:
        """It is another run from now on, unless it is over."""
        if not self.is_over:
            self.fault = why

    def ticks_together(self, tick: int, most: int) -> int:
        """How many ticks may be run at once from a tick on, at least 1 and at most `most`.

        >>> trial = StepTrial("polarisation", first=6, last=10)
        >>> [trial.ticks_together(tick, 9) for tick in (0, 4, 5, 9, 10)]
        [5, 1, 1, 1, 9]
        """
        if self.fault or tick >= self.last:
            return most
        return max(1, min(most, self.first - 1 - tick))

    def note(self, flock: Flock) -> None:
        """Measure a flock that has just run to a tick, if it counts."""
        if self.fault or not self.first <= flock.tick <= self.last:
            return
        self.values[flock.tick] = float(flock.observe(self.measure, kind=self.kind or None))

    def ticks_left(self, tick: int, wanted: int) -> int:
        """How many of the wanted ticks are run before it ends and the flock stands."""
        if self.has_paused or self.fault:
            return wanted
        return min(wanted, max(0, self.last - tick))
