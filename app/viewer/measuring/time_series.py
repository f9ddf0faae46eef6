"""How one quantity goes over time: thinned over the whole of it, in full over its end."""

from __future__ import annotations

import math
import threading
from collections import deque
from typing import Protocol

import numpy as np

from agents.flock import Flock
from worlds.input_error import InputError
from worlds.world import World

POINTS = 600
"""Points in a plot at most."""
EVER = 1e300
"""Longer than any run, and yet not the whole of one, which is thinned."""


class TimeSeries:
    """Values at times (ticks or s): at most POINTS over the whole run, and the POINTS latest.

    What is no finite number is left out, or with `gaps` NaN. Threads may add and look at once.

    >>> series = TimeSeries()
    >>> for tick in range(3):
    ...     series.add(tick, tick / 10)
    >>> series.arrays(last=1)
    (array([1., 2.]), array([0.1, 0.2]))
    """

    def __init__(self, gaps: bool = False) -> None:
        self.gaps = gaps
        self.whole: list[tuple[float, float]] = []
        self.latest: deque[tuple[float, float]] = deque(maxlen=POINTS)
        self.lock = threading.Lock()
        self.apart = 1
        """Time that must lie between two points of the whole run."""

    def add(self, time: float, value: float) -> None:
        """Note a value at a time; a second note at one time replaces the first."""
        if not math.isfinite(value):
            if not self.gaps:
                return
            value = math.nan
        with self.lock:
            again = bool(self.latest) and time == self.latest[-1][0]
            if again:
                self.latest.pop()
            self.latest.append((float(time), float(value)))
            self.add_if_due(self.latest[-1])

    def add_if_due(self, point: tuple[float, float]) -> None:
        """Take a point into the whole run, if it is due."""
        points = self.whole
        if points and point[0] - points[-1][0] < self.apart:
            if point[0] != points[-1][0]:
                return
            points.pop()
        points.append(point)
        if len(points) > POINTS:
            self.whole = points[::2]
            self.apart = max(2 * self.apart, int(self.whole[-1][0]) // POINTS)

    def cut(self, time: float) -> None:
        """Forget what was after a time."""
        with self.lock:
            self.whole = [point for point in self.whole if point[0] <= time]
            self.latest = deque(
                (sample for sample in self.latest if sample[0] <= time), maxlen=POINTS
            )

    @property
    def newest(self) -> float:
        """The latest value; NaN if there is none."""
        with self.lock:
            return self.latest[-1][1] if self.latest else math.nan

    def recorded(self) -> tuple[np.ndarray, np.ndarray]:
        """Times and values of all that is kept: in full over the end of the run, thinned before."""
        return self.arrays(last=EVER)

    def arrays(self, last: float = math.inf) -> tuple[np.ndarray, np.ndarray]:
        """Times and values of the whole run, or of the `last` of its time."""
        with self.lock:
            older, latest = list(self.whole), list(self.latest)
        if math.isinf(last) or not latest:
            return columns(older)
        since = latest[-1][0] - last
        before = (point for point in older if since <= point[0] < latest[0][0])
        return columns([*before, *(point for point in latest if point[0] >= since)])


def columns(points: list[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Points as two arrays."""
    array = np.array(points, float).reshape(-1, 2)
    return array[:, 0].copy(), array[:, 1].copy()


# Keeps a flock that is too dense from taking all time and all memory.

MOST_TO_RUN = 2e8
"""Pairs of neighbours above which one tick takes too long for a laboratory."""
MOST_TO_LIST = 1e7
"""Pairs of neighbours above which links, groups and layers are not looked for."""
SAMPLE = 64


class FlockPositions(Protocol):
    """What has neighbours: a flock, or a snapshot of one."""

    @property
    def position(self) -> np.ndarray: ...
    @property
    def world(self) -> World: ...
    @property
    def reach(self) -> float: ...


def expected_pairs(agents: int, size: np.ndarray, reach: float) -> float:
    """Pairs of neighbours among agents spread evenly over a box.

    >>> round(expected_pairs(1000, np.array([10.0, 10.0]), 1.0))
    15708
    """
    dim = len(size)
    ball = math.pi * reach**2 if dim == 2 else 4.0 / 3.0 * math.pi * reach**3
    return 0.5 * agents**2 * min(1.0, ball / float(np.prod(size)))


def refuse_too_dense(flock: Flock) -> None:
    """Raises InputError if the flock has too many neighbours to be run here."""
    pairs = expected_pairs(len(flock.ids), np.array(flock.world.size), flock.reach)
    if pairs > MOST_TO_RUN:
        raise InputError(
            f"{len(flock.ids)} agents that see {flock.reach:g} far in a world of side "
            f"{min(flock.world.size):.3g} have about {pairs:.0e} pairs of neighbours: at most "
            f"{MOST_TO_RUN:.0e} can be run here"
        )


def refuse_too_many_links(flock: FlockPositions) -> None:
    """Raises InputError if there are too many links to list, judged by some of the agents."""
    position, world = flock.position, flock.world
    if 0.5 * len(position) ** 2 <= MOST_TO_LIST:
        return
    links = 0
    chosen = np.linspace(0, len(position) - 1, SAMPLE).astype(int)
    size, images = np.array(world.size), np.array(world.images, bool)
    for row in chosen:
        apart = position - position[row]
        apart -= np.where(images, size * np.round(apart / size), 0.0)
        links += int(np.count_nonzero((apart**2).sum(axis=1) <= flock.reach**2)) - 1
    if 0.5 * len(position) * links / len(chosen) > MOST_TO_LIST:
        raise InputError("too many neighbours to show links, groups, layers and their number")
