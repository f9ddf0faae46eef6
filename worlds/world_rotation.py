"""Turn a flat scene and let its outlines begin elsewhere: no result may depend on either."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import shapely

from worlds.input_error import InputError
from worlds.mission import Mission
from worlds.obstacles import Disc, Obstacle, Polygon, Ring, Union
from worlds.shape import turn
from worlds.world import World

Move = Callable[[np.ndarray], np.ndarray]
"""Places (n, 2) to where they are after a turn."""


def rotate_places(places: np.ndarray, degrees: float, about: np.ndarray) -> np.ndarray:
    """Places (n, 2) turned anticlockwise about a place (2,)."""
    c, s = turn(degrees)
    return (places - about) @ np.array([[c, s], [-s, c]]) + about


def rotate_world(world: World, degrees: float, rng: np.random.Generator | None = None) -> World:
    """The world with all that is in it turned anticlockwise about the middle of its box.

    With `rng` outlines begin at a random one of their corners, go round either way, and obstacles
    come in any order. The box itself stays, so all of its edges are open; the start region, a box
    too, is left out. Raises InputError for a world in space, with another edge or random obstacles.
    """
    if world.dim != 2 or set(world.edges) != {"open"} or world.random is not None:
        raise InputError(
            f"world {world.name} cannot be turned: only a flat one with open edges can, whose "
            "obstacles are drawn"
        )
    middle = np.array(world.low) + 0.5 * np.array(world.size)

    def rotate(places: np.ndarray) -> np.ndarray:
        return rotate_places(np.asarray(places, float), degrees, middle)

    obstacles = [
        rotate_obstacle(obstacle, rotate, rng) for obstacle in shuffle(world.obstacles, rng)
    ]
    mission = world.mission and rotate_mission(world.mission, rotate)
    name = f"{world.name}, turned by {degrees:g}°"
    return replace(world, name=name, obstacles=tuple(obstacles), mission=mission)


def rotate_mission(mission: Mission, move: Move) -> Mission:
    """The mission with its path and its goal turned, without its start region."""
    path, goal = mission.path, mission.goal
    if path is not None:
        path = path.model_copy(update={"waypoints": points_of(move(np.array(path.waypoints)))})
    if goal is not None:
        goal = goal.model_copy(update={"route": points_of(move(np.array(goal.route)))})
    return mission.model_copy(update={"start": None, "path": path, "goal": goal})


def rotate_obstacle(obstacle: Obstacle, move: Move, rng: np.random.Generator | None) -> Obstacle:
    """An obstacle turned; one with straight edges is a polygon then."""
    if isinstance(obstacle, Union):
        parts = [rotate_obstacle(part, move, rng) for part in shuffle(obstacle.parts, rng)]
        return obstacle.model_copy(update={"parts": tuple(parts)})
    if isinstance(obstacle, Disc | Ring):
        (centre,) = points_of(move(np.array([obstacle.centre])))
        return obstacle.model_copy(update={"centre": centre})
    if isinstance(obstacle, Polygon):
        rings = [np.array(ring) for ring in (obstacle.points, *obstacle.holes)]
    else:
        rings = [shapely.get_coordinates(obstacle.footprint())[:-1]]
    points, *holes = [points_of(reorder_ring(move(ring), rng)) for ring in rings]
    return Polygon(name=obstacle.name, points=points, holes=tuple(holes))


def reorder_ring(ring: np.ndarray, rng: np.random.Generator | None) -> np.ndarray:
    """A ring (n, 2) that begins at a random one of its places and goes round either way."""
    if rng is None:
        return ring
    direction = int(rng.choice([1, -1]))
    return np.roll(ring, int(rng.integers(len(ring))), axis=0)[::direction]


def shuffle(obstacles: tuple[Obstacle, ...], rng: np.random.Generator | None) -> list[Obstacle]:
    """Things in any order."""
    order = range(len(obstacles)) if rng is None else rng.permutation(len(obstacles)).tolist()
    return [obstacles[k] for k in order]


def points_of(places: np.ndarray) -> tuple[tuple[float, float], ...]:
    """Places (n, 2) as a layout has them."""
    return tuple((x, y) for x, y in places.tolist())
