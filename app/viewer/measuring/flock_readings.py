"""What the monitors show of a flock, and how that goes over the run."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.observables.catalogue import OBSERVABLES, find_observable
from agents.observables.following import (
    fill_clearances,
    fill_nearest_pairs,
    least_clearances,
    nearest_pairs,
    spread_bound,
)
from agents.observables.groups import group_sizes
from agents.observables.observable import SERIES
from agents.snapshot import Snapshot
from agents.state.agent_rows import Crashes
from app.viewer.measuring.background_worker import BackgroundWorker, WorkThrottle
from app.viewer.measuring.observable_format import COUNTED, QUICK, STEADY, offered_observables
from app.viewer.measuring.run_conditions import ConditionHistory, RunConditions
from app.viewer.measuring.time_series import TimeSeries, refuse_too_many_links
from worlds.input_error import InputError

# How close the agents of a run have come to each other and to what is solid.

MOST_AGENTS = 256
"""Of a larger flock the distances between agents are not kept: there are too many pairs."""


@dataclass
class MinimumDistances:
    """Least distances over the run, every tick of it."""

    flock: Flock
    pairs: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    """Least squared distance of each two rows so far, (N, N) above the diagonal, length^2."""
    keeps: bool = True
    """Whether anything is kept; not of a flock that is put here and there."""
    clearance: np.ndarray = field(default_factory=lambda: np.empty(0))
    """Least signed distance of each row to a surface so far, (N,), length; inf far from all."""

    @property
    def is_wanted(self) -> bool:
        """Whether the flock is watched: few agents, on a mission or among what is solid.

        Where agents crash there is no need: the crashes tell how close they came. Where they come
        and go, or are caught, there are no rows that stay.
        """
        world = self.flock.world
        if world.has_gates or self.flock.kinds.catchers:
            return False
        few = len(self.flock.ids) <= MOST_AGENTS and not self.flock.can_crash
        return self.keeps and few and (world.mission is not None or world.is_solid)

    @property
    def kernels(self) -> tuple[Any, ...]:
        """What is compiled to watch it."""
        return (fill_nearest_pairs, fill_clearances) if self.is_wanted else ()

    def run(self, ticks: int) -> None:
        """Run the flock, and watch it if it is to be watched."""
        if not self.is_wanted:
            self.flock.advance(ticks)
            return
        self.watch(self.flock.position[None])
        self.watch(self.flock.trace(ticks))

    def watch(self, trace: np.ndarray) -> None:
        """Take in the positions (T, N, dim) of some ticks."""
        n = trace.shape[1]
        if len(self.clearance) != n:
            self.pairs, self.clearance = np.full((n, n), np.inf), np.full(n, np.inf)
        by_axis = np.ascontiguousarray(trace.transpose(0, 2, 1))
        if not self.flock.world.images.any():
            nearest_pairs(by_axis, self.pairs)
        least_clearances(by_axis, self.flock.engine.surroundings, self.clearance)

    @property
    def least(self) -> tuple[float, float]:
        """The least squared distance of two agents so far, and the least one to a surface."""
        return float(self.pairs.min(initial=np.inf)), float(self.clearance.min(initial=np.inf))

    def resume(self, least: tuple[float, float]) -> None:
        """Go on from what was the `least` at an earlier tick, whichever agents it was."""
        self.pairs[:], self.clearance[:] = np.inf, np.inf
        self.pairs[:1, 1:2], self.clearance[:1] = least

    def values(self) -> dict[str, float]:
        """What has been seen: least distances over the run, and who is inside something now."""
        if not self.is_wanted:
            return {}
        position = self.flock.position[None]
        self.watch(position)
        distances = {}
        if not self.flock.world.images.any():
            distances["least-gap"] = float(np.sqrt(self.pairs.min(initial=np.inf)))
        if self.flock.world.is_solid:
            now = np.full(position.shape[1], np.inf)
            by_axis = np.ascontiguousarray(position.transpose(0, 2, 1))
            least_clearances(by_axis, self.flock.engine.surroundings, now)
            distances["least-clearance"] = float(self.clearance.min(initial=np.inf))
            distances["inside"] = float(np.count_nonzero(now < 0.0))
        return distances


NOBODY = np.zeros(0, int)
MEASURED_ASIDE = 100_000
"""Of more agents everything is measured aside: what is quick for few would hold up the picture."""


@dataclass(frozen=True)
class BackgroundReading:
    """What has been measured aside."""

    tick: int
    values: dict[str, float]
    sizes: np.ndarray = field(default_factory=lambda: NOBODY)
    """Agents of each group, largest first."""
    layers: np.ndarray = field(default_factory=lambda: NOBODY)
    """Number of agents in layers 1, 2, ..."""
    unknown: int = 0
    """Agents that no information reaches."""
    refusal: InputError | None = None
    """Why something could not be measured."""


def measure(flock: Snapshot, names: Iterable[str]) -> BackgroundReading:
    """Measure observables, and what else follows from the graph of a flock."""
    values, refusal = {}, None
    for name in names:
        observable = find_observable(name)
        try:
            if observable.needs_links:
                refuse_too_many_links(flock)
            values[name] = float(observable.measure(flock))
        except InputError as error:
            refusal = error
    try:
        sizes, known = group_sizes(flock.group_labels()), NOBODY
        if flock.informed.any():
            refuse_too_many_links(flock)
            layer = flock.layers()
            known = layer[layer <= len(layer)]
    except InputError as error:
        return BackgroundReading(flock.tick, values, refusal=refusal or error)
    unknown = len(flock.ids) - len(known) if len(known) else 0
    return BackgroundReading(flock.tick, values, sizes, np.bincount(known)[1:], unknown, refusal)


@dataclass
class FlockReadings:
    """Reads one flock's observables, no more often than is fair to the flock."""

    flock: Flock
    watched: frozenset[str] = frozenset()
    """Observables to measure beside those that always are."""
    values: dict[str, float] = field(default_factory=dict)
    sizes: np.ndarray = field(default_factory=lambda: NOBODY)
    """Agents of each group, largest first."""
    layers: np.ndarray = field(default_factory=lambda: NOBODY)
    """Number of agents in layers 1, 2, ...; agents of unknown layer left out."""
    unknown: int = 0
    """Agents that no information reaches."""
    crashes: Crashes | None = None
    """Who has crashed so far; None where nobody can."""
    events: dict[str, np.ndarray] = field(default_factory=dict)
    """The ticks of what is counted, by its observable."""
    tick: int = 0
    """When that was."""
    notes: bool = True
    """Whether it goes into the curves; not what is only looked back at."""
    all_series: dict[str, TimeSeries] = field(default_factory=dict)
    extremes: MinimumDistances = field(init=False)
    offered: tuple[str, ...] = field(init=False)
    """What can be measured of this flock."""
    conditions: ConditionHistory = field(init=False)
    """Under what the run was made so far; a value that any thread may read."""
    quick: WorkThrottle = field(default_factory=lambda: WorkThrottle(period=1 / 15, share=0.05))
    slow: WorkThrottle = field(default_factory=lambda: WorkThrottle(period=1 / 4, share=0.1))
    aside: BackgroundWorker = field(default_factory=BackgroundWorker)
    measured_at: int = -1
    """At which tick a large flock was measured aside last."""

    def __post_init__(self) -> None:
        self.extremes = MinimumDistances(self.flock)
        self.offered = offered_observables(self.flock)
        self.conditions = ConditionHistory.begin(self.flock)

    def note_conditions(self, by_hand: bool = False) -> None:
        """Note the conditions of the flock as they are from its tick on.

        `by_hand`: somebody has put agents elsewhere, which holds for the rest of the run.
        """
        by_hand = by_hand or self.conditions.last.by_hand
        now = RunConditions.of(self.flock, by_hand)
        self.conditions = self.conditions.with_change(self.flock.tick, now)

    def watch(self, names: frozenset[str]) -> None:
        """Change what is measured beside what always is."""
        self.watched = names
        self.measured_at = -1
        self.slow.renew()

    def read(self, at_once: bool = False) -> None:
        """Read what is due; everything, and now, if `at_once`.

        Raises InputError if the flock has too many neighbours to find its graph.
        """
        now = time.perf_counter()
        if at_once or self.quick.is_due(now):
            with self.quick.measure_duration():
                self.read_cheap()
        if self.is_large:
            self.read_aside(at_once)
        elif at_once:
            self.aside.forget()
            self.take_reading(self.costly_measurement())
        elif done := self.aside.finished():
            self.take_reading(done.result)
        elif self.aside.idle and self.slow.is_due(now):
            self.aside.begin(self.costly_measurement())

    @property
    def is_large(self) -> bool:
        """Whether everything is measured aside."""
        return len(self.flock.ids) > MEASURED_ASIDE

    @property
    def is_found(self) -> bool:
        """Whether something that was measured aside waits to be read."""
        return self.aside.work is not None and self.aside.work.done()

    def read_aside(self, at_once: bool) -> None:
        """Take what was found, and begin to measure if it is due, or `at_once`; what was measured
        at this tick stays."""
        if done := self.aside.finished():
            self.take_reading(done.result)
        due = at_once or self.slow.is_due(time.perf_counter())
        if self.aside.idle and due and self.measured_at != self.flock.tick:
            self.measured_at = self.flock.tick
            self.aside.begin(self.costly_measurement())

    def read_cheap(self) -> None:
        """Read what is cheap."""
        flock = self.flock
        self.offered = offered_observables(flock)
        quick = () if self.is_large else QUICK
        values = {name: float(flock.observe(name)) for name in quick if name in self.offered}
        self.add_values(flock.tick, values)
        mission = flock.world.mission
        if mission is not None and mission.goal is not None:
            values["through"] = arrived_share(flock)
        if flock.can_crash:
            self.crashes = flock.crashes
        for name in COUNTED:
            count = OBSERVABLES[name].events
            if count is not None and name in self.offered:
                self.events[name] = count(flock)
                values[name] = float(len(self.events[name]))
        self.values = self.values | values | self.extremes.values()
        self.tick = flock.tick

    def series(self, name: str) -> TimeSeries:
        """How an observable went; without points if it has not been measured."""
        return self.all_series.setdefault(name, TimeSeries())

    def add_values(self, tick: int, values: dict[str, float]) -> None:
        """Take values into their time series."""
        if not self.notes:
            return
        for name, value in values.items():
            self.series(name).add(tick, value)

    def cut(self, tick: int) -> None:
        """The flock is back at a tick: forget what was measured after it."""
        self.aside.forget()
        self.measured_at = -1
        self.quick.renew()
        self.slow.renew()
        for series in self.all_series.values():
            series.cut(tick)
        self.conditions = self.conditions.cut(tick)
        self.note_conditions()

    def costly_measurement(self) -> Callable[[], BackgroundReading]:
        """A function that makes the costly measurements of the flock now, within a rate limit.

        It is done on a snapshot, so that the flock can go on meanwhile.
        """
        now = self.flock.snapshot().measurable()
        quick = QUICK if self.is_large else ()
        wanted_names = (*quick, *STEADY, *sorted(self.watched.difference(STEADY, QUICK, COUNTED)))
        names = [name for name in wanted_names if name in self.offered]

        def work() -> BackgroundReading:
            with self.slow.measure_duration():
                return measure(now, names)

        return work

    def take_reading(self, get_reading: Callable[[], BackgroundReading]) -> None:
        """Take what was found; without it nothing old is shown."""
        lasting = (*QUICK, *COUNTED)
        self.values = {
            name: value
            for name, value in self.values.items()
            if name in lasting or name not in self.offered
        }
        self.sizes, self.layers, self.unknown = NOBODY, NOBODY, 0
        reading = get_reading()
        self.values = self.values | reading.values
        self.sizes, self.layers, self.unknown = reading.sizes, reading.layers, reading.unknown
        self.add_values(reading.tick, reading.values)
        if reading.refusal is not None:
            raise reading.refusal

    def over(self, name: str, last: float = math.inf) -> float:
        """An observable that is measured over a run, over its `last` ticks or all of it."""
        series = self.series(SERIES).arrays(last)[1]
        take = OBSERVABLES[name].over
        if take is None:
            raise InputError(f"{name} is not measured over a run")
        series = series[np.isfinite(series)]  # those of tracks have gaps
        crashed = 0 if self.crashes is None else len(self.crashes)
        return take(series, float(len(self.flock.ids) - crashed)) if len(series) > 1 else math.nan


def arrived_share(flock: Flock) -> float:
    """Share of the agents that are no further from the goal than a flock around it needs."""
    goal = flock.goal_at([flock.tick])[0]
    spacing = float(getattr(flock.parameters, "d", flock.reach))
    away = np.linalg.norm(flock.position - goal, axis=1)
    return float((away <= spread_bound(len(away), spacing)).mean())
