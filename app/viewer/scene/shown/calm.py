"""The states of real cars as they are shown: what is bad at once, what is good a little later."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.viewer.scene.shown.frame import Frame
from app.viewer.scene.shown.live import LATE, LOST, Live

HOLD = 0.4
"""Seconds for which a car is still shown as late or lost when it no longer is."""
AFRESH = 0.25
"""Seconds after which the age of a car is told afresh."""
BADNESS = {LATE: 1, LOST: 2}
"""Of a state; 0 for the others."""


@dataclass(frozen=True)
class _Told:
    state: str
    age: float
    told: float
    """When the age was, s."""
    true: float
    """When the state was so last, s."""


class Calm:
    """Remembers what was shown of each car; forgotten when the run changes."""

    def __init__(self) -> None:
        self._run: int | None = None
        self._told: dict[str, _Told] = {}

    def calmed(self, frame: Frame) -> Frame:
        """The frame with the states and ages that are to be shown; others are as they are."""
        live = frame.live
        if live is None:
            self._told.clear()
            return frame
        if frame.run != self._run:
            self._run = frame.run
            self._told.clear()
        now = frame.tick * frame.dt
        self._told = {
            name: self._next(name, state, float(age), now)
            for name, state, age in zip(live.names, live.states, live.ages, strict=True)
        }
        return replace(frame, live=_as_told(live, [self._told[name] for name in live.names]))

    def _next(self, name: str, state: str, age: float, now: float) -> _Told:
        before = self._told.get(name)
        if before is None or now < before.told:
            return _Told(state, age, now, now)
        if state == before.state:
            fresh = now - before.told >= AFRESH
            return _Told(state, age, now, now) if fresh else replace(before, true=now)
        better = BADNESS.get(state, 0) < BADNESS.get(before.state, 0)
        if better and now - before.true < HOLD:
            return before
        return _Told(state, age, now, now)


def _as_told(live: Live, told: list[_Told]) -> Live:
    return replace(
        live,
        states=tuple(one.state for one in told),
        ages=np.array([one.age for one in told]),
    )
