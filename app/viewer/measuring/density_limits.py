"""Keeps a flock that is too dense from taking all time and all memory."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from agents.flock import Flock
from worlds.input_error import InputError
from worlds.world import World

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
    seen = 0
    chosen = np.linspace(0, len(position) - 1, SAMPLE).astype(int)
    size, images = np.array(world.size), np.array(world.images, bool)
    for row in chosen:
        apart = position - position[row]
        apart -= np.where(images, size * np.round(apart / size), 0.0)
        seen += int(np.count_nonzero((apart**2).sum(axis=1) <= flock.reach**2)) - 1
    if 0.5 * len(position) * seen / len(chosen) > MOST_TO_LIST:
        raise InputError("too many neighbours to show links, groups, layers and their number")
