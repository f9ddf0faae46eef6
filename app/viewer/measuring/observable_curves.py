"""Which observables are plotted: what may be chosen, what a model brings, and the points."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from agents.observables.catalogue import OBSERVABLES, find_observable, is_observable
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_format import observable_words
from app.viewer.measuring.run_conditions import ConditionHistory, RunConditions

NOTHING = "nothing"
JUST = 1e-3
"""Just before a tick, ticks: where a step begins."""
Points = tuple[np.ndarray, np.ndarray]
"""Ticks and values, (K,) each."""


def chart_title(names: tuple[str, ...]) -> str:
    """What a chart of some observables is called.

    >>> chart_title(("polarisation", "angular-momentum"))
    'polarisation, angular momentum'
    """
    return ", ".join(map(observable_words, names)) or NOTHING


def choices(offered: Collection[str]) -> dict[str, tuple[str, ...]]:
    """What can be plotted of a flock that has these observables: words -> names."""
    pairs = [
        (observable.beside, name) for name, observable in OBSERVABLES.items() if observable.beside
    ]
    both = [names for names in pairs if all(name in offered for name in names)]
    return {chart_title(names): names for names in (*both, *((name,) for name in offered), ())}


def points(readings: FlockReadings, name: str, last: float = math.inf) -> Points:
    """How an observable went over the whole run, or over its `last` ticks."""
    if find_observable(name).events is None:
        return readings.series(name).arrays(last)
    if name not in readings.events:
        return np.empty(0), np.empty(0)
    return steps(readings.events[name], readings.tick, last)


def steps(ticks: np.ndarray, now: int, last: float = math.inf) -> Points:
    """How many of some events, at `ticks` (M,) in order, there had been at each tick up to `now`.

    >>> steps(np.array([0, 4, 4]), 6)
    (array([0.   , 3.999, 4.   , 6.   ]), array([1., 1., 3., 3.]))
    """
    at, count = np.unique(np.asarray(ticks, float), return_counts=True)
    after = np.cumsum(count)
    since = max(0.0, now - last)
    corners = np.unique(np.concatenate([[since], at - JUST, at, [float(now)]]))
    corners = corners[corners >= since]
    return corners, np.append(0, after)[np.searchsorted(at, corners, side="right")].astype(float)


def align_curves(curves: list[Points], each: list[float]) -> tuple[np.ndarray, ...]:
    """Curves at the ticks of all of them, straight in between: the ticks, then the values of each.

    `each` is how many ticks of the first flock last as long as one of a curve's own. A curve
    without points is nan.
    """
    scaled = [(x * ratio, y) for (x, y), ratio in zip(curves, each, strict=True)]
    some = [x for x, _ in scaled if len(x)]
    if not some:
        return (np.zeros(1), *(np.full(1, np.nan) for _ in curves))
    at = np.unique(np.concatenate(some))
    return at, *(np.interp(at, x, y) if len(x) else np.full(len(at), np.nan) for x, y in scaled)


def overlay_curves(
    at: np.ndarray, now: Sequence[np.ndarray], earlier: Sequence[Points], is_whole: bool
) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray]]:
    """Curves of now, at ticks `at` (K,), over earlier ones: the ticks of all, and both.

    If `is_whole`, earlier ones go on to their ends, where those of now are nan; if not, all that is
    earlier ends with them.
    """
    ticks_shown = [x if is_whole else x[x <= at[-1]] for x, _ in earlier]
    ticks = np.unique(np.concatenate([at, *ticks_shown]))

    def on_all(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        if not len(x):
            return np.full(len(ticks), np.nan)
        return np.interp(ticks, x, y, left=np.nan, right=np.nan)

    return ticks, [on_all(at, y) for y in now], [on_all(x, y) for x, y in earlier]


def thin_ticks(at: np.ndarray, most: int) -> np.ndarray:
    """Which of the ticks `at` (K,) are drawn if there may be so many, about: their places.

    They are the first in intervals that stay where they are while the curves grow or move on, so
    that nothing trembles; and the last, which is now.

    >>> thin_ticks(np.arange(10.0), 5)
    array([0, 2, 4, 6, 8, 9])
    """
    if len(at) <= most:
        return np.arange(len(at))
    span = (at[-1] - at[0]) / most
    width = 2.0 ** math.ceil(math.log2(span)) if span > 0 else 1.0
    first = np.unique(np.floor(at / width), return_index=True)[1]
    return np.union1d(first, [len(at) - 1])


# How a run has gone: what was measured of it over its ticks, and which run it is.


@dataclass(frozen=True, eq=False)
class ObservableHistory:
    """All that is kept of how observables of a run went."""

    history: ConditionHistory
    tick: int
    """When it was looked at last."""
    curves: Mapping[str, Points]
    """By observable; without those that have no point."""

    @classmethod
    def of(cls, readings: FlockReadings, names: Iterable[str] | None = None) -> ObservableHistory:
        """That of a run so far: of some observables, or of all that were measured."""
        wanted_names = readings.offered if names is None else names
        series = {
            name: recorded_points(readings, name) for name in wanted_names if is_observable(name)
        }
        finite = {name: (at, values) for name, (at, values) in series.items() if len(at)}
        return cls(readings.conditions, readings.tick, finite)

    @property
    def conditions(self) -> RunConditions:
        """Those with which it began."""
        return self.history.first

    def at_end(self) -> ObservableHistory:
        """The same of a run that does not go on."""
        return replace(self, history=self.history.at_end(self.tick))

    def points(self, name: str) -> Points:
        """How an observable went; no points if it was not measured."""
        return self.curves.get(name, (np.empty(0), np.empty(0)))


def recorded_points(readings: FlockReadings, name: str) -> Points:
    """Every point that is kept of an observable; what is counted is exact to the tick."""
    if find_observable(name).events is None:
        return readings.series(name).recorded()
    if name not in readings.events:
        return np.empty(0), np.empty(0)
    return steps(readings.events[name], readings.tick)
