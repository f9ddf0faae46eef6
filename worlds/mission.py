"""A mission: where a flock starts, which way its information agents go, what all of them seek."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from worlds.input_error import InputError, first_input_error, unknown

Length = Annotated[float, Field(strict=True, gt=0.0, lt=1e9)]
Distance = Annotated[float, Field(strict=True, ge=0.0, lt=1e9)]
Number = Annotated[float, Field(strict=True, gt=-1e9, lt=1e9)]
Point = tuple[Number, Number] | tuple[Number, Number, Number]
Points = Annotated[tuple[Point, ...], Field(min_length=1)]


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
        if self.high is not None and any(a >= b for a, b in zip(self.low, self.high, strict=True)):
            raise ValueError(
                f"high = {list(self.high)} is not above low = {list(self.low)} on every axis"
            )
        slow, fast = self.speed_low or (), self.speed_high or ()
        if any(a > b for a, b in zip(slow, fast, strict=True)):
            raise ValueError(f"speed_high = {list(fast)} is below speed_low = {list(slow)}")
        return self


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
        path, goal = self.path, self.goal
        if path is not None:
            path = path.model_copy(update={"waypoints": raised(path.waypoints, 0.5 * height)})
        if goal is not None:
            goal = goal.model_copy(update={"route": raised(goal.route, 0.5 * height)})
        return self.model_copy(update={"start": start, "path": path, "goal": goal})

    def dims(self) -> dict[str, int]:
        """The number of coordinates that each part has."""
        dims_of_parts = {}
        if self.start is not None:
            dims_of_parts["mission.start"] = len(self.start.low)
        if self.path is not None:
            dims_of_parts["mission.path"] = len(self.path.waypoints[0])
        if self.goal is not None:
            dims_of_parts["mission.goal"] = len(self.goal.route[0])
        return dims_of_parts


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
