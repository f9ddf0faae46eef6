"""The observables by name, each with its unit and range, as functions of a flock."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.observables import consistency, groups, layers, neighbours, order


@dataclass(frozen=True)
class Observable:
    """One measured quantity."""

    name: str
    title: str
    unit: str
    range: str
    measure: Callable[[Any], Any]
    """Takes a flock."""


def nearest(flock) -> float:
    """Least distance between two agents of the flock."""
    world = flock.world
    found = neighbours.nearest_neighbour(flock.position, world.size, world.images)
    return float(np.min(found, initial=np.inf))


OBSERVABLES = {
    one.name: one
    for one in [
        Observable(
            "polarisation",
            "Length of the mean heading",
            "1",
            "[0, 1]",
            lambda flock: order.polarisation(flock.heading),
        ),
        Observable(
            "consistency",
            "Degree of consistency with the information agent's heading, or with the mean heading",
            "1",
            "[0, 1]",
            lambda flock: consistency.consistency(flock.heading, flock.reference),
        ),
        Observable(
            "groups",
            "Connected groups of the r-graph",
            "groups",
            "[0, N]",
            lambda flock: len(groups.group_sizes(flock.group_labels())),
        ),
        Observable(
            "largest-group",
            "Agents in the largest group",
            "agents",
            "[0, N]",
            lambda flock: int(np.max(groups.group_sizes(flock.group_labels()), initial=0)),
        ),
        Observable(
            "mean-neighbours",
            "Mean number of neighbours within r",
            "agents",
            "[0, N - 1]",
            lambda flock: 2.0 * len(flock.links()) / max(1, len(flock.position)),
        ),
        Observable(
            "nearest-neighbour", "Least distance between agents", "length", "[0, inf]", nearest
        ),
        Observable(
            "connectivity",
            "Algebraic connectivity of the r-graph",
            "1",
            "[0, N]",
            lambda flock: groups.algebraic_connectivity(len(flock.position), flock.links()),
        ),
        Observable(
            "layers",
            "Agents in each layer below the information agents",
            "agents",
            "layer -> [0, N]",
            lambda flock: layers.layer_histogram(flock.layers()),
        ),
    ]
}
