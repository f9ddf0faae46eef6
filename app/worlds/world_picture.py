"""The picture of a world, as PNG or SVG: a plan, and in space a side view below it."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from app.figure import write_figure
from worlds.mission import Goal, Mission, StartRegion
from worlds.mission import Path as MissionPath
from worlds.number_text import counted
from worlds.queries.outlines import outlines, spheres
from worlds.world import World

# Colours and type of a drawn world.

FLOOR = "#f7f8fa"
SOLID = "#5b6673"
SOLID_EDGE = "#343c46"
INK = "#3c434b"
PALE = "#9aa3ad"
START = "#2a9d5c"
PATH = "#2166ac"
GOAL = "#c0392b"
POINTS = "#e08214"
HEIGHTS = ("#e8e4d4", "#a9c0c4", "#5b86a0", "#27496d")
"""Colours of heights in space, from the floor to the ceiling."""
LOOK = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.spines.left": False,
    "axes.spines.bottom": False,
    "axes.labelcolor": INK,
    "figure.titlesize": 11,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "flockscope",
}


# The axes of a plan: lengths at the same scale, without a frame.


def ruled(axes: Any, across: str, up: str) -> None:
    """Name the axes and give them their look."""
    from matplotlib.ticker import MaxNLocator

    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
    axes.set(aspect="equal", xlabel=f"${across}$ / m", ylabel=f"${up}$ / m")
    axes.tick_params(length=3, color=PALE, labelsize=8.5, labelcolor=INK)


# What of the plan of a world is covered by something solid.

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


# The mission of a world on its plan: start region, path of the information agents, goal.

AGENTS = 100
"""Flock for which a start region of given density is drawn."""
NUMBERED = 12
"""Most waypoints that are numbered."""


def draw_mission(axes: Any, world: World, plane: tuple[int, int] = (0, 1)) -> list[Any]:
    """Draw the mission, if there is one, as seen on two of the axes; returns signs to explain."""
    mission: Mission | None = world.mission
    plane_axes = list(plane)
    signs: list[Any] = []
    if mission and mission.start:
        signs.append(draw_start(axes, mission.start, world.dim, plane_axes))
    if mission and mission.has_gates:
        signs += draw_gates(axes, world, plane_axes)
    if mission and mission.path:
        signs.append(draw_path(axes, mission.path, plane_axes))
    if mission and mission.goal:
        signs.append(draw_goal(axes, mission.goal, mission.settle, plane_axes))
    return signs


def start_box(start: StartRegion, dim: int) -> tuple[np.ndarray, np.ndarray]:
    """The corners of the start region, for AGENTS agents where it depends on their number."""
    low = np.array(start.low)
    if start.high is not None:
        return low, np.array(start.high)
    return low, low + (AGENTS / (start.density or 1.0)) ** (1.0 / dim)


def reaches(world: World) -> list[np.ndarray]:
    """Places of the mission that a plan has to show."""
    mission = world.mission
    pieces: list[np.ndarray] = []
    if mission and mission.start:
        pieces += [corner[:2] for corner in start_box(mission.start, world.dim)]
    if mission:
        pieces += [np.array(c[:2]) for source in mission.sources for c in (source.low, source.high)]
        for region in mission.exits:
            x0, y0, x1, y1 = region.outline.bounds
            pieces += [np.array([x0, y0]), np.array([x1, y1])]
    if mission and mission.path:
        pieces += [np.array(point[:2]) for point in mission.path.waypoints]
    if mission and mission.goal:
        pieces += [np.array(point[:2]) for point in mission.goal.route]
    return pieces


def draw_start(axes: Any, start: StartRegion, dim: int, plane_axes: list[int]) -> Any:
    """The start region."""
    from matplotlib.patches import Patch, Rectangle

    low, high = start_box(start, dim)
    axes.add_patch(
        Rectangle(tuple(low[plane_axes]), *(high - low)[plane_axes],
                  facecolor=START + "30", edgecolor=START,
                  linewidth=1.2, zorder=3)
    )  # fmt: skip
    of = f" of {AGENTS} agents" if start.high is None else ""
    return Patch(facecolor=START + "30", edgecolor=START, label=f"start{of}")


def draw_gates(axes: Any, world: World, plane_axes: list[int]) -> list[Any]:
    """The sources and the exits, hatched; returns a sign for each of both kinds."""
    from matplotlib.patches import Patch, Rectangle
    from matplotlib.patches import Polygon as Outline

    mission, signs = world.mission or Mission(), []
    low, high = world.low, tuple(np.add(world.low, world.size))
    styles: dict[str, dict[str, Any]] = {
        name: {"facecolor": "none", "edgecolor": colour, "hatch": hatch, "linewidth": 1.2}
        for name, colour, hatch in (("source", START, "///"), ("exit", GOAL, "\\\\\\"))
    }
    boxes: list[tuple[str, Any, Any]] = [
        ("source", (source.low, source.high), None) for source in mission.sources
    ]
    boxes += [("exit", region.corners(low, high), region.points) for region in mission.exits]
    for name, corners, points in boxes:
        if points is not None and plane_axes == [0, 1]:
            axes.add_patch(Outline(points, zorder=3, **styles[name]))
            continue
        begin, end = (np.array(corner)[plane_axes] for corner in corners)
        axes.add_patch(Rectangle(tuple(begin), *(end - begin), zorder=3, **styles[name]))
    for name, gates in (("source", mission.sources), ("exit", mission.exits)):
        if gates:
            signs.append(Patch(label=name if len(gates) == 1 else f"{name}s", **styles[name]))
    return signs


def draw_path(axes: Any, path: MissionPath, plane_axes: list[int]) -> Any:
    """Waypoints, joined by a line, with the circles within which the next one is taken."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Circle

    points = np.array(path.waypoints)[:, plane_axes]
    line = np.vstack([points, points[:1]]) if path.closed else points
    axes.plot(*line.T, color=PATH, linewidth=1.4, linestyle=(0, (6, 2.5)), zorder=5)
    many = len(points) > NUMBERED
    for number, point in enumerate(points, start=1):
        axes.add_patch(Circle(tuple(point), path.switch, facecolor=PATH + "22", zorder=4))
        axes.plot(*point, "o", color=PATH, markersize=4 if many else 11, zorder=6)
        if not many:
            axes.annotate(
                str(number), point, color="white", fontsize=7.5, weight="bold",
                ha="center", va="center_baseline", zorder=7,
            )  # fmt: skip
    return Line2D([], [], color=PATH, marker="o", markersize=6, linestyle=(0, (4, 2)),
                  label="path of the information agents")  # fmt: skip


def draw_goal(axes: Any, goal: Goal, settle: float, plane_axes: list[int]) -> Any:
    """The goal's route and, where it begins, a star with the circle within which it is reached."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Circle

    points = np.array(goal.route)[:, plane_axes]
    if len(points) > 1:
        line = np.vstack([points, points[:1]]) if goal.closed else points
        axes.plot(*line.T, color=GOAL, linewidth=1.3, linestyle=(0, (1, 1.5)), zorder=5)
        for begin, end in pairwise(line):
            axes.annotate(
                "", 0.56 * end + 0.44 * begin, 0.5 * (begin + end), zorder=5,
                arrowprops={"arrowstyle": "-|>", "color": GOAL, "shrinkA": 0, "shrinkB": 0},
            )  # fmt: skip
    first = tuple(points[0])
    axes.add_patch(Circle(first, settle, facecolor=GOAL + "1c", edgecolor=GOAL, linewidth=0.7,
                          zorder=4))  # fmt: skip
    axes.plot(*first, "*", color=GOAL, markersize=14, markeredgecolor="white",
              markeredgewidth=0.8, zorder=7)  # fmt: skip
    label = "goal" if goal.speed == 0.0 or len(points) == 1 else f"goal, {goal.speed:g} m/s"
    return Line2D([], [], color=GOAL, marker="*", markersize=11, linestyle="none", label=label)


# The plan of a world: floor, edges, obstacles, mission.

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

    handles = []
    if "solid" in world.edges:
        handles.append(Line2D([], [], color=SOLID_EDGE, linewidth=EDGE, label="solid edge"))
    if "wrap" in world.edges:
        handles.append(
            Line2D(
                [], [], color=PALE, linewidth=1.3, linestyle=(0, (4, 2)), label="edge that wraps"
            )
        )
    return handles


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


# A world in space: its plan, coloured by height, and below it the view from the front.

LONG_IN_SPACE = 8.2
"""Inches of the longest side."""


def solids(world: World) -> list[tuple[shapely.Geometry, shapely.Geometry, float, float]]:
    """Each solid: its outline from above, from the front, its top, and its nearest y."""
    faces = []
    for obstacle in world.obstacles:
        for outline, bottom, top in obstacle.spans():
            low = world.low[2] if bottom is None else bottom
            high = world.low[2] + world.size[2] if top is None else top
            x0, y0, x1, _ = outline.bounds
            faces.append((outline, shapely.box(x0, low, x1, high), high, y0))
        faces += [round_solid(centre, radius) for centre, radius in obstacle.spheres()]
    return faces


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
    scale = LONG_IN_SPACE / max(width, deep + tall)
    figure.set_size_inches(max(scale * width + 1.8, 6.0), scale * (deep + tall) + 2.2)
    above, front = figure.subplots(2, 1, sharex=True, height_ratios=(deep, tall))
    heights = Normalize(world.low[2], world.low[2] + world.size[2])
    colour = LinearSegmentedColormap.from_list("heights", HEIGHTS)
    floor(above, world)
    faces = solids(world)
    for k, (outline, _, top, _) in enumerate(sorted(faces, key=lambda solid: solid[2])):
        fill(above, outline, colour(heights(top)), SOLID_EDGE, 2.0 + k / (len(faces) + 1))
    edges(above, world)
    signs = edge_signs(world) + draw_mission(above, world)
    far_first = sorted(faces, key=lambda solid: -solid[3])
    draw_front(front, world, [(face, colour(heights(top))) for _, face, top, _ in far_first])
    above.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    ruled(above, "x", "y")
    ruled(front, "x", "z")
    above.set_xlabel("")
    if faces:
        bar = figure.colorbar(
            ScalarMappable(heights, colour), ax=[above, front], shrink=0.6, pad=0.02, aspect=32
        )
        bar.set_label("top of a solid / m")
        bar.outline.set_visible(False)
    return signs


def draw_front(axes: Any, world: World, faces: list[tuple[shapely.Geometry, Any]]) -> None:
    """The view along +y, the nearest solid on top."""
    floor(axes, world, (0, 2))
    for k, (outline, face) in enumerate(faces):
        fill(axes, outline, face, SOLID_EDGE, 2.0 + k / (len(faces) + 1))
    edges(axes, world, (0, 2))
    draw_mission(axes, world, (0, 2))


LONG, TALL, NARROW = 8.6, 6.4, 5.6
"""Inches: the most width and height of a plan, the least width of a picture."""
AXES = ("x", "y", "z")


def draw_world(world: World, path: Path, points: np.ndarray | None = None) -> None:
    """Draw a world into a file, whose ending says PNG or SVG.

    `points` (P, 2) are the boundary points to show, if any. Raises InputError if the file cannot be
    written.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure: Any = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        if world.dim == 3:
            signs = draw_space(figure, world)
        else:
            axes = figure.subplots()
            signs = draw_plan(axes, world, points)
            width, height = np.subtract(*reversed(view(world)))
            scale = min(LONG / width, TALL / height)
            figure.set_size_inches(max(scale * width + 0.8, NARROW), scale * height + 1.5)
            ruled(axes, "x", "y")
        head(figure, world)
        if signs:
            figure.legend(
                handles=signs, loc="outside lower left", ncols=min(len(signs), 5), fontsize=9
            )
        write_figure(figure, path)


def head(figure: Any, world: World) -> None:
    """Title and, smaller, the size and the edges."""
    size = " × ".join(f"{side:g}" for side in world.size)
    edges = ", ".join(f"{a}: {edge}" for a, edge in zip(AXES, world.edges, strict=False))
    if len(set(world.edges)) == 1:
        edges = f"{world.edges[0]} edges"
    solid = len(world.obstacles)
    holds = counted(solid, "obstacle") if solid else "no obstacles"
    figure.suptitle(
        f"{world.title or world.name}\n" + f"{size} m, {edges}, {holds}",
        x=0.012,
        ha="left",
        color=SOLID_EDGE,
        linespacing=1.45,
    )
