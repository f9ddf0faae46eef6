"""Where words stand beside agents: on the side where they hide the fewest others; and which of
numbers that would lie upon each other are written."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

AFRESH = 0.5
"""Seconds for which names stay on their sides at least."""
LETTER, LINE, ENDS = 0.0085, 0.022, 0.014
"""Width of a letter, height of a line and width of both ends of a pill as multiples of the longest
side, as a room that fills a window of common size from above shows them."""
LEAVES, COMES = 0.7, 1.0
"""A number leaves when another is within this share of its size, and comes when none is within
that."""


def box(text: str) -> tuple[float, float]:
    """Width and height of words of common size, as multiples of the longest side."""
    return LETTER * len(text) + ENDS, LINE


class Sides:
    """Remembers the sides; forgotten when the run changes."""

    def __init__(self) -> None:
        self._decided: tuple[int, float] | None = None
        self._below: dict[int, bool] = {}

    def below(
        self,
        run: int,
        now: float,
        ids: Sequence[int],
        at: np.ndarray,
        size: np.ndarray,
        away: float,
        room: float,
    ) -> list[bool]:
        """Whether the names of M cars stand below and not above them.

        They are at `at` (M, 2), `away` from their names, which have widths and heights `size`
        (M, 2); each takes up `room` to every side. `now` is in seconds.
        """
        known = self._decided is not None and self._decided[0] == run
        if not known:
            self._below = {}
        due = not known or not 0.0 <= now - (self._decided or (0, 0.0))[1] < AFRESH
        if due or any(one not in self._below for one in ids):
            self._decided = run, now
            before = [self._below.get(one, False) for one in ids]
            sides = chosen_sides(before, at, size, away, room)
            self._below = dict(zip(ids, sides, strict=True))
        return [self._below[one] for one in ids]


def uncrowded(at: np.ndarray, size: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Which of M numbers are written, (M,) bool: no two upon each other, first of all those that
    were, `before` (M,) bool.

    They stand at `at` (M, 2), with widths and heights `size` (M, 2).
    """
    written = np.zeros(len(at), bool)
    for row in np.argsort(~before, kind="stable"):
        share = LEAVES if before[row] else COMES
        near = np.abs(at[written] - at[row]) < share * 0.5 * (size[written] + size[row])
        written[row] = not near.all(axis=1).any()
    return written


def chosen_sides(
    before: Sequence[bool],
    at: np.ndarray,
    size: np.ndarray,
    away: float,
    room: float,
) -> list[bool]:
    """The sides by how much each hides, one car after the other; `before` where it is the same."""
    sides: list[bool] = []
    taken = np.empty((0, 4))
    for row, (was, place, box) in enumerate(zip(before, at, size, strict=True)):
        others = np.delete(at, row, axis=0)
        hidden, boxes = {}, {}
        for below in (was, not was):
            up = -1.0 if below else 1.0
            middle = place + np.array([0.0, up * (away + 0.5 * box[1])])
            boxes[below] = np.array([*middle, *box])
            near = np.abs(others - middle) < 0.5 * box + room
            clash = np.abs(taken[:, :2] - middle) < 0.5 * (taken[:, 2:] + box)
            hidden[below] = 2 * np.count_nonzero(near.all(1)) + np.count_nonzero(clash.all(1))
        side = was if hidden[was] <= hidden[not was] else not was
        sides.append(side)
        taken = np.concatenate([taken, boxes[side][None]])
    return sides
