"""What of the plan of a world is covered by something solid."""

from __future__ import annotations

import numpy as np
import shapely

from worlds.queries.outlines import outlines, spheres
from worlds.world import World

FAR = 1e9
"""Beyond all coordinates, m."""


def footprint(world: World) -> shapely.Geometry:
    """The obstacles as one area; what reaches over an edge that wraps comes in on the other."""
    balls = [
        shapely.Point(x, y).buffer(radius, quad_segs=32)
        for (x, y, _), radius in spheres(world, 0.0)
    ]
    area = shapely.union_all([*outlines(world, 0.0).values(), *balls])
    beyond = np.where(world.wraps[:2], 0.0, FAR)
    low = np.array(world.low[:2])
    return area.intersection(shapely.box(*(low - beyond), *(low + world.size[:2] + beyond)))
