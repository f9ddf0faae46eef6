"""What the monitors show of a flock, and its course over the run."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from agents.flock import Flock
from agents.observables.following import spread_bound
from agents.observables.groups import group_labels, group_sizes
from agents.observables.layers import layers
from agents.observables.neighbours import links
from app.viewer.aside import Aside
from app.viewer.crowd import refuse_too_many_links
from app.viewer.extremes import Extremes
from app.viewer.ration import Ration
from worlds.world import World

ORDER = ("polarisation", "consistency")
"""Quick to measure: read many times a second."""
STRUCTURE = ("mean-neighbours", "groups", "largest-group")
"""Needs the flock's graph: read a few times a second, less for a large flock."""
GOAL_DISTANCE = "goal-distance"
"""Of a mission: read as often as the order."""
POINTS = 600
"""Points in a plot at most."""


class Course:
    """How readings went over the run: at most POINTS points, thinned as the run grows."""

    def __init__(self, *names: str):
        self.names = names
        self.columns: list[list[float]] = [[] for _ in range(1 + len(names))]
        self.lock = threading.Lock()
        self.apart = 1
        """Ticks that must lie between two points."""

    def add(self, tick: int, values: dict[str, float]) -> None:
        """Note values at a tick; a second note at one tick replaces the first."""
        with self.lock:
            ticks = self.columns[0]
            if ticks and tick - ticks[-1] < self.apart:
                if tick != ticks[-1]:
                    return
                for column in self.columns:
                    column.pop()
            ticks.append(float(tick))
            for column, name in zip(self.columns[1:], self.names, strict=True):
                column.append(values[name])
            if len(ticks) > POINTS:
                self.columns = [column[::2] for column in self.columns]
                self.apart = max(2 * self.apart, int(self.columns[0][-1]) // POINTS)

    def arrays(self) -> tuple[np.ndarray, ...]:
        """Ticks, then one array for each name."""
        with self.lock:
            return tuple(np.array(column, float) for column in self.columns)


@dataclass(frozen=True)
class Still:
    """A flock held still: copies of what its graph follows from."""

    tick: int
    position: np.ndarray
    informed: np.ndarray
    ids: np.ndarray
    reach: float
    world: World


@dataclass(frozen=True)
class Structure:
    """What follows from the graph of a flock."""

    tick: int
    values: dict[str, float]
    layers: np.ndarray
    """Number of agents in layers 1, 2, ..."""
    unknown: int
    """Agents that no information reaches."""


def still(flock: Flock) -> Still:
    """Hold a flock still."""
    position, informed, ids = flock.position.copy(), flock.informed.copy(), flock.ids.copy()
    return Still(flock.tick, position, informed, ids, flock.reach, flock.world)


def structure(flock: Still) -> Structure:
    """Find the graph of a flock, once, and what follows from it. Raises Refusal if it is huge."""
    refuse_too_many_links(flock)
    n = len(flock.ids)
    pairs = links(flock.position, flock.reach, flock.world.size, flock.world.images)
    sizes = group_sizes(group_labels(n, pairs))
    found = 2.0 * len(pairs) / max(1, n), float(len(sizes)), float(sizes.max(initial=0))
    values = dict(zip(STRUCTURE, found, strict=True))
    if not flock.informed.any():
        return Structure(flock.tick, values, np.zeros(0, int), 0)
    layer = layers(pairs, flock.informed)
    known = layer[layer <= n]
    return Structure(flock.tick, values, np.bincount(known)[1:], n - known.size)


@dataclass
class Readings:
    """Reads one flock's observables, no more often than is fair to the flock."""

    flock: Flock
    values: dict[str, float] = field(default_factory=dict)
    layers: np.ndarray = field(default_factory=lambda: np.zeros(0, int))
    """Number of agents in layers 1, 2, ...; agents of unknown layer left out."""
    unknown: int = 0
    """Agents that no information reaches."""
    order: Course = field(default_factory=lambda: Course(*ORDER))
    structure: Course = field(default_factory=lambda: Course(*STRUCTURE))
    errand: Course = field(default_factory=lambda: Course(GOAL_DISTANCE))
    extremes: Extremes = field(init=False)
    quick: Ration = field(default_factory=lambda: Ration(period=1 / 15, share=0.05))
    slow: Ration = field(default_factory=lambda: Ration(period=1 / 4, share=0.1))
    aside: Aside = field(default_factory=Aside)

    def __post_init__(self) -> None:
        self.extremes = Extremes(self.flock)

    def read(self, at_once: bool = False) -> None:
        """Read what is due; everything, and now, if `at_once`.

        Raises Refusal if the flock has too many neighbours to find its graph.
        """
        now = time.perf_counter()
        if at_once or self.quick.due(now):
            with self.quick.measured():
                seen = {name: float(self.flock.observe(name)) for name in ORDER}
                self.order.add(self.flock.tick, seen)
                self.values = self.values | seen | self.mission()
        if at_once:
            self.aside.forget()
            self.take(self.study(still(self.flock)))
        elif done := self.aside.finished():
            self.take(done.result)
        elif self.aside.idle and self.slow.due(now):
            self.aside.begin(self.study(still(self.flock)))

    def mission(self) -> dict[str, float]:
        """How the mission stands; nothing in a world without one and without anything solid."""
        found = self.extremes.values()
        mission = self.flock.world.mission
        if mission is not None and (mission.goal is not None or mission.path is not None):
            found[GOAL_DISTANCE] = float(self.flock.observe(GOAL_DISTANCE))
            self.errand.add(self.flock.tick, found)
        if mission is not None and mission.goal is not None:
            found["through"] = arrived(self.flock)
        return found

    def study(self, flock: Still) -> Callable[[], Structure]:
        """The work of finding the graph, which counts against its ration."""

        def work() -> Structure:
            with self.slow.measured():
                return structure(flock)

        return work

    def take(self, found: Callable[[], Structure]) -> None:
        """Take what was found; without it nothing old is shown."""
        self.values = {k: v for k, v in self.values.items() if k not in (*STRUCTURE, "following")}
        self.layers, self.unknown = np.zeros(0, int), 0
        seen = found()
        self.values = self.values | seen.values
        if len(seen.layers):
            self.values["following"] = 1.0 - seen.unknown / (seen.unknown + seen.layers.sum())
        self.layers, self.unknown = seen.layers, seen.unknown
        self.structure.add(seen.tick, seen.values)


def arrived(flock: Flock) -> float:
    """Share of the agents that are no further from the goal than a flock around it needs."""
    goal = flock.goal_at([flock.tick])[0]
    spacing = float(getattr(flock.parameters, "d", flock.reach))
    away = np.linalg.norm(flock.position - goal, axis=1)
    return float((away <= spread_bound(len(away), spacing)).mean())
