"""A forest: trunks of a given density, spread evenly as trees are, a least gap between any two."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from worlds.generators.world_generator import (
    GeneratedContents,
    GeneratorParameters,
    WorldGenerator,
    box_text,
    length,
)
from worlds.input_error import InputError
from worlds.obstacles import Disc

FILLED = 0.7
"""Points times squared distance per area that a Poisson disc sampling reaches, about."""
EVEN = 0.8
"""Distance of trunks as a share of the largest that their density allows."""


class ForestParameters(GeneratorParameters):
    """A forest."""

    density: float = Field(0.03, description="trunks per m²", gt=0.0, le=100.0)
    radius_low: float = length(0.2, "least radius of a trunk")
    radius_high: float = length(0.6, "largest radius of a trunk")
    gap: float = length(1.5, "least gap between two trunks, and between a trunk and the box",
                        least=0)  # fmt: skip


def make_forest(
    rng: np.random.Generator, low: np.ndarray, size: np.ndarray, p: ForestParameters
) -> GeneratedContents:
    """Draw trunks by Poisson disc sampling (Bridson 2007), and leave as many as the density says.

    Raises InputError if so many do not find a place.
    """
    from scipy.stats import qmc

    if p.radius_low > p.radius_high:
        raise InputError(
            f"radius_low = {p.radius_low:g} m is above radius_high = {p.radius_high:g} m"
        )
    tree_count = max(1, round(p.density * size.prod()))
    edge = p.gap + p.radius_high
    space = size - 2.0 * edge
    least_distance = p.gap + 2.0 * p.radius_high
    distance = max(least_distance, EVEN * np.sqrt(FILLED * space.clip(0.0).prod() / tree_count))
    places = np.empty((0, 2))
    if (space > 0.0).all():
        sampler = qmc.PoissonDisk(
            2, radius=distance, rng=rng, l_bounds=low + edge, u_bounds=low + edge + space
        )
        places = sampler.fill_space()
    if len(places) < tree_count:
        raise InputError(
            f"density = {p.density:g} per m² with gap = {p.gap:g} m and radii up to "
            f"{p.radius_high:g} m does not fit in {box_text(size)}: {len(places)} of {tree_count} "
            "trunks found a place"
        )
    centres = places[rng.permutation(len(places))[:tree_count]]
    radii = rng.uniform(p.radius_low, p.radius_high, tree_count)
    return GeneratedContents(
        [
            Disc(centre=tuple(centre), radius=radius)
            for centre, radius in zip(centres.tolist(), radii.tolist(), strict=True)
        ]
    )


FOREST = WorldGenerator("forest", "A forest of trunks", ForestParameters, make_forest)
