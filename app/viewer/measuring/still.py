"""A flock held still, so that it can be measured in a thread aside while the flock flies on."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from agents.flock import Flock
from agents.observables.components import groups_within
from agents.observables.layers import layers
from agents.observables.neighbours import links
from app.viewer.measuring.crowd import refuse_too_many_links
from app.viewer.measuring.measured import measures


class Still:
    """Copies of all that observables see of a flock at one tick: of the agents that fly.

    The graph is found once, however many observables follow from it.
    """

    def __init__(self, flock: Flock):
        seen = flock.aloft
        self.tick, self.dt = flock.tick, flock.dt
        self.reach, self.together = flock.reach, flock.together
        self.model, self.world, self.parameters = flock.model, flock.world, flock.parameters
        self.seed = flock.seed
        self.position, self.heading = seen.position.copy(), seen.heading.copy()
        self.speed, self.informed = seen.speed.copy(), seen.informed.copy()
        self.ids = seen.ids.copy()
        self.reference = None if seen.reference is None else seen.reference.copy()
        self.measures = {name: seen.signal(name) for name in measures(flock)}

    @cached_property
    def pairs(self) -> np.ndarray:
        """Links, int (M, 2). Raises Refusal if there are too many."""
        refuse_too_many_links(self)
        return links(self.position, self.reach, self.world.size, self.world.images)

    @cached_property
    def labels(self) -> np.ndarray:
        """Groups, int (N,)."""
        return groups_within(self.position, self.together, self.world.size, self.world.images)

    def links(self) -> np.ndarray:
        """As `Flock.links`."""
        return self.pairs

    def group_labels(self) -> np.ndarray:
        """As `Flock.group_labels`."""
        return self.labels

    def layers(self) -> np.ndarray:
        """As `Flock.layers`."""
        return layers(self.pairs, self.informed)

    def signal(self, name: str) -> np.ndarray:
        """What is measured of each agent within the pass, (N,); nan before the first tick."""
        return self.measures.get(name, np.full(len(self.ids), np.nan))
