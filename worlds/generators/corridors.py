"""Corridors: parallel walls across the box, each with gaps at random places."""

from __future__ import annotations

import numpy as np

from worlds.generators.world_generator import (
    GeneratedContents,
    GeneratorParameters,
    WorldGenerator,
    count,
    length,
)
from worlds.input_error import InputError
from worlds.obstacles import Obstacle, Wall


class CorridorParameters(GeneratorParameters):
    """Corridors."""

    walls: int = count(4, "number of walls across the box", most=1000)
    gaps: int = count(2, "gaps in each wall", most=1000)
    width: float = length(3.0, "width of a gap")
    thickness: float = length(0.5, "thickness of the walls")


def make_corridors(
    rng: np.random.Generator, low: np.ndarray, size: np.ndarray, p: CorridorParameters
) -> GeneratedContents:
    """Draw walls along y at even distances along x, and their gaps.

    Between two gaps, and between a gap and the box, there is a piece of wall at least as long as
    the wall is thick. Raises InputError if walls or gaps do not fit.
    """
    wall_distance = size[0] / (p.walls + 1)
    if wall_distance <= p.thickness:
        raise InputError(
            f"walls = {p.walls} with thickness = {p.thickness:g} m do not fit in {size[0]:g} m: "
            f"one stands every {wall_distance:g} m"
        )
    spare_length = size[1] - p.gaps * p.width - (p.gaps + 1) * p.thickness
    if spare_length < 0.0:
        raise InputError(
            f"gaps = {p.gaps} of width = {p.width:g} m do not fit in a wall {size[1]:g} m long"
        )
    walls: list[Obstacle] = []
    for k in range(1, p.walls + 1):
        x = float(low[0] + k * wall_distance)
        begins = np.sort(rng.uniform(0.0, spare_length, p.gaps))
        begins += p.thickness + np.arange(p.gaps) * (p.width + p.thickness)
        starts = low[1] + np.concatenate([[0.0], begins + p.width])
        ends = low[1] + np.concatenate([begins, [size[1]]])
        walls += [
            Wall(start=(x, start), end=(x, end), thickness=p.thickness)
            for start, end in zip(starts.tolist(), ends.tolist(), strict=True)
        ]
    return GeneratedContents(walls)


CORRIDORS = WorldGenerator(
    "corridors", "Parallel walls with gaps", CorridorParameters, make_corridors
)
