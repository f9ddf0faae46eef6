"""Where moving points have been: their places at some ticks, the knots of the lines they leave."""

from __future__ import annotations

import numpy as np

from app.viewer.scene.draw.identities import rows_of
from app.viewer.scene.shown.frame import Frame

INJECTED = -1
"""Identity of the injected car, which leaves a band too."""


class TrailHistory:
    """The knots of one run; forgotten when the run changes."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget where the points have been."""
        self._run: tuple[int, int] | None = None
        self._ids = np.empty(0, dtype=int)
        self.began = 0
        """Tick of the first knot of the run, which may be forgotten by now."""
        self.ticks: list[int] = []
        self.knots: list[np.ndarray] = []
        """The places (M, 3) at each of these ticks, NaN for points that were not there."""

    def remember(
        self,
        frame: Frame,
        ids: np.ndarray,
        here: np.ndarray,
        length: int,
        knots: int,
        kept: int = 0,
    ) -> bool:
        """Add a knot when the last is old enough for `knots` of them in `length` ticks, and forget
        what is older than that and than `kept` ticks; True if anything changed.

        The points `here` (M, 3) have identities (M,), which may be others than before.
        """
        run = (frame.run, frame.dim)
        if self._run != run or (self.ticks and frame.tick < self.ticks[-1]):
            self.clear()
            self._run, self.began = run, frame.tick
        if not np.array_equal(ids, self._ids):
            self.knots = [carried(knot, self._ids, ids) for knot in self.knots]
            self._ids = ids.copy()
        elif self.ticks and frame.tick - self.ticks[-1] < length / knots:
            return False
        if self.ticks and self.ticks[-1] == frame.tick:
            self.knots[-1] = here
        else:
            self.ticks.append(frame.tick)
            self.knots.append(here)
        while self.ticks[0] < frame.tick - max(length, kept):
            del self.ticks[0], self.knots[0]
        return True


def thinned(ticks: np.ndarray, now: int, length: int, knots: int) -> np.ndarray:
    """Which of the knots at ticks (K,) show `length` ticks up to `now` with `knots` pieces or so.

    A knot stays as long as it is shown: nothing flickers.

    >>> thinned(np.arange(10), 10, 8, 4).tolist()
    [2, 4, 6, 8]
    """
    shown = np.flatnonzero(ticks >= now - length)
    cell = ticks[shown] // max(1, length // knots)
    return shown[np.diff(cell, prepend=-1) > 0]


def carried(knot: np.ndarray, before: np.ndarray, now: np.ndarray) -> np.ndarray:
    """Places (M, 3) of the identities `before` for the identities `now`; NaN for new ones."""
    rows, known = rows_of(before, now)
    made = np.full((len(now), 3), np.nan)
    made[known] = knot[rows]
    return made
