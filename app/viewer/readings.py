"""What the monitors show of a flock, and its course over the run."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field

import numpy as np

from agents.flock import Flock
from agents.observables.groups import group_labels, group_sizes
from agents.observables.layers import layers
from app.viewer.crowd import refuse_too_many_links
from app.viewer.ration import Ration

ORDER = ("polarisation", "consistency")
"""Quick to measure: read many times a second."""
STRUCTURE = ("mean-neighbours", "groups", "largest-group")
"""Needs the flock's graph: read a few times a second, less for a large flock."""
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
    quick: Ration = field(default_factory=lambda: Ration(period=1 / 15, share=0.05))
    slow: Ration = field(default_factory=lambda: Ration(period=1 / 4, share=0.1))

    def read(self, at_once: bool = False) -> None:
        """Read what is due; everything if `at_once`."""
        now = time.perf_counter()
        if at_once or self.quick.due(now):
            with self.quick.measured():
                self.note(self.order, {name: float(self.flock.observe(name)) for name in ORDER})
        if at_once or self.slow.due(now):
            with self.slow.measured():
                self.values = {k: v for k, v in self.values.items() if k in ORDER}
                self.layers, self.unknown = np.zeros(0, int), 0
                refuse_too_many_links(self.flock)
                self.note_structure()

    def note(self, course: Course, seen: dict[str, float]) -> None:
        """Take values and add them to a course."""
        self.values = self.values | seen
        course.add(self.flock.tick, seen)

    def note_structure(self) -> None:
        """Read what follows from the flock's graph, which is found once."""
        n, links = len(self.flock.ids), self.flock.links()
        sizes = group_sizes(group_labels(n, links))
        found = 2.0 * len(links) / max(1, n), float(len(sizes)), float(sizes.max(initial=0))
        self.note(self.structure, dict(zip(STRUCTURE, found, strict=True)))
        if self.flock.informed.any():
            layer = layers(links, self.flock.informed)
            known = layer[layer <= n]
            self.layers = np.bincount(known)[1:]
            self.unknown = n - known.size
