"""Agents that are where none can be: inside an obstacle or beyond a solid edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from agents.engine.arrays import Arrays
from agents.engine.cache import kept
from worlds.queries.crossing import skin
from worlds.queries.surroundings import Surroundings, signed_distance


@dataclass(frozen=True)
class StrayAgents:
    """The first row of the agents that are where none can be, and how many these are."""

    id: int
    row: int
    tick: int
    place: np.ndarray
    """(dim,), length."""
    depth: float
    """How far it is inside what is solid at least, length."""
    number: int
    """How many are, itself among them."""

    def __str__(self) -> str:
        where = ", ".join(f"{x:.6g}" for x in self.place)
        more = f", and {self.number - 1} more" if self.number > 1 else ""
        return (
            f"agent {self.id}{more} where it cannot be: {self.depth:.3g} inside what is solid at "
            f"({where}), tick {self.tick}"
        )


@kept
def strays(surroundings, position, crash_record):
    """The first row that is inside something solid or -1, how far, and how many rows are.

    Rounding is none of it; those that have crashed lie where they lie.
    """
    first, depth, number = -1, 0.0, 0
    for i in range(position.shape[0]):
        x, y = position[i, 0], position[i, 1]
        z = position[i, 2] if position.shape[1] == 3 else 0.0
        d = signed_distance(surroundings, x, y, z)
        flies = crash_record.shape[0] == 0 or crash_record[i, 0] < 0.0
        if flies and d < -skin(x, y, z):
            number += 1
            if first < 0:
                first, depth = i, -d
    return first, depth, number


def stray(surroundings: Surroundings, arrays: Arrays, tick: int) -> StrayAgents | None:
    """The first agent that is inside something solid, None if nobody is."""
    row, depth, number = strays(surroundings, arrays.position, arrays.crash_record)
    if row < 0:
        return None
    place = arrays.position[row].copy()
    return StrayAgents(int(arrays.ids[row]), int(row), tick, place, float(depth), int(number))
