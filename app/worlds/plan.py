"""The plan of a world: floor, edges, obstacles, mission."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from app.worlds.colours import FLOOR, PALE, POINTS, SOLID, SOLID_EDGE
from app.worlds.footprint import footprint
from app.worlds.mission_drawing import draw_mission, reaches
from worlds.world import World

PAD = 0.03
"""Room around the box, as a share of its longest side."""
EDGE = 3.2
"""Width of a solid edge, points."""


def draw_plan(axes: Any, world: World, points: np.ndarray | None = None) -> list[Any]:
    """Draw a world from above; returns the signs of the legend."""
    from matplotlib.lines import Line2D

    signs = draw_solid(axes, world)
    if points is not None and len(points):
        axes.plot(*points.T, ".", color=POINTS, markersize=2.4, zorder=5)
        signs.append(
            Line2D([], [], marker=".", linestyle="none", color=POINTS, label="boundary point")
        )
    signs += draw_mission(axes, world)
    low, high = view(world)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    return signs


def draw_solid(axes: Any, world: World) -> list[Any]:
    """Draw floor, obstacles and edges; returns their signs in the legend."""
    from matplotlib.patches import Patch

    floor(axes, world)
    signs: list[Any] = []
    outline = footprint(world)
    if not outline.is_empty:
        fill(axes, outline, SOLID, SOLID_EDGE)
        signs.append(Patch(facecolor=SOLID, edgecolor=SOLID_EDGE, label="obstacle"))
    edges(axes, world)
    return signs + edge_signs(world)


def view(world: World) -> tuple[np.ndarray, np.ndarray]:
    """The corners of what is shown: the box, the mission, the obstacles, and a little room."""
    corners = [np.array(world.low[:2]), np.array(world.low[:2]) + world.size[:2]]
    corners += reaches(world)
    outline = footprint(world)
    if not outline.is_empty:
        corners += [np.array(outline.bounds[:2]), np.array(outline.bounds[2:])]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    room = PAD * (high - low).max()
    return low - room, high + room


def floor(axes: Any, world: World, plane: tuple[int, int] = (0, 1)) -> None:
    """The box."""
    from matplotlib.patches import Rectangle

    low, size = np.array(world.low)[list(plane)], np.array(world.size)[list(plane)]
    axes.add_patch(Rectangle(tuple(low), *size, facecolor=FLOOR, zorder=0))


def edges(axes: Any, world: World, plane: tuple[int, int] = (0, 1)) -> None:
    """The sides of the box: thick where solid, dashed where they wrap, none where open."""
    low = np.array(world.low)
    high = low + world.size
    for axis, other in (plane, plane[::-1]):
        for at in (low[axis], high[axis]):
            ends = [[at, at], [low[other], high[other]]]
            x, y = ends if axis == plane[0] else ends[::-1]
            if world.edges[axis] == "solid":
                axes.plot(x, y, color=SOLID_EDGE, linewidth=EDGE, zorder=4, clip_on=False,
                          solid_capstyle="projecting")  # fmt: skip
            elif world.edges[axis] == "wrap":
                axes.plot(x, y, color=PALE, linewidth=1.3, linestyle=(0, (5, 3)), zorder=4,
                          clip_on=False)  # fmt: skip


def edge_signs(world: World) -> list[Any]:
    """What the lines around the box are."""
    from matplotlib.lines import Line2D

    made = []
    if "solid" in world.edges:
        made.append(Line2D([], [], color=SOLID_EDGE, linewidth=EDGE, label="solid edge"))
    if "wrap" in world.edges:
        made.append(
            Line2D(
                [], [], color=PALE, linewidth=1.3, linestyle=(0, (4, 2)), label="edge that wraps"
            )
        )
    return made


def fill(axes: Any, outline: shapely.Geometry, face: Any, edge: str, order: float = 2.0) -> None:
    """Draw polygons with their holes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    for part in shapely.get_parts(outline):
        if part.geom_type != "Polygon":
            continue
        rings = [Path(ring.coords, closed=True) for ring in (part.exterior, *part.interiors)]
        axes.add_patch(
            PathPatch(
                Path.make_compound_path(*rings),
                facecolor=face,
                edgecolor=edge,
                linewidth=0.8,
                joinstyle="miter",
                zorder=order,
            )
        )
