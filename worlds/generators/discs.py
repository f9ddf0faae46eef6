"""Random discs, in space spheres: radii from a range, a least gap between any two."""

from __future__ import annotations

import numpy as np

from worlds.generators.world_generator import (
    GeneratedContents,
    GeneratorParameters,
    WorldGenerator,
    box_text,
    count,
    length,
)
from worlds.input_error import InputError
from worlds.obstacles import obstacle

TRIES = 5_000
"""Places tried for each disc."""


class DiscParameters(GeneratorParameters):
    """Random discs."""

    count: int = count(20, "number of discs")
    radius_low: float = length(0.5, "least radius")
    radius_high: float = length(2.0, "largest radius")
    gap: float = length(2.0, "least gap between two discs, and between a disc and the box", least=0)


def make_discs(
    rng: np.random.Generator, low: np.ndarray, size: np.ndarray, p: DiscParameters
) -> GeneratedContents:
    """Draw the radii, evenly in their range, and then a free place for each, the largest first.

    Raises InputError if one finds no place in TRIES tries.
    """
    if p.radius_low > p.radius_high:
        raise InputError(
            f"radius_low = {p.radius_low:g} m is above radius_high = {p.radius_high:g} m"
        )
    radii = np.sort(rng.uniform(p.radius_low, p.radius_high, p.count))[::-1]
    centres = np.empty((p.count, size.size))
    for k, radius in enumerate(radii):
        space = size - 2.0 * (radius + p.gap)
        candidates = low + radius + p.gap + np.maximum(space, 0.0) * rng.random((TRIES, size.size))
        place = (
            None
            if (space < 0.0).any()
            else free_candidates(candidates, radius + p.gap, centres[:k], radii[:k])
        )
        if place is None:
            raise InputError(
                f"count = {p.count} discs of radius {p.radius_low:g} to {p.radius_high:g} m with "
                f"gap = {p.gap:g} m do not fit in {box_text(size)}: {k} found a place, "
                f"the next one did not in {TRIES} tries"
            )
        centres[k] = place
    shape = "sphere" if size.size == 3 else "disc"
    return GeneratedContents(
        [
            obstacle({"shape": shape, "centre": centre, "radius": radius})
            for centre, radius in zip(centres.tolist(), radii.tolist(), strict=True)
        ]
    )


def free_candidates(
    candidates: np.ndarray, clearance: float, centres: np.ndarray, radii: np.ndarray
) -> np.ndarray | None:
    """The first of the drawn places (T, dim) that is `clearance` away from all discs, if any.

    Places are looked at in growing parts, as one of the first is nearly always free.
    """
    begin, part = 0, 16
    while begin < len(candidates):
        places = candidates[begin : begin + part]
        gaps = np.linalg.norm(places[:, None] - centres[None], axis=2) - radii
        free_rows = np.flatnonzero((gaps >= clearance).all(axis=1))
        if free_rows.size:
            return places[free_rows[0]]
        begin, part = begin + part, 2 * part
    return None


DISCS = WorldGenerator("discs", "Random discs", DiscParameters, make_discs, (2, 3))
