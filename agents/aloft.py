"""The agents of a flock that are measured: those that have not crashed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from agents.observables.checks import is_finite, leave_out, whole_rows
from agents.observables.components import groups_within
from agents.observables.layers import layers
from agents.observables.neighbours import links

if TYPE_CHECKING:
    from agents.flock import Flock


def aloft(flock: Flock) -> Flock | Aloft:
    """A flock without those that have crashed, as observables see it.

    Agents whose position, heading or speed is no number are left out too, and a warning says how
    many (`agents.observables.checks.LeftOut`).
    """
    flying = flock.flying
    all_fly = bool(flying.all())
    arrays = flock.position, flock.heading, flock.speed
    if all(is_finite(array) for array in arrays):
        return flock if all_fly else Aloft(flock, np.flatnonzero(flying))
    whole = whole_rows(*arrays)
    leave_out(int((flying & ~whole).sum()), int(flying.sum()), "agents")
    return Aloft(flock, np.flatnonzero(flying & whole))


class Aloft:
    """A flock without some of its agents, to be read only; `rows` are those that it has.

    What is not of its agents (world, parameters, tick, ...) is the flock's own.
    """

    def __init__(self, flock: Flock, rows: np.ndarray):
        self.flock = flock
        self.rows = rows
        self.position, self.heading = flock.position[self.rows], flock.heading[self.rows]
        self.speed, self.informed = flock.speed[self.rows], flock.informed[self.rows]
        self.ids = flock.ids[self.rows]

    def __getattr__(self, name: str):
        return getattr(self.flock, name)

    def links(self) -> np.ndarray:
        """As `Flock.links`, with rows of these agents."""
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
