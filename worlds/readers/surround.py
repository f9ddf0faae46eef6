"""A world made of a drawing: its box, its obstacles and what is outside the walkable area."""

from __future__ import annotations

import math
from collections.abc import Sequence

import shapely

from worlds.layout import chosen_edges
from worlds.obstacles import Obstacle, obstacle
from worlds.readers.read import Geometry
from worlds.refusal import Refusal
from worlds.world import World

MARGIN = 0.1
"""Room around obstacles without a walkable area, as a share of their longest side."""
OUTSIDE = "outside"
"""Name of the obstacles that fill what is not walkable."""


def world_around(
    geometry: Geometry,
    edges: str | Sequence[str] = "solid",
    margin: float | None = None,
    to_origin: bool = False,
) -> World:
    """A 2-D world with the obstacles of a drawing.

    With a walkable area the box is its bounds, and all of the box that is not walkable is solid.
    Without one the box is the bounds of the obstacles and `margin` (m) around them, by default a
    tenth of their longest side. `edges` are one word for all sides or one per axis. `to_origin`
    moves everything so that the box begins at (0, 0), which edges that wrap need. Raises Refusal.
    """
    both = chosen_edges({"edges": edges}, 2, False, geometry.file)
    obstacles = list(geometry.obstacles)
    if geometry.walkable is not None:
        if margin is not None:
            raise Refusal(f"margin = {margin:g} m cannot be given with a walkable area, whose "
                          "bounds are the box")  # fmt: skip
        bounds = geometry.walkable.bounds
        obstacles += outside(geometry.walkable)
    else:
        bounds = grown(geometry, margin)
    low, high = bounds[:2], bounds[2:]
    if to_origin:
        obstacles = [one.moved(-low[0], -low[1]) for one in obstacles]
        low, high = (0.0, 0.0), (high[0] - low[0], high[1] - low[1])
    for axis, edge, start in zip("xy", both, low, strict=False):
        if edge == "wrap" and start != 0.0:
            raise Refusal(
                f"edges that wrap need a box that begins at 0, and along {axis} it begins at "
                f"{start:g} ({geometry.file}): move it to the origin (--to-origin)"
            )
    return World(
        name=geometry.file.rpartition(".")[0],
        size=(high[0] - low[0], high[1] - low[1]),
        edges=both,
        title=f"Read from {geometry.file}",
        low=tuple(low),
        obstacles=tuple(obstacles),
        source=geometry.file,
    )


def outside(walkable: shapely.Geometry) -> list[Obstacle]:
    """What of the bounds of the walkable area is not walkable."""
    rest = shapely.box(*walkable.bounds).difference(walkable)
    found: list[Obstacle] = []
    for piece in () if rest.is_empty else shapely.get_parts(rest):
        rings = [
            [(x, y) for x, y in ring.coords[:-1]] for ring in (piece.exterior, *piece.interiors)
        ]
        name = f"{OUTSIDE} {len(found) + 1}"
        values = {"shape": "polygon", "name": name, "points": rings[0], "holes": rings[1:]}
        found.append(obstacle(values))
    return found


def grown(geometry: Geometry, margin: float | None) -> tuple[float, ...]:
    """The bounds of the obstacles with room around them. Raises Refusal."""
    around = shapely.total_bounds([one.footprint() for one in geometry.obstacles])
    side = max(around[2] - around[0], around[3] - around[1])
    room = MARGIN * side if margin is None else margin
    if not (room >= 0.0 and math.isfinite(room)):
        raise Refusal(f"margin = {room:g} m is not a length >= 0")
    return (*(float(x) for x in around[:2] - room), *(float(x) for x in around[2:] + room))
