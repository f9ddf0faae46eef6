"""Makes a world of a drawing: its box, its obstacles and what is outside the walkable area."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import shapely

from worlds.checks import demand_sound
from worlds.input_error import InputError
from worlds.obstacles import Obstacle, obstacle
from worlds.readers.drawn_mission import mission_of
from worlds.readers.read import Geometry
from worlds.world import World, edges_of

MARGIN = 0.1
"""Room around obstacles without a walkable area, as a share of their longest side."""
OUTSIDE, HOLE = "outside", "hole"
"""Names of the obstacles that fill what is not walkable."""


def world_around(
    geometry: Geometry,
    edges: str | Sequence[str] = "solid",
    margin: float | None = None,
    to_origin: bool = False,
) -> World:
    """A 2-D world with the obstacles and the mission of a drawing.

    With a walkable area the box is its bounds, and all of the box that is not walkable is solid.
    Without one the box is the bounds of the obstacles and `margin` (m) around them, by default a
    tenth of their longest side. `edges` are one word for all sides or one per axis. `to_origin`
    moves everything so that the box begins at (0, 0), which edges that wrap need. Raises
    InputError.
    """
    return world_and_notes(geometry, edges, margin, to_origin)[0]


def world_and_notes(
    geometry: Geometry,
    edges: str | Sequence[str] = "solid",
    margin: float | None = None,
    to_origin: bool = False,
) -> tuple[World, tuple[str, ...]]:
    """The same, and a line about each part of a mission: what it is made of, or why it is not."""
    both = edges_of(edges, 2, geometry.file)
    obstacles = list(geometry.obstacles)
    if geometry.walkable is not None:
        if margin is not None:
            raise InputError(f"margin = {margin:g} m cannot be given with a walkable area, whose "
                          "bounds are the box")  # fmt: skip
        bounds = geometry.walkable.bounds
        obstacles += outside(geometry.walkable, geometry.digits)
    else:
        bounds = grown(geometry, margin)
    low_x, low_y, high_x, high_y = (round(x, geometry.digits) for x in bounds)
    size = (round(high_x - low_x, geometry.digits), round(high_y - low_y, geometry.digits))
    dx, dy = (-low_x, -low_y) if to_origin else (0.0, 0.0)
    if to_origin:
        obstacles = [rounded_shift(one, dx, dy, geometry.digits) for one in obstacles]
        low_x, low_y = 0.0, 0.0
    for axis, edge, start in zip("xy", both, (low_x, low_y), strict=True):
        if edge == "wrap" and start != 0.0:
            raise InputError(
                f"edges that wrap need a box that begins at 0, and along {axis} it begins at "
                f"{start:g} ({geometry.file}): move it to the origin (--to-origin)"
            )
    made = World(
        name=geometry.file.rpartition(".")[0],
        size=size,
        edges=both,
        title=f"Read from {geometry.file}",
        low=(low_x, low_y),
        obstacles=tuple(obstacles),
        source=geometry.file,
    )
    if not (geometry.starts or geometry.goals or geometry.paths):
        return made, ()
    demand_sound(made)
    mission, notes = mission_of(geometry, made, dx, dy)
    return replace(made, mission=mission), tuple(notes)


def outside(walkable: shapely.Geometry, digits: int) -> list[Obstacle]:
    """What of the bounds of the walkable area is not walkable: outside of it, and its holes."""
    box = shapely.box(*walkable.bounds)
    rest = box.difference(walkable)
    found: list[Obstacle] = []
    count = {OUTSIDE: 0, HOLE: 0}
    for piece in () if rest.is_empty else shapely.get_parts(rest):
        rings = [
            [(round(x, digits), round(y, digits)) for x, y in ring.coords[:-1]]
            for ring in (piece.exterior, *piece.interiors)
        ]
        kind = OUTSIDE if piece.intersects(box.exterior) else HOLE
        count[kind] += 1
        name = f"{kind} {count[kind]}"
        values = {"shape": "polygon", "name": name, "points": rings[0], "holes": rings[1:]}
        found.append(obstacle(values))
    return found


def rounded_shift(one: Obstacle, dx: float, dy: float, digits: int) -> Obstacle:
    """An obstacle moved, without the rounding errors of the sum."""
    return obstacle(rounded(one.moved(dx, dy).model_dump(exclude_none=True), digits))


def rounded(value: Any, digits: int) -> Any:
    """A value with all numbers in it rounded."""
    if isinstance(value, float):
        return round(value, digits)
    if isinstance(value, dict):
        return {key: rounded(one, digits) for key, one in value.items()}
    return [rounded(one, digits) for one in value] if isinstance(value, list | tuple) else value


def grown(geometry: Geometry, margin: float | None) -> tuple[float, ...]:
    """The bounds of the obstacles with a margin around them. Raises InputError."""
    around = shapely.total_bounds([one.footprint() for one in geometry.obstacles])
    side = max(around[2] - around[0], around[3] - around[1])
    margin = MARGIN * side if margin is None else margin
    if not (margin >= 0.0 and math.isfinite(margin)):
        raise InputError(f"margin = {margin:g} m is not a length >= 0")
    return (*(float(x) for x in around[:2] - margin), *(float(x) for x in around[2:] + margin))
