"""The flock of a row of a paper at tick 0, and what the row overrides of its world's mission."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field, model_validator

from agents import Flock
from agents.spec import Spec
from app.strict_table import StrictTable
from worlds.input_error import InputError
from worlds.layout import world as build_world
from worlds.mission import Goal
from worlds.world import World
from worlds.world_rotation import turned, turned_places

if TYPE_CHECKING:
    from app.studies.experiment import Case


class Ranks(StrictTable):
    """Places on a plane for the first agents, with normal noise that follows from the seed."""

    places: tuple[tuple[float, float], ...] = Field(min_length=1)
    """Where they stand, the first agents at the first places; length."""
    off: float = Field(0.0, ge=0.0)
    """Standard deviation of their places along each axis, length."""
    heading: float
    """Which way they look, deg, anticlockwise from the x axis."""
    turned: float = Field(0.0, ge=0.0)
    """Standard deviation of their headings, deg."""
    speed: float = Field(0.0, ge=0.0)
    """Length per unit of time."""

    def start(self, agents: int, seed: int) -> dict[str, np.ndarray]:
        """Positions, headings and speeds of so many agents. Raises InputError if places lack."""
        if agents > len(self.places):
            raise InputError(
                f"agents = {agents}, but only {len(self.places)} have a place to start"
            )
        rng = np.random.default_rng(seed)
        off = self.off * rng.normal(size=(agents, 2))
        angle = np.radians(self.heading + self.turned * rng.normal(size=agents))
        return {
            "position": np.array(self.places[:agents], float) + off,
            "heading": np.column_stack([np.cos(angle), np.sin(angle)]),
            "speed": np.full(agents, self.speed),
        }


class Overrides(StrictTable):
    """What a row overrides of the world's mission."""

    ranks: Ranks | None = None
    """Where agents start; None: at random in the world's own region."""
    rests: tuple[float, float] | None = None
    """Where the goal rests, length; None: on its route."""
    speed: float | None = Field(default=None, gt=0.0)
    """Speed of the goal along its route; None: the world's own."""
    scene: str | None = None
    """Another world than the experiment's; None: that one."""
    turned: bool = False
    """Every run has one start, that of seed 1; from run to run the scene is turned by another
    angle, with the start in it, and its outlines begin elsewhere: the seed draws both."""

    @model_validator(mode="after")
    def _rests_or_moves(self) -> Overrides:
        if self.rests is not None and self.speed is not None:
            raise ValueError("a goal that rests has no speed")
        return self


START = 1
"""The seed of the start that turned runs have."""
PLAIN = Overrides()
"""Nothing is overridden."""


def with_goal(world: World, overrides: Overrides) -> World:
    """The world with the goal as the overrides have it. Raises InputError if it has no goal."""
    if overrides.speed is None and overrides.rests is None:
        return world
    if world.mission is None or world.mission.goal is None:
        said = "rests" if overrides.speed is None else f"speed = {overrides.speed:g}"
        raise InputError(f"{said}: the world {world.name!r} has no goal")
    if overrides.rests is not None:
        goal = Goal(route=(overrides.rests,))
    else:
        goal = world.mission.goal.model_copy(update={"speed": overrides.speed})
    return replace(world, mission=world.mission.model_copy(update={"goal": goal}))


def flock_of(case: Case, seed: int) -> Flock:
    """The flock of a case at tick 0. Raises InputError."""
    spec, row = case.spec.but(seed=seed), case.row
    overrides = row.mission if row else PLAIN
    if spec.size is None:
        bare = row is not None and not row.obstacles
        name = overrides.scene or spec.world
        spec = spec.but(world=world_of(name, spec.dim, bare, overrides))
    if overrides.turned:
        return turned_flock(spec)
    return Flock(spec, start=overrides.ranks.start(case.agents, seed) if overrides.ranks else None)


def turned_flock(spec: Spec) -> Flock:
    """The flock of one start in a scene that the seed turns. Raises InputError."""
    flock = Flock(spec.but(seed=START))
    rng = np.random.default_rng(spec.seed)
    angle = float(rng.uniform(0.0, 360.0))
    middle = np.array(flock.world.low) + 0.5 * np.array(flock.world.size)
    start = {
        "position": turned_places(flock.position, angle, middle),
        "heading": turned_places(flock.heading, angle, np.zeros(2)),
        "speed": flock.speed,
        "informed": flock.informed,
    }
    return Flock(spec.but(world=turned(flock.world, angle, rng)), start=start)


@cache
def world_of(name: str, dim: int | None, bare: bool, overrides: Overrides) -> World:
    """The world of a layout in the layout's own size; `bare` without its obstacles.

    Raises InputError if the overrides change a part of the mission that the world does not have.
    """
    found = with_goal(build_world(name, dim), overrides)
    return replace(found, obstacles=(), random=None) if bare else found
