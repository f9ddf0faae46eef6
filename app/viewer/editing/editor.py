"""The world under a person's hands: every change gives a new world and can be undone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from worlds.checks import gate_problems, place_problems, shape_problems, start_problems
from worlds.input_error import InputError
from worlds.mission import Goal
from worlds.obstacles import Disc, Polygon, obstacle
from worlds.world import World

MOST_OBSTACLES = 500
FAR = 100.0
"""How far from the box things may be put, as a multiple of its longest side."""
STEPS = 100
"""Changes that can be undone."""
EDITED = "-edited"
"""Put behind the name of a layout that was changed."""

keys = itertools.count(1)
"""Every obstacle that an editor meets gets its own number, which nothing else ever has."""


class MissingObstacleError(InputError):
    """The obstacle that was meant is not there any more."""


@dataclass(frozen=True)
class WorldVersion:
    """A world, and the key of each of its obstacles."""

    world: World
    keys: tuple[int, ...]

    @classmethod
    def of(cls, world: World) -> WorldVersion:
        """A world whose obstacles are new."""
        return cls(world, tuple(next(keys) for _ in world.obstacles))

    def place(self, key: int) -> int:
        """Where in the world's tuple an obstacle is. Raises Gone."""
        if key not in self.keys:
            raise MissingObstacleError("that obstacle does not exist any more")
        return self.keys.index(key)

    def obstacle(self, key: int) -> Any:
        """The obstacle of a key. Raises Gone."""
        return self.world.obstacles[self.place(key)]


@dataclass(frozen=True)
class Editor:
    """A world with its history; a value: every change returns another editor.

    Changes raise InputError, with one line, for what is out of bounds, no sound shape, or would
    make the mission impossible. Changes in a row with the same `gesture`, as those of one drag, are
    one step of the history, and each of them is a change of the world as it was before the gesture.
    """

    now: WorldVersion
    past: tuple[WorldVersion, ...] = ()
    future: tuple[WorldVersion, ...] = ()
    gesture: str = ""

    @classmethod
    def of(cls, world: World) -> Editor:
        """An editor of a world, without a history."""
        return cls(WorldVersion.of(world))

    @property
    def world(self) -> World:
        """The world as it is now."""
        return self.now.world

    @property
    def newest_key(self) -> int:
        """Key of the last obstacle; 0 if there is none."""
        return self.now.keys[-1] if self.now.keys else 0

    def add(self, obstacle: Any) -> Editor:
        """One more obstacle."""
        if len(self.world.obstacles) >= MOST_OBSTACLES:
            raise InputError(f"there are {MOST_OBSTACLES} obstacles already: no more are allowed")
        demand_fitting(obstacle, self.world)
        world = replace_obstacles(self.world, (*self.world.obstacles, obstacle))
        demand_allowed(world, len(world.obstacles) - 1)
        return self.changed(WorldVersion(world, (*self.now.keys, next(keys))))

    def move(
        self, key: int, by: Sequence[float], degrees: float = 0.0, gesture: str = ""
    ) -> Editor:
        """An obstacle elsewhere: shifted by (2,) or (3,) length and turned about its centre."""
        shift = [*by, 0.0, 0.0, 0.0][:3]
        if not all(math.isfinite(number) for number in (*shift, degrees)):
            raise InputError(f"an obstacle cannot be moved by {list(by)} and turned by {degrees}")
        obstacle = self.version_before(gesture).obstacle(key).turned(degrees)
        if self.world.dim == 2 or not has_heights(obstacle):
            shift[2] = 0.0
        return self.exchange(key, obstacle.moved(*shift), gesture)

    def resize(self, key: int, gesture: str = "", **measures: float) -> Editor:
        """An obstacle with other measures, see `Shape.measures`."""
        for name, value in measures.items():
            if not math.isfinite(value):
                raise InputError(f"{name} = {value} is not a number")
        obstacle = self.version_before(gesture).obstacle(key).resized(**measures)
        demand_fitting(obstacle, self.world)
        return self.exchange(key, obstacle, gesture)

    def exchange(self, key: int, obstacle: Any, gesture: str = "") -> Editor:
        """Another obstacle in the place of one."""
        before = self.version_before(gesture)
        place = before.place(key)
        others = before.world.obstacles
        world = replace_obstacles(before.world, (*others[:place], obstacle, *others[place + 1 :]))
        demand_allowed(world, place)
        return self.changed(WorldVersion(world, before.keys), gesture)

    def delete(self, key: int) -> Editor:
        """One obstacle less."""
        place, old = self.now.place(key), self.world.obstacles
        world = replace_obstacles(self.world, old[:place] + old[place + 1 :])
        return self.changed(WorldVersion(world, self.now.keys[:place] + self.now.keys[place + 1 :]))

    def clear(self) -> Editor:
        """No obstacles at all."""
        return (
            self.changed(WorldVersion(replace_obstacles(self.world, ()), ()))
            if self.now.keys
            else self
        )

    def move_goal(self, by: Sequence[float], gesture: str = "") -> Editor:
        """The goal's route shifted by (dim,) length. Raises InputError if there is no goal."""
        before = self.version_before(gesture)
        mission, dim = before.world.mission, before.world.dim
        if mission is None or mission.goal is None:
            raise InputError("this world has no goal")
        if len(by) < dim or not all(math.isfinite(number) for number in by):
            raise InputError(f"the goal cannot be moved by {list(by)}")
        goal = mission.goal
        route: list[Any] = [
            tuple(at + d for at, d in zip(point, by, strict=False)) for point in goal.route
        ]
        for point in route:
            demand_near(before.world, "the goal", (*point[:2], *point[:2]))
        moved = Goal(route=tuple(route), speed=goal.speed, closed=goal.closed)
        mission = mission.model_copy(update={"goal": moved})
        world = replace(before.world, mission=mission, **edited_texts(before.world))
        demand_possible(world)
        return self.changed(WorldVersion(world, before.keys), gesture)

    def undo(self) -> Editor:
        """The last step taken back; the same editor if there is none."""
        if not self.past:
            return self
        return Editor(self.past[-1], self.past[:-1], (self.now, *self.future))

    def redo(self) -> Editor:
        """The step that was last taken back, done again; the same editor if there is none."""
        if not self.future:
            return self
        return Editor(self.future[0], (*self.past, self.now), self.future[1:])

    def version_before(self, gesture: str) -> WorldVersion:
        """The world before a gesture that has begun; now for any other."""
        return self.past[-1] if gesture and gesture == self.gesture else self.now

    def changed(self, now: WorldVersion, gesture: str = "") -> Editor:
        """The editor after a change."""
        if gesture and gesture == self.gesture:
            return replace(self, now=now, future=())
        return Editor(now, (*self.past, self.now)[-STEPS:], (), gesture)


def replace_obstacles(world: World, obstacles: tuple[Any, ...]) -> World:
    """The world with other obstacles, under a name that says so."""
    return replace(world, obstacles=obstacles, **edited_texts(world))


def edited_texts(world: World) -> dict[str, Any]:
    """Name and title of a world that is no longer what its layout says."""
    if world.name.endswith(EDITED):
        return {"name": world.name, "title": world.title}
    name = Path(world.name).stem if world.name.endswith(".toml") else world.name
    return {"name": name + EDITED, "title": f"{world.title or name} (edited)"}


def has_heights(obstacle: Any) -> bool:
    """Whether an obstacle has a height of its own, so that it can be moved up and down."""
    if obstacle.shape == "union":
        return all(has_heights(part) for part in obstacle.parts)
    if obstacle.shape == "box" and len(obstacle.low) == 3:
        return True
    return obstacle.shape in ("sphere", "prism") or None not in (obstacle.bottom, obstacle.top)


def demand_allowed(world: World, place: int) -> None:
    """Raise InputError if an obstacle is too far away, unsound, or in the mission's way."""
    obstacle = world.obstacles[place]
    bounds = obstacle.footprint().bounds
    demand_near(world, f"obstacle {obstacle.label}", bounds)
    for problem in shape_problems(world, place):
        raise InputError(problem.text)
    demand_possible(world)


def demand_near(world: World, thing: str, bounds: Sequence[float]) -> None:
    """Raise InputError if bounds (x, y, x, y) reach more than FAR boxes away, or are not finite."""
    far = FAR * max(world.size)
    low, high = world.low[:2], [a + b for a, b in zip(world.low, world.size, strict=True)][:2]
    near = all(
        bounds[axis] >= low[axis] - far and bounds[axis + 2] <= high[axis] + far for axis in (0, 1)
    )
    if not near:
        raise InputError(f"{thing} is too far away: at most {FAR:g} sides of the world's box")


def demand_possible(world: World) -> None:
    """Raise InputError if a goal, a waypoint or all of the start region is inside an obstacle."""
    if world.mission is None:
        return
    for problem in (
        *place_problems(world, world.mission),
        *start_problems(world, world.mission),
        *gate_problems(world, world.mission),
    ):
        if problem.severity == "error":
            raise InputError(problem.text)


# Obstacles as a person draws them, and how large they may be.


LEAST, MOST = 1e-3, 4.0
"""Least and most extent of what a person draws, as multiples of the world's longest side."""
CORNERS = 200
"""Corners of a drawn polygon at most."""
MEASURES = ("radius", "width", "depth", "size")
"""Lengths by which obstacles are drawn."""


def disc(at: Sequence[float], radius: float) -> Disc:
    """A disc, or in three dimensions a column."""
    return obstacle({"shape": "disc", "centre": (float(at[0]), float(at[1])), "radius": radius})


def polygon(points: Sequence[Sequence[float]]) -> Polygon:
    """A polygon of the corners that were clicked; a corner clicked twice counts once.

    Raises InputError for fewer than three corners or more than CORNERS.
    """
    corners = [(float(point[0]), float(point[1])) for point in points]
    previous = corners[-1:] + corners[:-1]
    kept_corners = [corner for corner, before in zip(corners, previous, strict=True)
            if corner != before]  # fmt: skip
    if len(kept_corners) < 3:
        raise InputError(f"a polygon needs 3 corners or more, {len(kept_corners)} were given")
    if len(kept_corners) > CORNERS:
        raise InputError(f"a polygon has {CORNERS} corners at most, {len(kept_corners)} were given")
    return obstacle({"shape": "polygon", "points": kept_corners})


def demand_fitting(shape: Any, world: World) -> None:
    """Raise InputError if a drawn obstacle is too small or too large for its world."""
    side = max(world.size)
    for name, value in shape.measures().items():
        if name in MEASURES and not LEAST * side <= value <= MOST * side:
            raise InputError(
                f"{name} = {value:g} is not allowed: from {LEAST * side:g} to {MOST * side:g} in "
                "this world"
            )
