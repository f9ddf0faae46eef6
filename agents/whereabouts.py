"""Whether agents are where they can be: not inside an obstacle, not beyond a solid edge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from agents.engine.cache import kept
from worlds.queries.crossing import skin
from worlds.queries.ground import signed_distance

if TYPE_CHECKING:
    from agents.motion import Motion


@dataclass(frozen=True)
class Stray:
    """An agent that is where it cannot be, the first row of those that are."""

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
def strays(ground, position, fate):
    """The first row that is inside something solid or -1, how far, and how many rows are.

    Rounding is none of it; those that have crashed lie where they lie.
    """
    first, depth, number = -1, 0.0, 0
    for i in range(position.shape[0]):
        x, y = position[i, 0], position[i, 1]
        z = position[i, 2] if position.shape[1] == 3 else 0.0
        d = signed_distance(ground, x, y, z)
        flies = fate.shape[0] == 0 or fate[i, 0] < 0.0
        if flies and d < -skin(x, y, z):
            number += 1
            if first < 0:
                first, depth = i, -d
    return first, depth, number


def stray(flock: Motion) -> Stray | None:
    """The first agent that is where it cannot be now, None if all are where they can be.

    Where nothing is solid, or agents go through it by their model's own setting, all can be
    anywhere.
    """
    if not flock.world.is_solid or flock.passing or not len(flock.ids):
        return None
    row, depth, number = strays(flock.engine.ground, flock.position, flock.arrays.fate)
    if row < 0:
        return None
    place = flock.position[row].copy()
    return Stray(int(flock.ids[row]), int(row), flock.tick, place, float(depth), int(number))


def warning(flock: Motion) -> str:
    """What to tell of a flock whose agents go through what is solid, or an empty string."""
    if not flock.passing:
        return ""
    return (
        f"{flock.model.name} with {flock.passing}: agents go through obstacles and solid edges, as "
        "in the literal text of its paper"
    )
