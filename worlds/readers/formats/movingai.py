"""Maps of the MovingAI benchmarks: a letter a cell, of which a side is one unit.

Source: N. R. Sturtevant, Benchmarks for grid-based pathfinding (2012), file formats.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import shapely

from worlds.input_error import InputError, shorten
from worlds.readers.drawing_contents import DrawingContents, Item, text_of
from worlds.readers.drawn_shapes import Shape, area
from worlds.readers.formats.grid import RasterGrid, cells, demand_few_cells, rings
from worlds.readers.roles import IGNORE, OBSTACLE, WALKABLE

HEADER = ("type", "height", "width")
LAYERS = {"@": "out of bounds", "O": "out of bounds", "T": "trees", "W": "water", "S": "swamp",
          ".": "ground", "G": "ground"}  # fmt: skip
"""What each letter is."""
MAP = "map"
ROLES = {
    MAP: (WALKABLE, "its width and height"),
    "out of bounds": (OBSTACLE, "the format says so"),
    "trees": (OBSTACLE, "the format says so"),
    "water": (OBSTACLE, "nobody comes into it from the ground"),
    "swamp": (IGNORE, "the format says that it can be passed"),
}


def read_movingai(path: Path) -> DrawingContents:
    """The map. Raises InputError with the line that is wrong."""
    lines = text_of(path).splitlines()
    width, height, first = header(lines, path)
    demand_few_cells(width, height, path)
    rows = lines[first:]
    while rows and not rows[-1].strip():
        rows.pop()
    if len(rows) != height:
        raise InputError(f"{path}: height = {height}, but there are {len(rows)} rows of the map")
    for number, row in enumerate(rows, start=first + 1):
        if len(row) != width:
            raise InputError(f"{path}, line {number}: {len(row)} cells, but width = {width}")
    try:
        codes = np.frombuffer("".join(rows).encode("latin-1"), np.uint8).reshape(height, width)
    except UnicodeEncodeError:
        raise InputError(f"{path}: the map holds letters that are none of {letters()}") from None
    codes = codes[::-1]
    is_unknown = ~np.isin(codes, [ord(letter) for letter in LAYERS])
    if is_unknown.any():
        row, column = np.argwhere(is_unknown[::-1])[0]
        raise InputError(
            f"{path}, line {first + 1 + row}: cell {column + 1} is {rows[row][column]!r}, none of "
            f"{letters()}"
        )
    grid = RasterGrid((0.0, 0.0), 1.0)
    items = [Item(MAP, "box", partial(box, width, height, grid, str(path)))]
    for layer in ROLES:
        signs = [ord(letter) for letter, name in LAYERS.items() if name == layer]
        is_held = np.isin(codes, signs)
        if is_held.any():
            items.append(cells(layer, is_held, grid, str(path)))
    return DrawingContents(
        path, tuple(items), tuple(item.layer for item in items), None, roles=ROLES
    )


def header(lines: list[str], path: Path) -> tuple[int, int, int]:
    """Width, height, and the number of lines before the map. Raises InputError."""
    values: dict[str, str] = {}
    for number, line in enumerate(lines[:10]):
        fields = line.split()
        if fields == ["map"]:
            missing_keys = [key for key in HEADER if key not in values]
            if missing_keys:
                raise InputError(
                    f"{path} is not a map of MovingAI: no {', no '.join(missing_keys)}"
                )
            sizes = [values[key] for key in ("width", "height")]
            for key, size in zip(("width", "height"), sizes, strict=True):
                if not size.isascii() or not size.isdigit() or len(size) > 9:
                    raise InputError(f"{path}: {key} = {shorten(size)} is not a number of cells")
            return int(sizes[0]), int(sizes[1]), number + 1
        if len(fields) == 2 and fields[0] in HEADER:
            values[fields[0]] = fields[1]
        elif fields:
            break
    raise InputError(
        f"{path} is not a map of MovingAI: it begins with type, height, width and map, a line each"
    )


def letters() -> str:
    """The letters that a map may hold."""
    return " ".join(LAYERS)


def box(width: int, height: int, grid: RasterGrid, origin: str) -> list[Shape]:
    """All of the map."""
    return [area("", rings(shapely.box(0, 0, width, height), grid), origin)]
