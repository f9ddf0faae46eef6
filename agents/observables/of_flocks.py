"""What is measured of a flock in its world, from the functions of plain arrays.

Each takes the agents of a flock that have not crashed, an `agents.snapshot.Snapshot`, which may be
of nobody.
"""

from __future__ import annotations

import math

import numpy as np

from agents.observables import correlation, groups, neighbours
from agents.observables.formation import INDUCED
from worlds.queries.clearance import clearance

SAVED = "saved"
"""The measure of a body that tells the share of its induced drag an agent saves."""


def nearest(flock) -> float:
    """Least distance between two agents of the flock."""
    world = flock.world
    distances = neighbours.nearest_neighbour(flock.position, world.size, world.images)
    return float(np.min(distances, initial=np.inf))


def mean_neighbours(flock) -> float:
    """Mean number of neighbours within reach."""
    world = flock.world
    return neighbours.mean_neighbours(flock.position, flock.reach, world.size, world.images)


def obstacle_distance(flock) -> float:
    """Least signed distance of an agent to what is solid."""
    return float(np.min(clearance(flock.world, flock.position), initial=np.inf))


def inside(flock) -> int:
    """How many agents are inside an obstacle or beyond a solid edge."""
    return int((clearance(flock.world, flock.position) < 0.0).sum())


def goal_distance(flock) -> float:
    """Distance of the flock's centre to the goal, or to the end of the path; nan without."""
    mission = flock.world.mission
    if mission is None or (mission.goal is None and mission.path is None) or not len(flock.ids):
        return math.nan
    if mission.goal is not None:
        end = flock.goal_at([flock.tick])[0]
    else:
        end = np.array(mission.path.waypoints[-1])
    return float(np.linalg.norm(flock.position.mean(axis=0) - end))


def following(flock) -> float:
    """Share of agents in the component of an information agent; nan without one."""
    if not flock.informed.any():
        return math.nan
    return float((flock.layers() <= len(flock.ids)).mean())


def connectivity(flock) -> float:
    """Algebraic connectivity of the r-graph; 0 if it is not in one piece."""
    if number_of_groups(flock) != 1:
        return 0.0
    return groups.algebraic_connectivity(len(flock.ids), flock.links(), flock.world.dim)


def layer_histogram(flock) -> dict[int, int]:
    """How many agents are in each layer; without an information agent all are in N + 1."""
    n = len(flock.ids)
    if n and not flock.informed.any():
        return {n + 1: n}
    return neighbours.layer_histogram(flock.layers())


def number_of_groups(flock) -> int:
    """How many connected groups the r-graph has."""
    return len(groups.group_sizes(flock.group_labels()))


def largest_group(flock) -> int:
    """How many agents the largest group has."""
    return int(np.max(groups.group_sizes(flock.group_labels()), initial=0))


def group_polarisation(flock) -> float:
    """Polarisation of the largest group; nan for an empty flock."""
    label = flock.group_labels()
    return float(groups.polarisations(label, flock.heading)[0]) if len(label) else math.nan


def group_angular_momentum(flock) -> float:
    """Angular momentum of the largest group about its own centre; nan for an empty flock."""
    label, world = flock.group_labels(), flock.world
    if not len(label):
        return math.nan
    first = label == 0
    position, heading = flock.position[first], flock.heading[first]
    return float(
        groups.angular_momenta(label[first], position, heading, world.size, world.images)[0]
    )


def group_table(flock) -> dict[int, dict[str, float]]:
    """Agents, polarisation and angular momentum of each group, by its label, largest first."""
    label, world = flock.group_labels(), flock.world
    return groups.group_table(label, flock.position, flock.heading, world.size, world.images)


def correlation_length(flock) -> float:
    """xi of the velocity fluctuations; nan if all velocities are the same.

    Before the first tick of a model with a constant speed nobody has a speed: headings stand for
    velocities then, which makes no difference where speeds are equal.
    """
    velocity = flock.heading * flock.speed[:, None] if flock.speed.any() else flock.heading
    world = flock.world
    return correlation.correlation_length(flock.position, velocity, world.size, world.images)


def crashes(flock) -> float:
    """How many agents have crashed so far; nan for a flock in which nobody can."""
    return len(flock.crashes) if flock.can_crash else math.nan


def entered(flock) -> float:
    """How many agents have entered through sources so far; nan in a world without."""
    mission = flock.world.mission
    is_known = mission is not None and mission.sources and flock.entries.is_known
    return len(flock.entries) if is_known else math.nan


def waiting(flock) -> float:
    """How many agents are due at a source and find no free place; nan in a world without."""
    return math.nan if math.isnan(entered(flock)) else flock.waiting


def exited(flock) -> float:
    """How many agents have left through exits so far; nan in a world without."""
    mission = flock.world.mission
    is_known = mission is not None and mission.exits and flock.exits.is_known
    return len(flock.exits) if is_known else math.nan


def flow(flock) -> float:
    """J = (N - 1) / (t_N - t_1) of the N agents that have left, per unit of time.

    The mean flow through a line as crowd science has it (Seyfried et al. 2009, "New insights into
    pedestrian flow through bottlenecks"). nan until two have left at different ticks.
    """
    tick = flock.exits.tick
    if math.isnan(exited(flock)) or len(tick) < 2 or tick[-1] == tick[0]:
        return math.nan
    return float((len(tick) - 1) / ((tick[-1] - tick[0]) * flock.dt))


def catches(flock) -> float:
    """How many agents were caught so far; nan where nobody catches, or where it is not known."""
    is_known = flock.kinds.catchers and flock.catches.is_known
    return len(flock.catches) if is_known else math.nan


def kind_distance(flock) -> float:
    """Distance from an agent to the nearest of another kind, mean of all agents, length.

    nan where all are of one kind.
    """
    kind = flock.arrays.kind
    numbers = np.unique(kind)
    if len(numbers) < 2:
        return math.nan
    size, images = flock.world.size, flock.world.images
    total = 0.0
    for number in numbers:
        others = neighbours.tree(flock.position[kind != number], size, images)
        mine = neighbours.tree(flock.position[kind == number], size, images)
        total += float(others.query(mine.data)[0].sum())
    return total / len(kind)


def kind_mixing(flock) -> float:
    """Share of the pairs of agents within the rule's reach that are of two kinds, in [0, 1].

    nan where all are of one kind, or where there is no such pair.
    """
    kind = flock.arrays.kind
    if len(np.unique(kind)) < 2:
        return math.nan
    pairs = neighbours.links(flock.position, flock.reach, flock.world.size, flock.world.images)
    return float((kind[pairs[:, 0]] != kind[pairs[:, 1]]).mean()) if len(pairs) else math.nan


def drag_saved(flock) -> float:
    """Induced drag that the agents save by each other's upwash, mean, in percent.

    nan for a model that does not measure it, and before the first tick.
    """
    if SAVED not in flock.model.columns:
        return math.nan
    share = flock.signal(SAVED)
    share = share[np.isfinite(share)]
    return 100.0 * float(share.mean()) if len(share) else math.nan


def energy_saved(flock, induced: float = INDUCED) -> float:
    """Power that the agents save by each other's upwash, mean, in percent.

    `induced` is the share of the power that goes into induced drag, in [0, 1]. nan as `drag_saved`.
    """
    return induced * drag_saved(flock)


def divergence(flock) -> float:
    """Mean distance from each agent to its counterpart in the flock that it is compared with,
    length; NaN where there is no pair."""
    if flock.paired is None:
        return math.nan
    world = flock.world
    apart = neighbours.separation(flock.position, flock.paired, world.size, world.images)
    distance = np.linalg.norm(apart, axis=1)
    distance = distance[np.isfinite(distance)]
    return float(distance.mean()) if len(distance) else math.nan
