"""A mission: where a flock starts and comes in, where its agents go, seek and leave."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
import shapely
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from worlds.input_error import InputError, first_input_error, unknown

Length = Annotated[float, Field(strict=True, gt=0.0, lt=1e9)]
Distance = Annotated[float, Field(strict=True, ge=0.0, lt=1e9)]
Number = Annotated[float, Field(strict=True, gt=-1e9, lt=1e9)]
Point = tuple[Number, Number] | tuple[Number, Number, Number]
Points = Annotated[tuple[Point, ...], Field(min_length=1)]
Corner = tuple[float, ...]
Rate = Annotated[float, Field(strict=True, gt=0.0, lt=1e6)]
Time = Annotated[float, Field(strict=True, ge=0.0, lt=1e9)]
MOST_TIMES = 100_000
"""Of one source; a list of them is read whole."""
MOST_REGIONS = 100
"""Sources, and exits, of one mission."""


class MissionPart(BaseModel):
    """What the parts of a mission have in common."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class StartRegion(MissionPart):
    """The box in which a flock starts: [low, high], or a cube from `low` of a given density."""

    low: Point
    high: Point | None = None
    density: Length | None = None
    """Agents, the information agents among them, per area or volume."""
    spacing: Distance = 0.0
    """Least distance between two agents, length."""
    speed_low: Point | None = None
    """Velocities are uniform between speed_low and speed_high (length per unit of time); None: the
    model's own."""
    speed_high: Point | None = None

    @model_validator(mode="after")
    def _is_a_box(self) -> Self:
        if (self.high is None) == (self.density is None):
            raise ValueError("a start has either high or density")
        if (self.speed_low is None) != (self.speed_high is None):
            raise ValueError("speed_low and speed_high go together")
        for name in ("high", "speed_low", "speed_high"):
            corner = getattr(self, name)
            if corner is not None and len(corner) != len(self.low):
                raise ValueError(
                    f"low = {list(self.low)} and {name} = {list(corner)} differ in size"
                )
        demand_box(self.low, self.high)
        demand_speeds(self.speed_low, self.speed_high)
        return self


class SourceRegion(MissionPart):
    """A box in which agents enter while a flock runs: at a rate, or at given times.

    Who finds no free place waits for one, and those behind wait too.
    """

    low: Point
    high: Point
    rate: Rate | None = None
    """Agents per unit of time: at time t, floor(rate t) have been due."""
    times: Annotated[tuple[Time, ...], Field(min_length=1, max_length=MOST_TIMES)] | None = None
    """When each agent is due, in order, units of time since the start."""
    most: Annotated[int, Field(strict=True, ge=1, lt=10**9)] | None = None
    """Agents in all, of a rate; None: for ever."""
    spacing: Distance = 0.0
    """Least distance to the other agents at which one enters, length; at least a body's size."""
    speed_low: Point | None = None
    """As in a start region."""
    speed_high: Point | None = None

    @model_validator(mode="after")
    def _is_a_source(self) -> Self:
        if (self.rate is None) == (self.times is None):
            raise ValueError("a source has either rate or times")
        if self.most is not None and self.rate is None:
            raise ValueError("most goes with rate: times already say how many enter")
        if (self.speed_low is None) != (self.speed_high is None):
            raise ValueError("speed_low and speed_high go together")
        for name in ("high", "speed_low", "speed_high"):
            corner = getattr(self, name)
            if corner is not None and len(corner) != len(self.low):
                raise ValueError(
                    f"low = {list(self.low)} and {name} = {list(corner)} differ in size"
                )
        demand_box(self.low, self.high)
        demand_speeds(self.speed_low, self.speed_high)
        for before, after in pairwise(self.times or ()):
            if after < before:
                raise ValueError(f"times = [... {before:g}, {after:g} ...] are not in order")
        return self

    def due(self, time: float) -> int:
        """How many agents are due by a time >= 0; what is later by rounding alone is due."""
        late = time * (1.0 + 1e-12)
        if self.times is not None:
            return bisect_right(self.times, late)
        assert self.rate is not None
        number = math.floor(self.rate * late)
        return number if self.most is None else min(number, self.most)

    def next_due(self, number: int) -> float:
        """When the agent behind `number` others is due; inf if there is none."""
        if self.times is not None:
            return self.times[number] if number < len(self.times) else math.inf
        assert self.rate is not None
        return (number + 1) / self.rate if self.most is None or number < self.most else math.inf


class ExitRegion(MissionPart):
    """Where agents leave the flock: a box, or a polygon on the plan, its edge among it."""

    low: Point | None = None
    high: Point | None = None
    points: Annotated[tuple[Point, ...], Field(min_length=3)] | None = None
    """Corners of a polygon on the plan, in order; in space it stands from below to above all."""

    @model_validator(mode="after")
    def _is_a_region(self) -> Self:
        if (self.points is None) == (self.low is None and self.high is None):
            raise ValueError("an exit has either low and high or points")
        if self.points is not None:
            for point in self.points:
                if len(point) != 2:
                    raise ValueError(f"points {list(point)} is no place on the plan")
            outline = shapely.Polygon(self.points)
            if not outline.is_valid or outline.area == 0.0:
                raise ValueError("points are no outline of an area that does not cross itself")
            return self
        if self.low is None or self.high is None:
            raise ValueError("low and high go together")
        if len(self.low) != len(self.high):
            raise ValueError(f"low = {list(self.low)} and high = {list(self.high)} differ in size")
        demand_box(self.low, self.high)
        return self

    def contains(self, position: np.ndarray) -> np.ndarray:
        """Which of the places (N, dim) are in it or on its edge, (N,) bool."""
        if self.points is not None:
            return np.asarray(shapely.intersects_xy(self.outline, *position[:, :2].T))
        return np.all((position >= self.low) & (position <= self.high), axis=1)

    @property
    def outline(self) -> shapely.Polygon:
        """It on the plan."""
        if self.points is not None:
            return shapely.Polygon(self.points)
        assert self.low is not None
        assert self.high is not None
        return shapely.box(*self.low[:2], *self.high[:2])

    def corners(self, low: Corner, high: Corner) -> tuple[Corner, Corner]:
        """The box around it; of a polygon in space as high as the box of its world [low, high]."""
        if self.low is not None and self.high is not None:
            return self.low, self.high
        x0, y0, x1, y1 = self.outline.bounds
        return (x0, y0, *low[2:]), (x1, y1, *high[2:])

    def overlaps(self, low: Corner, high: Corner) -> bool:
        """Whether it has an area, or a volume, in common with a box [low, high]."""
        mine = self.corners(low, high)
        is_apart = any(a >= d or b <= c for a, b, c, d in zip(*mine, low, high, strict=True))
        box = shapely.box(*low[:2], *high[:2])
        return not is_apart and self.outline.intersection(box).area > 0.0


class Path(MissionPart):
    """The way of the information agents; after the last waypoint they go straight on."""

    waypoints: Points
    switch: Length
    """Distance at which the next waypoint is taken, length."""
    closed: bool = False
    """Whether the first waypoint follows on the last."""

    @model_validator(mode="after")
    def _in_one_space(self) -> Self:
        demand_one_dimension("waypoints", self.waypoints)
        return self


class Goal(MissionPart):
    """What all agents seek, the gamma agent: at rest, or on its way along a route."""

    route: Points
    speed: Distance = 0.0
    """Length per unit of time."""
    closed: bool = False
    """Whether it goes round; else it stays at the route's end."""

    @model_validator(mode="after")
    def _in_one_space(self) -> Self:
        demand_one_dimension("route", self.route)
        return self


class Mission(MissionPart):
    """What a flock is to do in a world; each part may be left out."""

    start: StartRegion | None = None
    sources: Annotated[tuple[SourceRegion, ...], Field(max_length=MOST_REGIONS)] = ()
    exits: Annotated[tuple[ExitRegion, ...], Field(max_length=MOST_REGIONS)] = ()
    path: Path | None = None
    goal: Goal | None = None
    success: Literal["connected", "arrived"] | None = None
    """What counts: agents that stay connected to an information agent, or that arrive at the
    goal."""
    settle: Length = 2.0
    """Distance of the flock's centre to the goal within which it has settled, length."""

    def standing(self, height: float) -> Mission:
        """The mission of a flat world in three dimensions: at half the height of it (length)."""
        start = self.start
        if start is not None and len(start.low) == 2:
            start = StartRegion(
                low=(*start.low, 0.0),
                high=None if start.high is None else (*start.high, height),
                density=start.density,
                spacing=start.spacing,
                speed_low=None if start.speed_low is None else (*start.speed_low, 0.0),
                speed_high=None if start.speed_high is None else (*start.speed_high, 0.0),
            )
        sources = tuple(standing_source(source, height) for source in self.sources)
        exits = tuple(standing_exit(region, height) for region in self.exits)
        path, goal = self.path, self.goal
        if path is not None:
            path = path.model_copy(update={"waypoints": raised(path.waypoints, 0.5 * height)})
        if goal is not None:
            goal = goal.model_copy(update={"route": raised(goal.route, 0.5 * height)})
        return self.model_copy(
            update={
                "start": start,
                "sources": sources,
                "exits": exits,
                "path": path,
                "goal": goal,
            }
        )

    @property
    def has_gates(self) -> bool:
        """Whether agents come or go: whether it has sources or exits."""
        return bool(self.sources or self.exits)

    def to_table(self) -> dict[str, Any]:
        """The table [mission] of a layout, what it has alone."""
        table = self.model_dump(exclude_none=True)
        return {key: value for key, value in table.items() if value != ()}

    def dims(self) -> dict[str, int]:
        """The number of coordinates that each part has."""
        dims_of_parts = {}
        if self.start is not None:
            dims_of_parts["mission.start"] = len(self.start.low)
        for number, source in enumerate(self.sources):
            dims_of_parts[f"mission.sources[{number}]"] = len(source.low)
        for number, region in enumerate(self.exits):
            if region.low is not None:
                dims_of_parts[f"mission.exits[{number}]"] = len(region.low)
        if self.path is not None:
            dims_of_parts["mission.path"] = len(self.path.waypoints[0])
        if self.goal is not None:
            dims_of_parts["mission.goal"] = len(self.goal.route[0])
        return dims_of_parts


def standing_source(source: SourceRegion, height: float) -> SourceRegion:
    """A source of a flat world from the floor up to a height, length."""
    if len(source.low) == 3:
        return source
    slow, fast = source.speed_low, source.speed_high
    return source.model_copy(
        update={
            "low": (*source.low, 0.0),
            "high": (*source.high, height),
            "speed_low": None if slow is None else (*slow, 0.0),
            "speed_high": None if fast is None else (*fast, 0.0),
        }
    )


def standing_exit(region: ExitRegion, height: float) -> ExitRegion:
    """An exit of a flat world from the floor up to a height, length; a polygon stays as it is."""
    low, high = region.low, region.high
    if low is None or high is None or len(low) == 3:
        return region
    return region.model_copy(update={"low": (*low, 0.0), "high": (*high, height)})


def demand_box(low: tuple[float, ...], high: tuple[float, ...] | None) -> None:
    """Raise ValueError unless the upper corner of a box is above the lower one."""
    if high is not None and any(a >= b for a, b in zip(low, high, strict=True)):
        raise ValueError(f"high = {list(high)} is not above low = {list(low)} on every axis")


def demand_speeds(
    speed_low: tuple[float, ...] | None, speed_high: tuple[float, ...] | None
) -> None:
    """Raise ValueError where the velocities of a region end below their beginning."""
    slow, fast = speed_low or (), speed_high or ()
    if any(a > b for a, b in zip(slow, fast, strict=True)):
        raise ValueError(f"speed_high = {list(fast)} is below speed_low = {list(slow)}")


def demand_one_dimension(name: str, points: tuple[tuple[float, ...], ...]) -> None:
    """Raise ValueError unless all points have as many coordinates as the first."""
    for point in points:
        if len(point) != len(points[0]):
            raise ValueError(f"{name} {list(points[0])} and {list(point)} differ in dimension")


def raised(points: tuple[tuple[float, ...], ...], z: float) -> tuple[tuple[float, ...], ...]:
    """Points with a third coordinate, z where they have none."""
    return tuple((*point, z) if len(point) == 2 else point for point in points)


def mission(values: Mapping[str, Any], origin: str = "") -> Mission:
    """The mission that the table of a layout describes.

    Raises InputError naming the key and the value; `origin` says where it came from.
    """
    if not isinstance(values, Mapping):
        raise InputError(f"mission = {values!r} is not a table of keys ({origin})")
    for key in values:
        if key not in Mission.model_fields:
            raise unknown("key", f"mission.{key}", [f"mission.{k}" for k in Mission.model_fields])
    try:
        return Mission.model_validate(values)
    except ValidationError as error:
        raise first_input_error(error, "mission", origin) from None


def along_route(goal: Goal, time) -> np.ndarray:
    """Positions (T, dim) of the gamma agent at times (T,) >= 0, length, at constant speed.

    It stays at the end of its route, or goes round if the route is closed.
    """
    route = np.array(goal.route, float)
    if goal.closed:
        route = np.vstack([route, route[:1]])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1))])
    travelled = goal.speed * np.asarray(time, float)
    if goal.closed and length[-1] > 0.0:
        travelled = travelled % length[-1]
    return np.column_stack([np.interp(travelled, length, axis) for axis in route.T])
