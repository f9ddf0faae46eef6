"""The agents of a flock that fly, as observables see them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from agents.observables.components import groups_within
from agents.observables.layers import layers
from agents.observables.neighbours import links

if TYPE_CHECKING:
    from agents.flock import Flock


class Aloft:
    """A flock without those that have crashed, to be read only; rows are those that fly.

    What is not of its agents (world, parameters, tick, ...) is the flock's own.
    """

    def __init__(self, flock: Flock):
        self.flock = flock
        self.rows = np.flatnonzero(flock.flying)
        self.position, self.heading = flock.position[self.rows], flock.heading[self.rows]
        self.speed, self.informed = flock.speed[self.rows], flock.informed[self.rows]
        self.ids = flock.ids[self.rows]

    def __getattr__(self, name: str):
        return getattr(self.flock, name)

    def links(self) -> np.ndarray:
        """As `Flock.links`, with rows of those that fly."""
        world = self.flock.world
        return links(self.position, self.flock.reach, world.size, world.images)

    def group_labels(self) -> np.ndarray:
        """As `Flock.group_labels`."""
        world = self.flock.world
        return groups_within(self.position, self.flock.together, world.size, world.images)

    def layers(self) -> np.ndarray:
        """As `Flock.layers`."""
        return layers(self.links(), self.informed)

    def signal(self, name: str) -> np.ndarray:
        """As `Flock.signal`."""
        return self.flock.signal(name)[self.rows]

    @property
    def reference(self) -> np.ndarray | None:
        """As `Flock.reference`."""
        return self.heading[np.argmax(self.informed)] if self.informed.any() else None
