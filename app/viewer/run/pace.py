"""How many ticks to run now, so that a run keeps its speed and commands are answered soon."""

from __future__ import annotations

import math
from collections import deque

ANSWER = 0.02
"""Longest time to spend in one call of the flock, s; commands wait for it."""
WINDOW = 1.5
"""Time over which the rate is measured, s."""


class Pace:
    """Shares time out into ticks: `speed` ticks/s, infinity for as fast as it goes."""

    def __init__(self, speed: float, answer: float = ANSWER):
        """`answer` is the longest time to spend in one call of the flock, s."""
        self.speed = speed
        self.answer = answer
        self.timeout = 0.0
        """For how long ticks that are due may wait for others, s: many at once cost less."""
        self.cost = answer
        """Seconds per tick, as measured."""
        self.due = 0.0
        self.done = 0
        self.marks: deque[tuple[float, int]] = deque()

    def restart(self) -> None:
        """Start to count afresh: the next tick is due at once."""
        self.due = 0.0
        self.marks.clear()
        self.doubt()

    def wait(self, now: float) -> float:
        """Time until the next tick is due, s."""
        if math.isinf(self.speed):
            return 0.0
        return max(0.0, self.due + self.timeout - now)

    def ticks_due(self, now: float) -> int:
        """Ticks to run now; a run that cannot keep up does not try to catch up."""
        most = max(1, int(self.answer / self.cost))
        if math.isinf(self.speed):
            return most
        if self.due == 0.0:
            self.due = now
        if now < self.due:
            return 0
        ticks = min(most, 1 + int((now - self.due) * self.speed))
        self.due += ticks / self.speed
        if self.due < now - 0.25 - self.timeout:
            self.due = now
        return ticks

    def doubt(self) -> None:
        """Something has changed: run a single tick next, to see what one costs now."""
        self.cost = self.answer

    def took(self, ticks: int, seconds: float) -> None:
        """Note how long ticks took: a rise is believed at once, a fall by halves."""
        self.cost = max(seconds / ticks, 0.5 * self.cost, 1e-7)
        self.done += ticks

    def rate(self, now: float) -> float:
        """Ticks per second over the last WINDOW, ticks/s."""
        self.marks.append((now, self.done))
        while len(self.marks) > 2 and self.marks[1][0] < now - WINDOW:
            self.marks.popleft()
        (then, before), (last, after) = self.marks[0], self.marks[-1]
        return (after - before) / (last - then) if last > then else 0.0
