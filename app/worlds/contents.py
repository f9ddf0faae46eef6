"""What a world holds, in numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely

from app.worlds.world_picture import footprint
from worlds.queries.boundary import boundary_points
from worlds.queries.outlines import solids
from worlds.world import World


def contents(world: World) -> dict[str, Any]:
    """Obstacles, edges of their united outlines, boundary points (in the plane), free share.

    `free` is the share of the box that is not solid on the plan, in [0, 1].
    """
    rings = shapely.get_rings(shapely.get_parts(footprint(world)))
    return {
        "size": list(world.size),
        "edges": list(world.edges),
        "obstacles": len(world.obstacles),
        "outline_edges": int(sum(shapely.get_num_points(rings) - 1)),
        "boundary_points": len(points(world)) if world.dim == 2 else 0,
        "free": free_share(world),
    }


def free_share(world: World) -> float:
    """The share of the box that is not solid on the plan, in [0, 1]."""
    corner = np.array(world.low[:2])
    floor = shapely.box(*corner, *(corner + world.size[:2]))
    return 1.0 - floor.intersection(footprint(world)).area / math.prod(world.size[:2])


def points(world: World) -> np.ndarray:
    """The boundary points of a world in the plane, (M, 2), m."""
    return boundary_points(world, [part for _, parts in solids(world, 0.0) for part in parts], 0.0)
