"""A world in space: its plan, coloured by height, and below it the view from the front."""

from __future__ import annotations

from typing import Any

import shapely

from app.worlds.colours import HEIGHTS, SOLID_EDGE
from app.worlds.mission_drawing import draw_mission
from app.worlds.plan import edge_signs, edges, fill, floor, view
from app.worlds.rulers import ruled
from worlds.world import World

LONG = 8.2
"""Inches of the longest side."""


def solids(world: World) -> list[tuple[shapely.Geometry, shapely.Geometry, float, float]]:
    """Each solid: its outline from above, from the front, its top, and its nearest y."""
    found = []
    for one in world.obstacles:
        for outline, bottom, top in one.spans():
            low = world.low[2] if bottom is None else bottom
            high = world.low[2] + world.size[2] if top is None else top
            x0, y0, x1, _ = outline.bounds
            found.append((outline, shapely.box(x0, low, x1, high), high, y0))
        found += [round_solid(centre, radius) for centre, radius in one.spheres()]
    return found


def round_solid(
    centre: tuple[float, float, float], radius: float
) -> tuple[shapely.Geometry, shapely.Geometry, float, float]:
    """A sphere as a solid."""
    x, y, z = centre
    above, front = (shapely.Point(x, at).buffer(radius, quad_segs=32) for at in (y, z))
    return above, front, z + radius, y - radius


def draw_space(figure: Any, world: World) -> list[Any]:
    """Draw both views; returns the signs of the legend."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    low, high = view(world)
    tall = world.size[2] * 1.06
    width, deep = high - low
    scale = LONG / max(width, deep + tall)
    figure.set_size_inches(max(scale * width + 1.8, 6.0), scale * (deep + tall) + 2.2)
    above, front = figure.subplots(2, 1, sharex=True, height_ratios=(deep, tall))
    heights = Normalize(world.low[2], world.low[2] + world.size[2])
    colour = LinearSegmentedColormap.from_list("heights", HEIGHTS)
    floor(above, world)
    found = solids(world)
    for k, (outline, _, top, _) in enumerate(sorted(found, key=lambda solid: solid[2])):
        fill(above, outline, colour(heights(top)), SOLID_EDGE, 2.0 + k / (len(found) + 1))
    edges(above, world)
    signs = edge_signs(world) + draw_mission(above, world)
    far_first = sorted(found, key=lambda solid: -solid[3])
    draw_front(front, world, [(face, colour(heights(top))) for _, face, top, _ in far_first])
    above.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    ruled(above, "x", "y")
    ruled(front, "x", "z")
    above.set_xlabel("")
    if found:
        bar = figure.colorbar(
            ScalarMappable(heights, colour), ax=[above, front], shrink=0.6, pad=0.02, aspect=32
        )
        bar.set_label("top of a solid / m")
        bar.outline.set_visible(False)
    return signs


def draw_front(axes: Any, world: World, found: list[tuple[shapely.Geometry, Any]]) -> None:
    """The view along +y, the nearest solid on top."""
    floor(axes, world, (0, 2))
    for k, (outline, face) in enumerate(found):
        fill(axes, outline, face, SOLID_EDGE, 2.0 + k / (len(found) + 1))
    edges(axes, world, (0, 2))
    draw_mission(axes, world, (0, 2))
