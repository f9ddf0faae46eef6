"""How a run has gone: what was measured of it over its ticks, and which run it is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES
from app.viewer.measuring.curves import Points, steps
from app.viewer.measuring.measured import few
from app.viewer.measuring.readings import Readings
from worlds.world import World

TOLD = 3
"""Differences between two runs that are told; of more, that there are others."""


@dataclass(frozen=True)
class Conditions:
    """What a run is made of: all by which it may differ from another one of its model."""

    model: Model
    seed: int
    agents: int
    world: World
    options: Mapping[str, Any]
    parameters: Mapping[str, Any]
    dt: float
    """Time that a tick stands for."""

    @classmethod
    def of(cls, flock: Flock) -> Conditions:
        """Those of a flock, with its parameters as they are now."""
        return cls(
            flock.model,
            flock.seed,
            len(flock.ids),
            flock.world,
            flock.options.chosen,
            flock.parameters.model_dump(),
            flock.dt,
        )

    @property
    def unit(self) -> str:
        """That of its time: ticks, or s."""
        return self.model.body.unit

    def differences(self, other: Conditions) -> str:
        """What is other here than in another run, in few words; nothing if nothing is."""
        told = [f"seed {self.seed}"] if self.seed != other.seed else []
        if self.world != other.world:
            same = self.world.name == other.world.name
            told.append(f"{self.world.name} as it was" if same else f"world {self.world.name}")
        if self.agents != other.agents:
            told.append(f"{self.agents} agents")
        told += [
            f"{name} {worded(self.options.get(name, 'as usual'))}"
            for name in sorted(self.options.keys() | other.options.keys())
            if self.options.get(name) != other.options.get(name)
        ]
        told += [
            f"{name} {worded(value)}"
            for name, value in self.parameters.items()
            if name not in other.parameters or value != other.parameters[name]
        ]
        return ", ".join(told[:TOLD] + ["…"] * (len(told) > TOLD))


def worded(value: Any) -> str:
    """The value of a parameter or of an option in few letters.

    >>> worded(0.30000000000000004), worded("angular"), worded(True)
    ('0.3', 'angular', 'on')
    """
    if isinstance(value, bool):
        return "on" if value else "off"
    return few(float(value)) if isinstance(value, int | float) else str(value)


@dataclass(frozen=True, eq=False)
class Course:
    """All that is kept of how observables of a run went."""

    conditions: Conditions
    tick: int
    """When it was looked at last."""
    curves: Mapping[str, Points]
    """By observable; without those that have no point."""

    @classmethod
    def of(cls, readings: Readings, names: Iterable[str] | None = None) -> Course:
        """That of a run so far: of some observables, or of all that were measured."""
        wanted = readings.offered if names is None else names
        found = {name: recorded(readings, name) for name in wanted if name in OBSERVABLES}
        known = {name: (at, values) for name, (at, values) in found.items() if len(at)}
        return cls(Conditions.of(readings.flock), readings.tick, known)

    def points(self, name: str) -> Points:
        """How an observable went; no points if it was not measured."""
        return self.curves.get(name, (np.empty(0), np.empty(0)))


def recorded(readings: Readings, name: str) -> Points:
    """Every point that is kept of an observable; what is counted is exact to the tick."""
    if OBSERVABLES[name].events is None:
        return readings.series(name).recorded()
    if name not in readings.events:
        return np.empty(0), np.empty(0)
    return steps(readings.events[name], readings.tick)
