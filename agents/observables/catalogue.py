"""The observables by name, each with its unit and range, as functions of a flock."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.observables import consistency, groups, layers, neighbours, order, rotation
from worlds.clearance import clearance


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


def obstacle_distance(flock) -> float:
    """Least signed distance of an agent to what is solid."""
    return float(np.min(clearance(flock.world, flock.position), initial=np.inf))


def inside(flock) -> int:
    """How many agents are inside an obstacle or beyond a solid edge."""
    return int((clearance(flock.world, flock.position) < 0.0).sum())


def goal_distance(flock) -> float:
    """Distance of the flock's centre to the goal, or to the end of the path; nan without."""
    mission = flock.world.mission
    if mission is None or (mission.goal is None and mission.path is None):
        return float("nan")
    if mission.goal is not None:
        end = flock.goal_at([flock.tick])[0]
    else:
        end = np.array(mission.path.waypoints[-1])
    return float(np.linalg.norm(flock.position.mean(axis=0) - end))


def following(flock) -> float:
    """Share of agents in the component of an information agent; nan without one."""
    if not flock.informed.any():
        return float("nan")
    return float((flock.layers() <= len(flock.ids)).mean())


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
            "angular-momentum",
            "How much the flock mills about its centre",
            "1",
            "[0, 1]",
            lambda flock: rotation.angular_momentum(
                flock.position, flock.heading, flock.world.size, flock.world.images
            ),
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
            "obstacle-distance",
            "Least distance of an agent to an obstacle or a solid edge",
            "length",
            "[-inf, inf]",
            obstacle_distance,
        ),
        Observable(
            "inside-obstacles",
            "Agents inside an obstacle or beyond a solid edge",
            "agents",
            "[0, N]",
            inside,
        ),
        Observable(
            "goal-distance",
            "Distance of the flock's centre to the goal or to the end of the path",
            "length",
            "[0, inf]",
            goal_distance,
        ),
        Observable(
            "following",
            "Share of agents linked to an information agent",
            "1",
            "[0, 1]",
            following,
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
