"""Check whether a world is sound, and whether agents can be at given places.

What is wrong is named with its place, never repaired.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import shapely

from worlds.input_error import InputError
from worlds.mission import Mission
from worlds.queries.clearance import clearance
from worlds.world import World

LEG_STEPS = 1000
"""Places along a leg of a path that are looked at."""
START_STEPS = 24
"""Places along each axis at which a start region is searched for free space."""


class Problem(NamedTuple):
    """Something wrong with a world."""

    feature: str
    """What is wrong: an obstacle or a part of the mission."""
    place: tuple[float, ...]
    """Where, length; empty if it is nowhere in particular."""
    text: str
    """What is wrong with it, a sentence that names it."""
    severity: Literal["error", "warning"] = "error"


def demand_sound(world: World) -> None:
    """Raise InputError naming the first error in a world; warnings pass."""
    for problem in problems(world):
        if problem.severity == "error":
            raise InputError(f"{problem.text} ({world.name})")


def problems(world: World) -> list[Problem]:
    """Everything that is wrong with a world, errors in its shapes first.

    The mission is looked at where the shapes are sound.
    """
    problem_list = [
        p for number, _ in enumerate(world.obstacles) for p in shape_problems(world, number)
    ]
    if not problem_list and world.mission is not None:
        problem_list = dimension_problems(world, world.mission)
        if not problem_list:
            problem_list = start_problems(world, world.mission)
            problem_list += gate_problems(world, world.mission)
            problem_list += place_problems(world, world.mission)
            problem_list += leg_problems(world, world.mission)
    return problem_list


def shape_problems(world: World, number: int) -> list[Problem]:
    """What is wrong with the shape of an obstacle, itself or in its world."""
    obstacle = world.obstacles[number]
    feature = obstacle.label if obstacle.name else f"{obstacle.label} {number + 1}"
    problem_list = []
    for outline, bottom, top in obstacle.spans():
        place = tuple(shapely.get_coordinates(outline)[0].tolist())
        if shapely.convex_hull(outline).area == 0.0:
            problem_list.append(Problem(feature, place, f"obstacle {feature} has no area"))
        elif not outline.is_valid:
            problem_list.append(describe_defect(feature, outline))
        floor = 0.0 if bottom is None else bottom
        ceiling = world.height if top is None else top
        if world.dim == 3 and floor >= ceiling:
            text = f"obstacle {feature} has bottom {floor:g} not below its top {ceiling:g}"
            problem_list.append(Problem(feature, place, text))
    if world.dim == 2 and needs_space(obstacle):
        text = f"obstacle {feature} has three dimensions, its world has 2"
        problem_list.append(Problem(feature, (), text))
    return problem_list


def describe_defect(feature: str, outline: shapely.Polygon) -> Problem:
    """What makes a polygon unsound, in words, and where."""
    reason, _, place_text = shapely.is_valid_reason(outline).partition("[")
    place = tuple(float(number) for number in place_text.rstrip("]").split())
    descriptions = {
        "Self-intersection": "crosses itself",
        "Ring Self-intersection": "touches itself",
        "Hole lies outside shell": "has a hole outside of it",
        "Holes are nested": "has a hole within a hole",
        "Interior is disconnected": "is cut in two by its holes",
    }
    location = f" at ({', '.join(f'{number:g}' for number in place)})" if place else ""
    defect = descriptions.get(reason.strip(), f"is unsound ({reason.strip()})")
    return Problem(feature, place, f"obstacle {feature} {defect}{location}")


def needs_space(obstacle) -> bool:
    """Whether an obstacle is only defined in three dimensions."""
    if obstacle.shape == "union":
        return any(needs_space(part) for part in obstacle.parts)
    return obstacle.shape in ("sphere", "prism") or (
        obstacle.shape == "box" and len(obstacle.low) == 3
    )


def dimension_problems(world: World, mission: Mission) -> list[Problem]:
    """Parts of the mission with another number of coordinates than the world has."""
    return [
        Problem(part, (), f"{part} has {dim} coordinates, the world has {world.dim}")
        for part, dim in mission.dims().items()
        if dim != world.dim
    ]


def start_problems(world: World, mission: Mission) -> list[Problem]:
    """A start region without free space outside the obstacles."""
    start = mission.start
    if start is None or start.high is None or not world.is_solid:
        return []
    low, high = np.array(start.low), np.array(start.high)
    if len(free_places(world, low, high)):
        return []
    return [no_room("mission.start", start.low, start.high)]


def free_places(world: World, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Those of a grid of places in a box that are outside of what is solid, (n, dim)."""
    steps = (np.arange(START_STEPS) + 0.5) / START_STEPS
    grid = np.stack(np.meshgrid(*[steps] * world.dim, indexing="ij"), axis=-1)
    place = low + grid.reshape(-1, world.dim) * (high - low)
    return place[clearance(world, place) > 0.0]


def no_room(part: str, low: tuple[float, ...], high: tuple[float, ...]) -> Problem:
    """What is wrong with a region of the mission in which nobody can be."""
    text = f"{part} {spot(low)} to {spot(high)} has no room outside the obstacles"
    return Problem(part, low, text)


def gate_problems(world: World, mission: Mission) -> list[Problem]:
    """Sources and exits outside of the world or without free space; as a warning, a source that
    lies in an exit in part."""
    problem_list = []
    bottom, top = np.array(world.low), np.array(world.low) + world.size
    for number, source in enumerate(mission.sources):
        part = f"mission.sources[{number}]"
        low, high = np.array(source.low), np.array(source.high)
        is_closed = np.array([edge != "open" for edge in world.edges])
        is_beyond_box = (((low < bottom) | (high > top)) & is_closed).any()
        if is_beyond_box or (low >= top).any() or (high <= bottom).any():
            text = f"{part} {spot(source.low)} to {spot(source.high)} is outside of the world"
            problem_list.append(Problem(part, source.low, text))
        elif not len(free_places(world, low, high)):
            problem_list.append(no_room(part, source.low, source.high))
        elif any(region.overlaps(source.low, source.high) for region in mission.exits):
            text = f"{part} overlaps an exit: who enters there may leave at once"
            problem_list.append(Problem(part, source.low, text, "warning"))
    for number, region in enumerate(mission.exits):
        part = f"mission.exits[{number}]"
        begin, end = region.corners(world.low, tuple(top.tolist()))
        if not region.overlaps(world.low, tuple(top.tolist())):
            text = f"{part} {spot(begin)} to {spot(end)} is outside of the world"
            problem_list.append(Problem(part, begin, text))
        elif not region.contains(free_places(world, np.array(begin), np.array(end))).any():
            problem_list.append(no_room(part, begin, end))
    return problem_list


def place_problems(world: World, mission: Mission) -> list[Problem]:
    """Waypoints and goals inside what is solid."""
    problem_list = []
    for part, points in waypoints_by_key(mission).items():
        depth = clearance(world, np.array(points))
        for number in np.flatnonzero(depth < 0.0):
            location = (
                "beyond a solid edge" if is_beyond(world, points[number]) else "inside an obstacle"
            )
            text = f"{part}[{number}] = {spot(points[number])} is {location}"
            problem_list.append(Problem(part, tuple(points[number]), text))
    return problem_list


def is_beyond(world: World, place: tuple[float, ...]) -> bool:
    """Whether a place is outside of the box across a solid edge."""
    return any(
        edge == "solid" and not low <= at <= low + side
        for at, low, side, edge in zip(place, world.low, world.size, world.edges, strict=True)
    )


def leg_problems(world: World, mission: Mission) -> list[Problem]:
    """Legs of a path that cross an obstacle, as warnings."""
    path = mission.path
    if path is None:
        return []
    points = path.waypoints
    legs = list(zip(points, points[1:] + points[:1] * path.closed, strict=False))
    problem_list = []
    for number, (start, end) in enumerate(legs):
        share = np.linspace(0.0, 1.0, LEG_STEPS)[:, None]
        depth = clearance(world, np.array(start) + share * (np.array(end) - start))
        if depth.min() < 0.0:
            at = np.array(start) + share[depth.argmin()] * (np.array(end) - start)
            text = f"mission.path from {spot(start)} to {spot(end)} goes through an obstacle"
            place = tuple(at.tolist())
            problem_list.append(Problem(f"mission.path {number}", place, text, "warning"))
    return problem_list


def waypoints_by_key(mission: Mission) -> dict[str, tuple[tuple[float, ...], ...]]:
    """The waypoints of a mission's path and of its goal, by the key in the layout."""
    waypoints: dict[str, tuple[tuple[float, ...], ...]] = {}
    if mission.path is not None:
        waypoints["mission.path.waypoints"] = mission.path.waypoints
    if mission.goal is not None:
        waypoints["mission.goal.route"] = mission.goal.route
    return waypoints


def spot(place: tuple[float, ...]) -> str:
    """A place in words."""
    return f"({', '.join(f'{number:g}' for number in place)})"


def demand_in_box(world: World, position: np.ndarray, passing: bool = False) -> None:
    """Raise InputError for the first of the places (N, dim) beyond an edge that wraps or is solid.

    An edge that wraps does not fold what is given; beyond an open one agents may be, and beyond a
    solid one those that go through what is solid (`passing`).
    """
    for axis, edge in enumerate(world.edges):
        if edge == "open" or (edge == "solid" and passing):
            continue
        low, high = world.low[axis], world.low[axis] + world.size[axis]
        is_outside = (position[:, axis] < low) | (position[:, axis] > high)
        if edge == "wrap":
            is_outside |= position[:, axis] == high
        if is_outside.any():
            row = int(np.argmax(is_outside))
            end = ")" if edge == "wrap" else "]"
            raise InputError(
                f"position of row {row} is {position[row].tolist()}: {'xyz'[axis]} = "
                f"{position[row, axis]:g} is outside [{low:g}, {high:g}{end}, the box of "
                f"{world.name}, whose edges there are {'wrapping' if edge == 'wrap' else 'solid'}"
            )


def demand_free(world: World, position: np.ndarray) -> None:
    """Raise InputError for the first of the places (N, dim) that is inside an obstacle, naming
    it."""
    if not world.obstacles:
        return
    inside = clearance(world, position) < 0.0
    if inside.any():
        row = int(np.argmax(inside))
        raise InputError(
            f"position of row {row} is {position[row].tolist()}: that is inside "
            f"{obstacle_at(world, position[row])} of {world.name}, and agents start outside"
        )


def obstacle_at(world: World, place: np.ndarray) -> str:
    """The name of an obstacle that has a place (dim,) on its footprint, or `an obstacle`."""
    point = shapely.Point(place[:2])
    hits = [obstacle for obstacle in world.obstacles if obstacle.footprint().intersects(point)]
    return f"the obstacle {hits[0].label}" if hits else "an obstacle"
