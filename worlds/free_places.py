"""Whether places that somebody gives are places where agents can be."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import shapely

from worlds.queries.clearance import clearance
from worlds.refusal import Refusal

if TYPE_CHECKING:
    from worlds.world import World


def demand_in_box(world: World, position: np.ndarray, passing: bool = False) -> None:
    """Raise Refusal for the first of the places (N, dim) beyond an edge that wraps or is solid.

    An edge that wraps does not fold what is given; beyond an open one agents may be, and beyond a
    solid one those that go through what is solid (`passing`).
    """
    for axis, edge in enumerate(world.edges):
        if edge == "open" or (edge == "solid" and passing):
            continue
        low, high = world.low[axis], world.low[axis] + world.size[axis]
        beyond = (position[:, axis] < low) | (position[:, axis] > high)
        if edge == "wrap":
            beyond |= position[:, axis] == high
        if beyond.any():
            row = int(np.argmax(beyond))
            end = ")" if edge == "wrap" else "]"
            raise Refusal(
                f"position of row {row} is {position[row].tolist()}: {'xyz'[axis]} = "
                f"{position[row, axis]:g} is outside [{low:g}, {high:g}{end}, the box of "
                f"{world.name}, whose edges there are {'wrapping' if edge == 'wrap' else 'solid'}"
            )


def demand_free(world: World, position: np.ndarray) -> None:
    """Raise Refusal for the first of the places (N, dim) that is inside an obstacle, naming it."""
    if not world.obstacles:
        return
    inside = clearance(world, position) < 0.0
    if inside.any():
        row = int(np.argmax(inside))
        raise Refusal(
            f"position of row {row} is {position[row].tolist()}: that is inside "
            f"{obstacle_at(world, position[row])} of {world.name}, and agents start outside"
        )


def obstacle_at(world: World, place: np.ndarray) -> str:
    """The name of an obstacle that has a place (dim,) on its footprint, or `an obstacle`."""
    point = shapely.Point(place[:2])
    found = [one for one in world.obstacles if one.footprint().intersects(point)]
    return f"the obstacle {found[0].label}" if found else "an obstacle"
