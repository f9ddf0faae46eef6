"""The outlines of what is solid: obstacles united, with their images across wrapping edges."""

from __future__ import annotations

import itertools
import math

import numpy as np
import shapely

from worlds.input_error import InputError
from worlds.queries.arc_outlines import Solid, solids_in
from worlds.world import World

SLIT = 1e-9
"""Width (length) of a hole that is none."""
Ball = tuple[tuple[float, float, float], float]
"""Centre and radius of a sphere."""


def outlines(world: World, margin: float | None) -> dict[tuple[float, float], shapely.Geometry]:
    """The union of the obstacles' footprints for each span of heights (bottom, top).

    In two dimensions there is one span, (-inf, inf). Obstacles are seen across wrapping edges:
    images within `margin` (length) of the box are among them, none if it is None. Raises InputError
    for an outline that crosses itself.
    """
    parts: dict[tuple[float, float], list[shapely.Geometry]] = {}
    for obstacle in world.obstacles:
        for outline, bottom, top in obstacle.spans():
            if not outline.is_valid:
                reason = shapely.is_valid_reason(outline)
                raise InputError(f"obstacle {obstacle.label} of {world.name} is unsound: {reason}")
            low = 0.0 if bottom is None else bottom
            high = world.height if top is None else top
            if margin is not None and endless(world, low, high):
                low, high = -math.inf, math.inf
            for dx, dy, dz in shifts(world) if margin is not None else [(0.0, 0.0, 0.0)]:
                image = shapely.transform(outline, lambda at, by=(dx, dy): at + by)
                if not (dx or dy) or near_box(world, image.bounds, margin or 0.0):
                    span = (low + dz, high + dz) if world.dim == 3 else (-math.inf, math.inf)
                    parts.setdefault(span, []).append(image)
    return {span: without_slits(shapely.union_all(images)) for span, images in parts.items()}


def without_slits(outline: shapely.Geometry) -> shapely.Geometry:
    """An outline without holes that have no width, which rounding leaves where shapes meet."""
    parts = shapely.get_parts(outline)
    rings = [[ring for ring in part.interiors if is_wide(ring)] for part in parts]
    if sum(map(len, rings)) == sum(shapely.get_num_interior_rings(parts)):
        return outline
    made = [shapely.Polygon(part.exterior, ring) for part, ring in zip(parts, rings, strict=True)]
    return made[0] if len(made) == 1 else shapely.MultiPolygon(made)


def is_wide(ring: shapely.LinearRing) -> bool:
    """Whether there is any room in a hole."""
    return shapely.Polygon(ring).area > SLIT * ring.length


def footprints(world: World) -> dict[tuple[float, float], shapely.Geometry]:
    """The outlines without images: what there is to draw."""
    return outlines(world, None)


def spheres(world: World, margin: float) -> list[Ball]:
    """The spheres of a world in three dimensions, with their images within `margin` of the box."""
    found: list[Ball] = []
    if world.dim < 3:
        return found
    for obstacle in world.obstacles:
        for (x, y, z), r in obstacle.spheres():
            for dx, dy, dz in shifts(world):
                u, v = x + dx, y + dy
                if not (dx or dy) or near_box(world, (u - r, v - r, u + r, v + r), margin):
                    found.append(((u, v, z + dz), r))
    return found


def circles(world: World, margin: float) -> np.ndarray:
    """Circles that outlines have arcs of: x, y, radius, (C, 3), with images as in `outlines`."""
    found = {
        (x + dx, y + dy, r)
        for obstacle in world.obstacles
        for (x, y), r in obstacle.circles()
        for dx, dy, _ in shifts(world)
        if not (dx or dy)
        or near_box(world, (x + dx - r, y + dy - r, x + dx + r, y + dy + r), margin)
    }
    return np.array(sorted(found)).reshape(-1, 3)


def solids(world: World, margin: float) -> list[tuple[tuple[float, float], list[Solid]]]:
    """The connected outlines of each span of heights, with exact arcs, as in `outlines`."""
    round_ = circles(world, margin)
    return [(span, solids_in(one, round_)) for span, one in outlines(world, margin).items()]


def endless(world: World, bottom: float, top: float) -> bool:
    """Whether a span of heights goes on for ever, because z wraps and it fills the box."""
    return world.dim == 3 and bool(world.wraps[2]) and top - bottom >= world.size[2]


def shifts(world: World) -> list[tuple[float, float, float]]:
    """The vectors from a place to its images, zero first; one back and forth per wrapping axis."""
    steps = [(0.0, -side, side) if wraps else (0.0,) for side, wraps in sides(world)]
    return [(x, y, z) for x, y, z in itertools.product(*steps)]


def sides(world: World) -> list[tuple[float, bool]]:
    """Length of each of three sides of the box, and whether it wraps."""
    found = list(zip(world.size, world.wraps.tolist(), strict=True))
    return [*found, (0.0, False)][:3]


def near_box(world: World, bounds: tuple[float, ...], margin: float) -> bool:
    """Whether bounds on the plan (x, y, x, y) come within a margin of the box."""
    low = np.array(world.low[:2]) - margin
    high = np.array(world.low[:2]) + world.size[:2] + margin
    return bool((np.array(bounds[:2]) <= high).all() and (np.array(bounds[2:]) >= low).all())
