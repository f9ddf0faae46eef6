"""Grids of cells as areas: the outline of cells that share a side, exactly along their sides."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import shapely

from worlds.input_error import InputError
from worlds.readers.drawing_contents import MOST_CORNERS, Item
from worlds.readers.drawn_shapes import Shape, area

MOST_CELLS = 25_000_000
"""Cells of a grid at most: 250 m by 250 m in cells of 5 cm."""
MOST_RUNS = 200_000
"""Most rows of cells side by side that are joined to outlines; noise has one for every other."""


@dataclass(frozen=True)
class RasterGrid:
    """Where cells lie: the lower left corner of the first, their side, and the turn of the rows."""

    origin: tuple[float, float]
    side: float
    turn: float = 0.0
    """Anticlockwise about the origin, rad."""

    def places(self, corner: np.ndarray) -> np.ndarray:
        """Corners of cells, counted from the origin, (n, 2), as places, (n, 2)."""
        x, y = (self.side * corner).T
        if self.turn != 0.0:
            c, s = math.cos(self.turn), math.sin(self.turn)
            x, y = c * x - s * y, s * x + c * y
        return np.column_stack([x + self.origin[0], y + self.origin[1]])


def cells(layer: str, solid: np.ndarray, grid: RasterGrid, origin: str) -> Item:
    """Cells of one kind as an item; `solid` (rows, columns) has its lowest row first."""
    return Item(layer, "grid", partial(outlines, solid, grid, f"{origin}, {layer}"))


def outlines(solid: np.ndarray, grid: RasterGrid, origin: str) -> list[Shape]:
    """The areas of cells, each with its holes. Raises InputError where they are too many."""
    # Along each row, where a run begins and where it ends.
    padded = np.zeros((solid.shape[0], solid.shape[1] + 2), np.int8)
    padded[:, 1:-1] = solid
    change = np.diff(padded, axis=1)
    row, begin = np.nonzero(change == 1)
    _, end = np.nonzero(change == -1)
    if len(row) > MOST_RUNS:
        raise InputError(
            f"{origin}: {len(row)} rows of cells, at most {MOST_RUNS} are read: a map of "
            "fewer cells, or with less noise, is needed"
        )
    joined = shapely.union_all(shapely.box(begin, row, end, row + 1))
    parts = [part for part in shapely.get_parts(joined.simplify(0.0)) if not part.is_empty]
    if shapely.get_num_coordinates(joined) > 4 * MOST_CORNERS:
        raise InputError(
            f"{origin}: its outlines have more than {MOST_CORNERS} corners, too many to read"
        )
    return [area("", rings(part, grid), origin) for part in parts]


def rings(part: shapely.Polygon, grid: RasterGrid) -> list[Sequence[tuple[float, float]]]:
    """The outline and the holes of an area of cells, as places."""
    return [
        [(float(x), float(y)) for x, y in grid.places(shapely.get_coordinates(ring))]
        for ring in (part.exterior, *part.interiors)
    ]


def demand_few_cells(width: int, height: int, path: object) -> None:
    """Refuse a grid that is too large, or has no cell, before its cells are read."""
    if width < 1 or height < 1:
        raise InputError(f"{path}: a grid of {width} x {height} cells holds nothing")
    if width * height > MOST_CELLS:
        raise InputError(f"{path}: {width} x {height} cells are too many, at most {MOST_CELLS}")
