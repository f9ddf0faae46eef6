"""What is shown between two ticks of a run that is slow: every agent on its way from one place to
the next, so that one sees where it goes."""

from __future__ import annotations

import math
import threading
from dataclasses import replace

import numpy as np

from app.viewer.scene.shown.drawing_style import shows_density
from app.viewer.scene.shown.frame import Frame

SLOW = 8.0
"""Ticks per second at most at which agents are shown on their way."""
PICTURES = 20.0
"""Pictures per second then."""
STEP = 0.25
"""Time that the way of a single tick takes while the run is paused, s."""


class FrameInterpolator:
    """Holds the last two frames; the older one until the newer is reached. Any thread may ask."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.before: Frame | None = None
        self.after: Frame | None = None
        self.since = 0.0
        self.step = -1
        self.shown: Frame | None = None
        self.moves = math.inf
        """When there will be another picture though there is no other frame, s."""

    def frame(self, newest: Frame | None, running: bool, speed: float, now: float) -> Frame | None:
        """The frame to draw `now` (s), of a run that goes at `speed`, ticks/s.

        One object as long as it is to be the same picture; the newest frame itself once all have
        arrived, and where the run is not slow.
        """
        with self.lock:
            return self.frame_of(newest, running, speed, now)

    def frame_of(
        self, newest: Frame | None, running: bool, speed: float, now: float
    ) -> Frame | None:
        """The same; for one thread at a time."""
        if newest is not self.after:
            follows = (
                self.after is not None and newest is not None and is_next_tick(self.after, newest)
            )
            goes_on = follows and speed <= SLOW and newest is not None and not shows_density(newest)
            self.before = self.after if goes_on else None
            self.after, self.since, self.step = newest, now, -1
        self.moves = math.inf
        if self.before is None or newest is None:
            return newest
        lasts = 1.0 / speed if running else STEP
        steps = max(1, round(PICTURES * lasts))
        step = int((now - self.since) / lasts * steps) + 1
        if step >= steps:
            self.before = None
            return newest
        self.moves = self.since + step * lasts / steps
        if step != self.step:
            self.step, self.shown = step, interpolate(self.before, newest, step / steps)
        return self.shown


def is_next_tick(before: Frame, after: Frame) -> bool:
    """Whether a frame is one tick after another, of the same agents."""
    return (
        (before.run, before.tick + 1) == (after.run, after.tick)
        and np.array_equal(before.ids, after.ids)
        and (before.beside is None) == (after.beside is None)
        and (before.beside is None or is_next_tick(before.beside, after.beside))  # type: ignore[arg-type]
    )


def interpolate(before: Frame, after: Frame, share: float) -> Frame:
    """The newer frame, with every agent at a `share`, in [0, 1], of its way from the older one.

    Across edges that wrap the way is the shortest. A heading that turns back turns at once.
    """
    way = after.position - before.position
    way -= np.where(after.wraps, after.size * np.round(way / after.size), 0.0)
    position = after.position - (1.0 - share) * way
    inside = after.low + np.mod(position - after.low, after.size)
    heading = (1.0 - share) * before.heading + share * after.heading
    length = np.linalg.norm(heading, axis=1, keepdims=True)
    return replace(
        after,
        position=np.where(after.wraps, inside, position),
        heading=np.where(length > 1e-6, heading / np.maximum(length, 1e-6), after.heading),
        beside=None
        if after.beside is None or before.beside is None
        else interpolate(before.beside, after.beside, share),
    )
