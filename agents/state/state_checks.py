"""Whether arrays that come from a file are a flock's: what compiled code takes on trust."""

from __future__ import annotations

import numpy as np

from agents.engine.arrays import Arrays
from agents.state.crashes import CAUSES
from worlds.input_error import InputError
from worlds.world import World

FARTHEST = 1e12
"""How far an agent can be from the origin, length."""
LARGEST = 2**53
"""No tick and no identity is larger, so that each is exact as a float too."""
ROUNDED = 1e-6
"""By how much the length of a heading may be off 1."""


def demand_usable(arrays: Arrays, world: World, origin: str) -> None:
    """Raise InputError, naming the row, where the rows of a file cannot be a flock in a world."""
    n = len(arrays.ids)
    for name in ("position", "heading", "speed"):
        demand(np.isfinite(getattr(arrays, name)), f"a {name} that is no finite number", origin)
    demand(np.abs(arrays.position) <= FARTHEST, "a position that is too far away", origin)
    length = np.linalg.norm(arrays.heading, axis=1)
    demand(np.abs(length - 1.0) <= ROUNDED, "a heading that is no unit vector", origin)
    demand((arrays.ids >= 0) & (arrays.ids < LARGEST), "an identity that none can be", origin)
    if len(np.unique(arrays.ids)) < n:
        raise InputError(f"{origin} has two agents of one identity at one tick")
    path = None if world.mission is None else world.mission.path
    legs = 0 if path is None else len(path.waypoints)
    demand((arrays.leg >= 0) & (arrays.leg <= legs), "a waypoint that is not there", origin)
    if len(arrays.crash_record):
        tick, cause = arrays.crash_record[:, :2].T
        known = (tick < 0.0) | np.isin(cause, list(CAUSES))
        sound = np.isfinite(arrays.crash_record).all(axis=1) & (np.abs(tick) < LARGEST)
        demand(known & sound, "a crash that cannot be", origin)


def demand(sound: np.ndarray, fault: str, origin: str) -> None:
    """Raise InputError for the first row that is not sound, (N,) or (N, dim)."""
    whole = sound.reshape(len(sound), -1).all(axis=1)
    if not whole.all():
        row = int(np.argmin(whole))
        raise InputError(f"{origin} holds {fault} (row {row} of its tick)")
