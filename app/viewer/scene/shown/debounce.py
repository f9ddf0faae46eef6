"""The states of real cars as they are shown: what is bad at once, what is good a little later."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.viewer.scene.shown.frame import LATE, LOST, Frame, Live

HOLD = 0.4
"""Seconds for which a car is still shown as late or lost when it no longer is."""
REFRESH = 0.25
"""Seconds after which the age of a car is brought up to date."""
BADNESS = {LATE: 1, LOST: 2}
"""Of a state; 0 for the others."""


@dataclass(frozen=True)
class _Shown:
    state: str
    age: float
    """Of what was seen last of the car, s."""
    shown_at: float
    """When the age was brought up to date, s."""
    true: float
    """When the state was so last, s."""


class Debounce:
    """Remembers what was shown of each car; forgotten when the run changes."""

    def __init__(self) -> None:
        self._run: int | None = None
        self._shown: dict[str, _Shown] = {}

    def debounced(self, frame: Frame) -> Frame:
        """The frame with the states and ages that are to be shown; a flock's frame as it is."""
        live = frame.live
        if live is None:
            self._shown.clear()
            return frame
        if frame.run != self._run:
            self._run = frame.run
            self._shown.clear()
        now = frame.tick * frame.dt
        self._shown = {
            name: self._next(name, state, float(age), now)
            for name, state, age in zip(live.names, live.states, live.ages, strict=True)
        }
        return replace(
            frame, live=_debounced_live(live, [self._shown[name] for name in live.names])
        )

    def _next(self, name: str, state: str, age: float, now: float) -> _Shown:
        before = self._shown.get(name)
        if before is None or now < before.shown_at:
            return _Shown(state, age, now, now)
        if state == before.state:
            fresh = now - before.shown_at >= REFRESH
            return _Shown(state, age, now, now) if fresh else replace(before, true=now)
        better = BADNESS.get(state, 0) < BADNESS.get(before.state, 0)
        if better and now - before.true < HOLD:
            return before
        return _Shown(state, age, now, now)


def _debounced_live(live: Live, frames: list[_Shown]) -> Live:
    return replace(
        live,
        states=tuple(frame.state for frame in frames),
        ages=np.array([frame.age for frame in frames]),
    )
