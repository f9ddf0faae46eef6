"""Tells a port that is busy, and drops a frame, from one that takes nothing any more."""

from __future__ import annotations

from app.live.links.link import LinkLost

MOST_IN_A_ROW = 25
"""Frames: at 100 per second, the time after which the cars' watchdogs have stopped them."""


class StallDetector:
    """Counts the frames in a row for which a port was not free."""

    def __init__(self, name: str):
        self.name = name
        self.in_a_row = 0

    def saw(self, free: bool) -> bool:
        """`free`. Raises LinkLost at the last of MOST_IN_A_ROW frames that were not taken."""
        self.in_a_row = 0 if free else self.in_a_row + 1
        if self.in_a_row >= MOST_IN_A_ROW:
            raise LinkLost(f"the link {self.name!r} has taken none of {self.in_a_row} frames")
        return free
