"""The mission made of a drawing's layers of starts, goals and paths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.affinity import translate

from worlds.mission import Goal, Mission, Path, StartRegion
from worlds.queries.clearance import clearance
from worlds.readers.drawn_shapes import (
    DrawnArea,
    DrawnCircle,
    DrawnLine,
    DrawnPoint,
    Point,
    Solid,
    at,
)
from worlds.readers.read import Geometry
from worlds.readers.roles import GOAL, PATH, START
from worlds.world import World

SWITCH = 1.0
"""Distance at which a waypoint is taken where no circle says it, m."""
SLIVER = 1e-9
"""Share of a start's box that may be free outside what is drawn: a rounding error."""
Layered = Sequence[tuple[str, Solid]]


def mission_of(
    geometry: Geometry, world: World, dx: float, dy: float
) -> tuple[Mission | None, list[str]]:
    """The mission in a world that is the drawing moved by (dx, dy), and a line about each part.

    A start is used if it is one box along the axes, or is so in the space that is free; a goal if
    it is one, of which the middle is taken; a path if it is one line. What is not used is named.
    """
    free = free_space(world)
    notes: list[str] = []
    start = start_of(geometry, free, dx, dy, notes)
    goal = goal_of(geometry, free, world, dx, dy, notes)
    path = path_of(geometry, world, dx, dy, notes)
    if start is None and goal is None and path is None:
        return None, notes
    return Mission(start=start, goal=goal, path=path), notes


def free_space(world: World) -> shapely.Geometry:
    """The box without what is solid."""
    (x, y), (width, height) = world.low, world.size
    solid = shapely.union_all([one.footprint() for one in world.obstacles])
    return shapely.box(x, y, x + width, y + height).difference(solid)


def start_of(
    geometry: Geometry, free: shapely.Geometry, dx: float, dy: float, notes: list[str]
) -> StartRegion | None:
    """The start region: the box around what is drawn, if no other free space lies in it."""
    if not geometry.starts:
        return None
    where = layers(geometry.starts)
    outlines = [outline(shape) for _, shape in geometry.starts]
    drawn = shapely.union_all([translate(one, dx, dy) for one in outlines if one is not None])
    if drawn.is_empty:
        notes.append(f"{START}: {where} is not used: it holds no area")
        return None
    low_x, low_y, high_x, high_y = (round(x, geometry.digits) for x in drawn.bounds)
    box = shapely.box(low_x, low_y, high_x, high_y)
    if drawn.intersection(free).area == 0.0:
        notes.append(f"{START}: {where} is not used: all of it is solid or outside")
        return None
    if box.difference(drawn).intersection(free).area > SLIVER * box.area:
        what = "its area is" if len(outlines) == 1 else f"its {len(outlines)} areas are"
        notes.append(f"{START}: {where} is not used: {what} not one box along the axes, as the "
                     "start of a mission is")  # fmt: skip
        return None
    low, high = (low_x, low_y), (high_x, high_y)
    notes.append(f"{START}: {where} is the start of the mission, {at(low)} to {at(high)}")
    return StartRegion(low=low, high=high)


def goal_of(
    geometry: Geometry,
    free: shapely.Geometry,
    world: World,
    dx: float,
    dy: float,
    notes: list[str],
) -> Goal | None:
    """The goal: the middle of the one that is drawn, in free space."""
    if not geometry.goals:
        return None
    where = layers(geometry.goals)
    if len(geometry.goals) > 1:
        notes.append(f"{GOAL}: {where} is not used: it holds {len(geometry.goals)} goals, and a "
                     "mission has one")  # fmt: skip
        return None
    shape = geometry.goals[0][1]
    if isinstance(shape, DrawnPoint):
        place: Point | None = (shape.place[0] + dx, shape.place[1] + dy)
    else:
        found = shapely.LineString(shape.points) if isinstance(shape, DrawnLine) else outline(shape)
        place = middle(translate(found, dx, dy).intersection(free))
    if place is not None:
        place = rounded(place, geometry.digits)
    if place is None or clearance(world, np.array([place]))[0] <= 0.0:
        notes.append(f"{GOAL}: {where} is not used: all of it is solid or outside")
        return None
    notes.append(f"{GOAL}: {where} is the goal of the mission, at {at(place)}")
    return Goal(route=(place,))


def path_of(
    geometry: Geometry, world: World, dx: float, dy: float, notes: list[str]
) -> Path | None:
    """The path: the one line that is drawn, or the one waypoint; circles say the distance."""
    if not geometry.paths:
        return None
    where = layers(geometry.paths)
    lines = [shape for _, shape in geometry.paths if isinstance(shape, DrawnLine)]
    circles = [shape for _, shape in geometry.paths if isinstance(shape, DrawnCircle)]
    others = len(geometry.paths) - len(lines) - len(circles)
    if others or len(lines) > 1 or (not lines and len(circles) > 1):
        what = f"{len(lines)} lines, {len(circles)} circles and {others} other shapes"
        notes.append(f"{PATH}: {where} is not used: it holds {what}, and the path of a mission is "
                     "one line")  # fmt: skip
        return None
    points = list(lines[0].points) if lines else [circles[0].centre]
    moved = [rounded((x + dx, y + dy), geometry.digits) for x, y in points]
    for place in moved:
        if clearance(world, np.array([place]))[0] <= 0.0:
            notes.append(f"{PATH}: {where} is not used: {at(place)} is solid or outside")
            return None
    switch = min((one.radius for one in circles), default=SWITCH)
    why = "as its circles say" if circles else "which the drawing does not say"
    notes.append(f"{PATH}: {where} is the path of the mission, {len(moved)} waypoints, each taken "
                 f"at a distance of {switch:g} m, {why}")  # fmt: skip
    return Path(waypoints=tuple(moved), switch=switch)


def outline(shape: Solid) -> shapely.Geometry:
    """The area of a shape, an empty one if it has none."""
    if isinstance(shape, DrawnArea | DrawnCircle):
        return shape.obstacle(None, 0).footprint()
    return shapely.Polygon()


def middle(free: shapely.Geometry) -> Point | None:
    """The centre of an area if it lies in it, else a place that does; None of nothing."""
    if free.is_empty:
        return None
    centre = free.centroid
    inside = centre if free.distance(centre) == 0.0 else free.representative_point()
    return (inside.x, inside.y)


def rounded(place: Point, digits: int) -> Point:
    """A place without rounding errors."""
    return (round(place[0], digits), round(place[1], digits))


def layers(held: Layered) -> str:
    """The layers of shapes, each once."""
    names = dict.fromkeys(layer for layer, _ in held)
    return ("layer " if len(names) == 1 else "layers ") + ", ".join(repr(name) for name in names)
