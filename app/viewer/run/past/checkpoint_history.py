"""What is kept of a live run, so that one can look back and go on from there."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from agents.snapshot import Snapshot
from agents.spec import Spec
from app.viewer.editing.editor import Editor

MEMORY = 64 * 2**20
"""Bytes that are kept."""
MOST = 2000
"""Moments that are kept."""


@dataclass(frozen=True)
class RunCheckpoint:
    """A run at a tick: all that it takes to go on from there to the bit."""

    snapshots: tuple[Snapshot, ...]
    """Of its flock, and of the one beside it."""
    least: tuple[tuple[float, float], ...]
    """How close agents of each had come to each other and to what is solid."""
    owed: float
    """Part of a tick by which the second flock was behind."""
    spec: Spec
    """What it was set up as, with the world as it was then."""
    editor: Editor | None
    """That world with its history."""

    @property
    def tick(self) -> int:
        """Ticks done by the first flock."""
        return self.snapshots[0].tick

    @property
    def size(self) -> int:
        """Bytes."""
        return sum(array.nbytes for one in self.snapshots for array in one.arrays)


@dataclass
class CheckpointHistory:
    """Moments of one run, ticks rising: the first, and the denser the closer to the last.

    >>> CheckpointHistory().before(5) is None
    True
    """

    memory: int = MEMORY
    moments: list[RunCheckpoint] = field(default_factory=list)
    size: int = 0
    """Bytes of all."""

    def note(self, moment: RunCheckpoint) -> None:
        """Keep a moment, instead of one that is not before it; forget what there is no room for."""
        self.cut(moment.tick - 1)
        self.moments.append(moment)
        self.size += moment.size
        while len(self.moments) > 2 and (self.size > self.memory or len(self.moments) > MOST):
            self.drop(self.least_missed())

    def least_missed(self) -> int:
        """Which moment, not the first and not the last, leaves the smallest gap for its age."""
        ticks = np.array([one.tick for one in self.moments], float)
        gap = ticks[2:] - ticks[:-2]
        return 1 + int(np.argmin(gap / (ticks[-1] - ticks[1:-1])))

    def drop(self, place: int) -> None:
        """Forget a moment."""
        self.size -= self.moments.pop(place).size

    def cut(self, tick: int) -> None:
        """Forget what was after a tick."""
        while self.moments and self.moments[-1].tick > tick:
            self.drop(-1)

    def forget(self) -> None:
        """Forget everything."""
        self.moments, self.size = [], 0

    def before(self, tick: int) -> RunCheckpoint | None:
        """The last moment that is not after a tick, else the first."""
        earlier = [one for one in self.moments if one.tick <= tick]
        return earlier[-1] if earlier else next(iter(self.moments), None)
