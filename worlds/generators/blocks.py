"""Random blocks: rectangles at any angle, in space boxes along the axes, a least gap between."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from worlds.generators.world_generator import (
    GeneratedContents,
    GeneratorParameters,
    WorldGenerator,
    box_text,
    count,
    length,
)
from worlds.input_error import InputError
from worlds.obstacles import Box, Polygon

TRIES = 2_000
"""Places tried for each block."""


class BlockParameters(GeneratorParameters):
    """Random blocks."""

    count: int = count(12, "number of blocks")
    side_low: float = length(2.0, "least side")
    side_high: float = length(8.0, "largest side")
    gap: float = length(2.0, "least gap between two blocks, and between a block and the box",
                        least=0)  # fmt: skip


def make_blocks(
    rng: np.random.Generator, low: np.ndarray, size: np.ndarray, p: BlockParameters
) -> GeneratedContents:
    """Draw the sides, evenly in their range, and then a free place for each, the largest first.

    Raises InputError if one finds no place in TRIES tries.
    """
    if p.side_low > p.side_high:
        raise InputError(f"side_low = {p.side_low:g} m is above side_high = {p.side_high:g} m")
    sides = rng.uniform(p.side_low, p.side_high, (p.count, size.size))
    sides = sides[np.argsort(-sides.prod(axis=1), kind="stable")]
    place = place_box if size.size == 3 else place_rectangle
    shapes: list[Any] = []
    for k, side in enumerate(sides):
        block = place(rng, low, size, side, p.gap, shapes)
        if block is None:
            raise InputError(
                f"count = {p.count} blocks with sides of {p.side_low:g} to {p.side_high:g} m and "
                f"gap = {p.gap:g} m do not fit in {box_text(size)}: {k} found a place, "
                f"the next one did not in {TRIES} tries"
            )
        shapes.append(block)
    if size.size == 3:
        return GeneratedContents(
            [Box(low=tuple(lo.tolist()), high=tuple(hi.tolist())) for lo, hi in shapes]
        )
    return GeneratedContents([Polygon(points=block.exterior.coords[:-1]) for block in shapes])


def place_rectangle(
    rng: np.random.Generator,
    low: np.ndarray,
    size: np.ndarray,
    side: np.ndarray,
    gap: float,
    rectangles: list[shapely.Polygon],
) -> shapely.Polygon | None:
    """A rectangle at a random angle and place, `gap` from all others and from the box."""
    corners = 0.5 * side * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    for _ in range(TRIES):
        angle = rng.uniform(0.0, np.pi)
        turn = np.array([(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))])
        points = low + size * rng.random(2) + corners @ turn
        if (points < low + gap).any() or (points > low + size - gap).any():
            continue
        rectangle = shapely.Polygon(points)
        if not rectangles or shapely.distance(rectangle, rectangles).min() >= max(gap, 1e-9):
            return rectangle
    return None


def place_box(
    rng: np.random.Generator,
    low: np.ndarray,
    size: np.ndarray,
    side: np.ndarray,
    gap: float,
    boxes: list[tuple[np.ndarray, np.ndarray]],
) -> tuple[np.ndarray, np.ndarray] | None:
    """The corners of a box at a random place, `gap` from all others and from the box around."""
    space = size - side - 2.0 * gap
    if (space < 0.0).any():
        return None
    lows = low + gap + space * rng.random((TRIES, size.size))
    if not boxes:
        return lows[0], lows[0] + side
    others_low, others_high = (np.array(corners) for corners in zip(*boxes, strict=True))
    gaps = np.maximum(others_low - (lows[:, None] + side), lows[:, None] - others_high)
    distance = np.linalg.norm(np.maximum(gaps, 0.0), axis=2)
    free_rows = np.flatnonzero((distance >= max(gap, 1e-9)).all(axis=1))
    return (lows[free_rows[0]], lows[free_rows[0]] + side) if free_rows.size else None


BLOCKS = WorldGenerator("blocks", "Random blocks", BlockParameters, make_blocks, (2, 3))
