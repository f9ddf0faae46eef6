"""How far a sweep is: runs, their rate, and the time left from what each cell's runs have cost."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Sequence
from typing import Any

LATELY = 0.2
"""How much the last second weighs in the rate."""


class SweepProgress:
    """What is done and what is left of the runs that are expected."""

    def __init__(self) -> None:
        self.ahead: Counter[int] = Counter()
        self.done: Counter[int] = Counter()
        self.spent: dict[int, float] = {}
        self.count = 0
        self.all = 0
        self.rate = 0.0
        self.began = self.looked = time.monotonic()
        self.seen = 0

    def expect(self, cells: Sequence[int]) -> None:
        """Expect these runs, each given by its cell."""
        self.ahead = Counter(cells)
        self.all = self.count + len(cells)

    def add(self, cell: int, seconds: float) -> None:
        """Count a run that is over."""
        self.ahead[cell] -= 1
        self.done[cell] += 1
        self.spent[cell] = self.spent.get(cell, 0.0) + seconds
        self.count += 1

    @property
    def seconds(self) -> float:
        """Seconds of one core for what is left; cells of which no run is done cost the mean."""
        total = sum(self.spent.values())
        mean = total / self.count if self.count else 0.0
        return sum(
            left * (self.spent[cell] / self.done[cell] if self.done[cell] else mean)
            for cell, left in self.ahead.items()
        )

    @property
    def share(self) -> float:
        """Share of the work that is done, in [0, 1]."""
        spent, ahead = sum(self.spent.values()), self.seconds
        return spent / (spent + ahead) if spent + ahead else 0.0

    def pace(self) -> float:
        """Runs a second, lately."""
        now = time.monotonic()
        if now - self.looked >= 1.0:
            latest = (self.count - self.seen) / (now - self.looked)
            first = self.rate == 0.0
            self.rate = latest if first else self.rate + LATELY * (latest - self.rate)
            self.looked, self.seen = now, self.count
        return self.rate or self.count / max(now - self.began, 1e-9)

    def words(self, broken: int, gave_up: int) -> str:
        """How far it is, for people."""
        said = f"{self.count} of {self.all} runs, {self.pace():.3g} a second"
        said += f", {gave_up} gave up" if gave_up else ""
        return said + (f", {broken} failed" if broken else "")

    def value(self, workers: int) -> dict[str, Any]:
        """How far it is, for who reads the store."""
        return {
            "pid": os.getpid(),
            "workers": workers,
            "made": self.count,
            "of": self.all,
            "rate": round(self.pace(), 3),
            "seconds_left": round(self.seconds / workers, 3),
            "updated": round(time.time(), 3),
        }
