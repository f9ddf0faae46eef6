"""Footprints in which circles have so many corners that they are round, as shapely has them."""

import numpy as np
import shapely
from hypothesis import assume

from worlds.obstacles import Disc, Ring, Union
from worlds.queries.outlines import circles, solids, sources

CORNERS = 2**13
SHALLOW = 1.0 / 32.0
"""Sine of the least angle at which circles are taken to meet: there their corner is off by what
the circles are, divided by the sine."""


def disc(centre, radius, corners):
    angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    return shapely.Polygon(
        np.array(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    )


def footprint(one, corners):
    """The outline of an obstacle, round where it is round."""
    if isinstance(one, Disc):
        return disc(one.centre, one.radius, corners)
    if isinstance(one, Ring):
        return disc(one.centre, one.radius, corners).difference(
            disc(one.centre, one.radius - one.width, corners)
        )
    if isinstance(one, Union):
        return shapely.union_all([footprint(part, corners) for part in one.parts])
    return one.footprint()


GRID = 1e-10
"""Rounding of places in it, length."""


def united(obstacles, corners=CORNERS):
    """The union of obstacles on the plan, and how far it may be from exact, length.

    What fits together exactly leaves no gap: rounding would, of 1e-15.
    """
    radii = [r for one in obstacles for _, r in one.circles()]
    slack = max(radii, default=0.0) * (1.0 - np.cos(np.pi / corners))
    slack /= SHALLOW
    shapes = [footprint(one, corners) for one in obstacles]
    return shapely.union_all(shapes, grid_size=GRID), slack + GRID


def demand_clear(world):
    """Leave out a scene in which a corner is on a side: where it is then is up to rounding."""
    solid = shapely.union_all([footprint(one, 64) for one in world.obstacles])
    assume(shapely.get_num_coordinates(solid.simplify(GRID)) == shapely.get_num_coordinates(solid))


def demand_round(world, margin):
    """Leave out a scene in which an outline is kept as a polygon: a corner just under an arc."""
    round_ = circles(world, margin)
    for _, parts in solids(world, margin):
        for one in parts:
            for ring in one.rings:
                assume(ring.radius.any() or (sources(ring.start, round_) < 0).all())
