"""How a run has gone: what was measured of it over its ticks, and which run it is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from agents.observables.catalogue import OBSERVABLES
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_curves import Points, steps
from app.viewer.measuring.run_conditions import ConditionHistory, RunConditions


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
        wanted = readings.offered if names is None else names
        found = {name: recorded(readings, name) for name in wanted if name in OBSERVABLES}
        known = {name: (at, values) for name, (at, values) in found.items() if len(at)}
        return cls(readings.conditions, readings.tick, known)

    @property
    def conditions(self) -> RunConditions:
        """Those with which it began."""
        return self.history.first

    def ended(self) -> ObservableHistory:
        """The same of a run that does not go on."""
        return replace(self, history=self.history.ended(self.tick))

    def points(self, name: str) -> Points:
        """How an observable went; no points if it was not measured."""
        return self.curves.get(name, (np.empty(0), np.empty(0)))


def recorded(readings: FlockReadings, name: str) -> Points:
    """Every point that is kept of an observable; what is counted is exact to the tick."""
    if OBSERVABLES[name].events is None:
        return readings.series(name).recorded()
    if name not in readings.events:
        return np.empty(0), np.empty(0)
    return steps(readings.events[name], readings.tick)
