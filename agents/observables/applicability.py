"""Which flocks an observable says something of: each takes a flock in its world."""

from __future__ import annotations

from agents.observables.of_flocks import SAVED


def among_solids(flock) -> bool:
    """Whether there is anything to run into."""
    return flock.world.is_solid


def in_a_corridor(flock) -> bool:
    """Whether its world is flat, goes on for ever along x and ends along y."""
    world = flock.world
    return world.dim == 2 and bool(world.wraps[0] and not world.wraps[1])


def on_its_way(flock) -> bool:
    """Whether its mission has an end: a goal, or that of a path."""
    mission = flock.world.mission
    return mission is not None and (mission.goal is not None or mission.path is not None)


def led(flock) -> bool:
    """Whether there are information agents."""
    return bool(flock.informed.any())


def led_along_a_path(flock) -> bool:
    """Whether there are information agents that have a path to follow."""
    mission = flock.world.mission
    return mission is not None and mission.path is not None and led(flock)


def can_crash(flock) -> bool:
    """Whether agents that touch something crash."""
    return flock.can_crash


def saves(flock) -> bool:
    """Whether its bodies measure what they save by each other's upwash."""
    return SAVED in flock.model.columns
