"""Make a world of a drawing: its box, its obstacles and what is outside the walkable area."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
from shapely.affinity import translate

from worlds.checks import demand_sound
from worlds.input_error import InputError
from worlds.mission import Goal, Mission, Path, StartRegion
from worlds.obstacles import Obstacle, obstacle
from worlds.queries.clearance import clearance
from worlds.readers.drawn_shapes import (
    DrawnArea,
    DrawnCircle,
    DrawnLine,
    DrawnPoint,
    Point,
    Solid,
    format_place,
)
from worlds.readers.read import Geometry
from worlds.readers.roles import GOAL, PATH, START
from worlds.world import World, edges_of

# The mission made of a drawing's layers of starts, goals and paths.

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
    solid = shapely.union_all([obstacle.footprint() for obstacle in world.obstacles])
    return shapely.box(x, y, x + width, y + height).difference(solid)


def start_of(
    geometry: Geometry, free: shapely.Geometry, dx: float, dy: float, notes: list[str]
) -> StartRegion | None:
    """The start region: the box around what is drawn, if no other free space lies in it."""
    if not geometry.starts:
        return None
    layer_text = layers(geometry.starts)
    outlines = [outline(shape) for _, shape in geometry.starts]
    drawn_area = shapely.union_all(
        [translate(area, dx, dy) for area in outlines if area is not None]
    )
    if drawn_area.is_empty:
        notes.append(f"{START}: {layer_text} is not used: it holds no area")
        return None
    low_x, low_y, high_x, high_y = (round(x, geometry.digits) for x in drawn_area.bounds)
    box = shapely.box(low_x, low_y, high_x, high_y)
    if drawn_area.intersection(free).area == 0.0:
        notes.append(f"{START}: {layer_text} is not used: all of it is solid or outside")
        return None
    if box.difference(drawn_area).intersection(free).area > SLIVER * box.area:
        subject = "its area is" if len(outlines) == 1 else f"its {len(outlines)} areas are"
        notes.append(
            f"{START}: {layer_text} is not used: {subject} not one box along the axes, as "
            "the start of a mission is"
        )
        return None
    low, high = (low_x, low_y), (high_x, high_y)
    notes.append(
        f"{START}: {layer_text} is the start of the mission, {format_place(low)} to "
        f"{format_place(high)}"
    )
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
    layer_text = layers(geometry.goals)
    if len(geometry.goals) > 1:
        notes.append(
            f"{GOAL}: {layer_text} is not used: it holds {len(geometry.goals)} goals, and "
            "a mission has one"
        )
        return None
    shape = geometry.goals[0][1]
    if isinstance(shape, DrawnPoint):
        place: Point | None = (shape.place[0] + dx, shape.place[1] + dy)
    else:
        drawn_shape = (
            shapely.LineString(shape.points) if isinstance(shape, DrawnLine) else outline(shape)
        )
        place = middle(translate(drawn_shape, dx, dy).intersection(free))
    if place is not None:
        place = round_place(place, geometry.digits)
    if place is None or clearance(world, np.array([place]))[0] <= 0.0:
        notes.append(f"{GOAL}: {layer_text} is not used: all of it is solid or outside")
        return None
    notes.append(f"{GOAL}: {layer_text} is the goal of the mission, at {format_place(place)}")
    return Goal(route=(place,))


def path_of(
    geometry: Geometry, world: World, dx: float, dy: float, notes: list[str]
) -> Path | None:
    """The path: the one line that is drawn, or the one waypoint; circles say the distance."""
    if not geometry.paths:
        return None
    layer_text = layers(geometry.paths)
    lines = [shape for _, shape in geometry.paths if isinstance(shape, DrawnLine)]
    circles = [shape for _, shape in geometry.paths if isinstance(shape, DrawnCircle)]
    other_count = len(geometry.paths) - len(lines) - len(circles)
    if other_count or len(lines) > 1 or (not lines and len(circles) > 1):
        counts_text = f"{len(lines)} lines, {len(circles)} circles and {other_count} other shapes"
        notes.append(
            f"{PATH}: {layer_text} is not used: it holds {counts_text}, and the path of a "
            "mission is one line"
        )
        return None
    points = list(lines[0].points) if lines else [circles[0].centre]
    waypoints = [round_place((x + dx, y + dy), geometry.digits) for x, y in points]
    for place in waypoints:
        if clearance(world, np.array([place]))[0] <= 0.0:
            notes.append(
                f"{PATH}: {layer_text} is not used: {format_place(place)} is solid or outside"
            )
            return None
    switch = min((circle.radius for circle in circles), default=SWITCH)
    reason = "as its circles say" if circles else "which the drawing does not say"
    notes.append(
        f"{PATH}: {layer_text} is the path of the mission, {len(waypoints)} waypoints, each "
        f"taken at a distance of {switch:g} m, {reason}"
    )
    return Path(waypoints=tuple(waypoints), switch=switch)


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


def round_place(place: Point, digits: int) -> Point:
    """A place without rounding errors."""
    return (round(place[0], digits), round(place[1], digits))


def layers(layered: Layered) -> str:
    """The layers of shapes, each once."""
    names = dict.fromkeys(layer for layer, _ in layered)
    return ("layer " if len(names) == 1 else "layers ") + ", ".join(repr(name) for name in names)


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
    edge_kinds = edges_of(edges, 2, geometry.file)
    obstacles = list(geometry.obstacles)
    if geometry.walkable is not None:
        if margin is not None:
            raise InputError(f"margin = {margin:g} m cannot be given with a walkable area, whose "
                          "bounds are the box")  # fmt: skip
        bounds = geometry.walkable.bounds
        obstacles += outside(geometry.walkable, geometry.digits)
    else:
        bounds = grow_box(geometry, margin)
    low_x, low_y, high_x, high_y = (round(x, geometry.digits) for x in bounds)
    size = (round(high_x - low_x, geometry.digits), round(high_y - low_y, geometry.digits))
    dx, dy = (-low_x, -low_y) if to_origin else (0.0, 0.0)
    if to_origin:
        obstacles = [shift_and_round(obstacle, dx, dy, geometry.digits) for obstacle in obstacles]
        low_x, low_y = 0.0, 0.0
    for axis, edge, start in zip("xy", edge_kinds, (low_x, low_y), strict=True):
        if edge == "wrap" and start != 0.0:
            raise InputError(
                f"edges that wrap need a box that begins at 0, and along {axis} it begins at "
                f"{start:g} ({geometry.file}): move it to the origin (--to-origin)"
            )
    built_world = World(
        name=geometry.file.rpartition(".")[0],
        size=size,
        edges=edge_kinds,
        title=f"Read from {geometry.file}",
        low=(low_x, low_y),
        obstacles=tuple(obstacles),
        source=geometry.file,
    )
    if not (geometry.starts or geometry.goals or geometry.paths):
        return built_world, ()
    demand_sound(built_world)
    mission, notes = mission_of(geometry, built_world, dx, dy)
    return replace(built_world, mission=mission), tuple(notes)


def outside(walkable: shapely.Geometry, digits: int) -> list[Obstacle]:
    """What of the bounds of the walkable area is not walkable: outside of it, and its holes."""
    box = shapely.box(*walkable.bounds)
    unwalkable = box.difference(walkable)
    obstacles: list[Obstacle] = []
    count = {OUTSIDE: 0, HOLE: 0}
    for piece in () if unwalkable.is_empty else shapely.get_parts(unwalkable):
        rings = [
            [(round(x, digits), round(y, digits)) for x, y in ring.coords[:-1]]
            for ring in (piece.exterior, *piece.interiors)
        ]
        kind = OUTSIDE if piece.intersects(box.exterior) else HOLE
        count[kind] += 1
        name = f"{kind} {count[kind]}"
        values = {"shape": "polygon", "name": name, "points": rings[0], "holes": rings[1:]}
        obstacles.append(obstacle(values))
    return obstacles


def shift_and_round(solid: Obstacle, dx: float, dy: float, digits: int) -> Obstacle:
    """An obstacle moved, without the rounding errors of the sum."""
    return obstacle(round_numbers(solid.moved(dx, dy).model_dump(exclude_none=True), digits))


def round_numbers(value: Any, digits: int) -> Any:
    """A value with all numbers in it rounded."""
    if isinstance(value, float):
        return round(value, digits)
    if isinstance(value, dict):
        return {key: round_numbers(item, digits) for key, item in value.items()}
    return (
        [round_numbers(entry, digits) for entry in value]
        if isinstance(value, list | tuple)
        else value
    )


def grow_box(geometry: Geometry, margin: float | None) -> tuple[float, ...]:
    """The bounds of the obstacles with a margin around them. Raises InputError."""
    bounds = shapely.total_bounds([obstacle.footprint() for obstacle in geometry.obstacles])
    side = max(bounds[2] - bounds[0], bounds[3] - bounds[1])
    margin = MARGIN * side if margin is None else margin
    if not (margin >= 0.0 and math.isfinite(margin)):
        raise InputError(f"margin = {margin:g} m is not a length >= 0")
    return (*(float(x) for x in bounds[:2] - margin), *(float(x) for x in bounds[2:] + margin))
