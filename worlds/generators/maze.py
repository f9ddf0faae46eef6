"""A maze, with the way through it as the path of the information agents.

Source: recursive backtracker, J. Buck, "Mazes for Programmers", 2015, chapter 5.
"""

from __future__ import annotations

import numpy as np

from worlds.generators.world_generator import (
    GeneratedContents,
    GeneratorParameters,
    WorldGenerator,
    box_text,
    length,
    share,
)
from worlds.input_error import InputError
from worlds.mission import Mission, mission
from worlds.obstacles import Obstacle, Wall

Cell = tuple[int, int]
AROUND: tuple[Cell, ...] = ((1, 0), (-1, 0), (0, 1), (0, -1))
MOST = 40_000
"""Most cells of a maze."""


class MazeParameters(GeneratorParameters):
    """A maze."""

    cell: float = length(5.0, "least side of a cell, from the middle of a wall to the next")
    thickness: float = length(0.5, "thickness of the walls")
    loops: float = share(0.0, "share of the inner walls that are taken away, which makes loops")


def make_maze(
    rng: np.random.Generator, low: np.ndarray, size: np.ndarray, p: MazeParameters
) -> GeneratedContents:
    """Draw a maze from the lower left cell to the upper right one.

    As many cells as fit share the box evenly. Walls that touch the box end in it: without loops
    every cell is reached from every other by exactly one way. Raises InputError.
    """
    counts = np.floor(size / p.cell * (1.0 + 1e-12)).astype(int)
    nx, ny = counts.tolist()
    if min(nx, ny) < 2 or nx * ny > MOST:
        raise InputError(
            f"cell = {p.cell:g} m makes {nx} x {ny} cells of {box_text(size)}: at least 2 x 2 and "
            f"at most {MOST} cells are possible"
        )
    pitch = size / counts
    if p.thickness >= 0.5 * pitch.min():
        raise InputError(
            f"thickness = {p.thickness:g} m is not less than half a cell ({pitch.min() / 2:g} m)"
        )
    doors = carve_doors(rng, nx, ny)
    route = route_through(doors, (0, 0), (nx - 1, ny - 1))
    doors |= {door for door in inner_walls(nx, ny, doors) if rng.random() < p.loops}
    walls = [
        maze_wall(start, end, low, pitch, counts, p.thickness)
        for start, end in runs(inner_walls(nx, ny, doors))
    ]
    return GeneratedContents(walls, mission_along(route, low, pitch, p.thickness))


def carve_doors(rng: np.random.Generator, nx: int, ny: int) -> set[tuple[Cell, Cell]]:
    """The doors of a perfect maze of nx x ny cells, each as the lower cell and the upper one."""
    doors: set[tuple[Cell, Cell]] = set()
    visited, trail = {(0, 0)}, [(0, 0)]
    while trail:
        x, y = trail[-1]
        unvisited = [
            (x + dx, y + dy)
            for dx, dy in AROUND
            if 0 <= x + dx < nx and 0 <= y + dy < ny and (x + dx, y + dy) not in visited
        ]
        if not unvisited:
            trail.pop()
            continue
        cell = unvisited[int(rng.integers(len(unvisited)))]
        doors.add((min(trail[-1], cell), max(trail[-1], cell)))
        visited.add(cell)
        trail.append(cell)
    return doors


def route_through(doors: set[tuple[Cell, Cell]], start: Cell, end: Cell) -> list[Cell]:
    """The cells from start to end."""
    previous: dict[Cell, Cell] = {start: start}
    frontier = [start]
    while end not in previous:
        x, y = frontier.pop()
        for dx, dy in AROUND:
            cell = (x + dx, y + dy)
            if cell not in previous and (min((x, y), cell), max((x, y), cell)) in doors:
                previous[cell] = (x, y)
                frontier.append(cell)
    route = [end]
    while route[-1] != start:
        route.append(previous[route[-1]])
    return route[::-1]


def inner_walls(nx: int, ny: int, doors: set[tuple[Cell, Cell]]) -> list[tuple[Cell, Cell]]:
    """The pairs of neighbouring cells with a wall between them, in a fixed order."""
    pairs = [((x, y), (x + 1, y)) for x in range(nx - 1) for y in range(ny)]
    pairs += [((x, y), (x, y + 1)) for y in range(ny - 1) for x in range(nx)]
    return [pair for pair in pairs if pair not in doors]


def runs(walls: list[tuple[Cell, Cell]]) -> list[tuple[Cell, Cell]]:
    """The walls as straight lines from a corner of cells to another, each as long as it goes."""
    wall_runs: list[tuple[Cell, Cell]] = []
    for (x, y), (x1, _) in walls:
        upright = x1 > x
        start = (x + 1, y) if upright else (x, y + 1)
        end = (x + 1, y + 1)
        if (
            wall_runs
            and wall_runs[-1][1] == start
            and (wall_runs[-1][0][0] == end[0] if upright else wall_runs[-1][0][1] == end[1])
        ):
            wall_runs[-1] = (wall_runs[-1][0], end)
        else:
            wall_runs.append((start, end))
    return wall_runs


def maze_wall(
    start: Cell, end: Cell, low: np.ndarray, pitch: np.ndarray, counts: np.ndarray, thick: float
) -> Obstacle:
    """A wall between two corners of cells; inside the box it is half a thickness longer."""
    ends = np.array([start, end])
    along = np.sign(ends[1] - ends[0]) * 0.5 * thick
    places = low + ends * pitch
    places[0] -= np.where(ends[0] > 0, along, 0.0)
    places[1] += np.where(ends[1] < counts, along, 0.0)
    begin, finish = places.tolist()
    return Wall(start=tuple(begin), end=tuple(finish), thickness=thick)


def mission_along(
    route: list[Cell], low: np.ndarray, pitch: np.ndarray, thickness: float
) -> Mission:
    """The mission: start in the first cell, path along the way, goal in the last cell."""
    turns = [
        cell
        for previous, cell, following in zip(route, route[1:], route[2:], strict=False)
        if following[0] - cell[0] != cell[0] - previous[0]
    ]
    middles = [((np.array(cell) + 0.5) * pitch + low).tolist() for cell in [*turns, route[-1]]]
    begin, end = low + 0.5 * thickness, low + pitch - 0.5 * thickness
    return mission(
        {
            "start": {"low": begin.tolist(), "high": end.tolist()},
            "path": {"waypoints": middles, "switch": float(0.25 * pitch.min())},
            "goal": {"route": [middles[-1]]},
        }
    )


MAZE = WorldGenerator("maze", "A maze with the way through it", MazeParameters, make_maze)
