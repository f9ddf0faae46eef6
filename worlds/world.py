"""A world: a box with an edge on each axis, obstacles in it and a mission, where a flock lives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import tomlkit

from worlds.checks import demand_sound
from worlds.layout import (
    BOUNDARY_SPACING,
    DISTANCES,
    EDGES,
    layout_dim,
    layout_fields,
    layout_names,
    read_layout,
)
from worlds.mission import Mission
from worlds.obstacles import Obstacle, Union
from worlds.random_obstacles import RandomObstacles
from worlds.refusal import Refusal

__all__ = [
    "DISTANCES",
    "EDGES",
    "World",
    "layout_dim",
    "layout_names",
    "read_layout",
    "world",
    "world_from_layout",
]


@dataclass(frozen=True)
class World:
    """A box [low, low + size) in 2 or 3 dimensions, with what is in it.

    `distance` is "nearest-image" where agents see each other across a wrapping seam, which is the
    right physics, and "plain" where they do not, which is what reproduces the tables of Liu et al.
    2021. Raises Refusal if an axis wraps whose lower end is not 0.
    """

    name: str
    size: tuple[float, ...]
    edges: tuple[str, ...]
    distance: str = "nearest-image"
    title: str = ""
    low: tuple[float, ...] = ()
    """Lower corner; zeros by default."""
    obstacles: tuple[Obstacle, ...] = ()
    mission: Mission | None = None
    height: float = 0.0
    """Up to which flat obstacles stand in three dimensions, and are drawn in two; by default the
    top of the box, or a tenth of the longest side."""
    boundary_spacing: float = BOUNDARY_SPACING
    """Most distance between neighbouring boundary points, length."""
    source: str = ""
    """Where the layout is from."""
    random: RandomObstacles | None = None
    """Obstacles still to be drawn from a seed; a flock lives in a world that is `drawn`."""

    def __post_init__(self) -> None:
        if not self.low:
            object.__setattr__(self, "low", (0.0,) * self.dim)
        for axis in np.flatnonzero(self.wraps):
            if self.low[axis] != 0.0:
                raise Refusal(
                    f"low = {list(self.low)} is not allowed: axis {'xyz'[axis]} wraps and begins "
                    f"at 0 ({self.name})"
                )
        if not self.height:
            top = self.low[2] + self.size[2] if self.dim == 3 else 0.1 * max(self.size)
            object.__setattr__(self, "height", top)

    @property
    def dim(self) -> int:
        """2 or 3."""
        return len(self.size)

    @property
    def wraps(self) -> np.ndarray:
        """Axes along which positions wrap, (dim,) bool."""
        return np.array([edge == "wrap" for edge in self.edges])

    @property
    def images(self) -> np.ndarray:
        """Axes along which neighbours are seen across the seam, (dim,) bool."""
        return self.wraps & (self.distance == "nearest-image")

    @property
    def is_solid(self) -> bool:
        """Whether there is anything solid: an obstacle, also one to be drawn, or an edge."""
        return bool(self.obstacles) or self.random is not None or "solid" in self.edges

    def drawn(self, seed: int) -> World:
        """The world with its random obstacles drawn: the same seed >= 0 gives the same ones.

        They come after its own obstacles, and bring a mission where it has none. A world without
        random obstacles is drawn already. Raises Refusal if they do not fit, or if the world is not
        sound with them.

        >>> len(world("thesis-blocks").drawn(1).obstacles)
        20
        """
        if self.random is None:
            return self
        made = self.random.draw(seed, self.low, self.size)
        task = made.mission
        if task is not None and self.dim == 3:
            task = task.standing(self.height)
        told = f"drawn from seed {seed}: {self.random.told()}"
        found = replace(
            self,
            obstacles=(*self.obstacles, *made.obstacles),
            random=None,
            mission=self.mission or task,
            source=f"{self.source}; {told}" if self.source else told,
        )
        demand_sound(found)
        return found

    def to_layout(self) -> dict[str, Any]:
        """The layout that `world_from_layout` makes this world of again, exactly."""
        layout: dict[str, Any] = {
            "title": self.title,
            "source": self.source,
            "edges": list(self.edges),
            "distance": self.distance,
            "dim": self.dim,
            "low": list(self.low),
            "size": list(self.size),
            "height": self.height,
            "boundary_spacing": self.boundary_spacing,
        }
        if self.mission is not None:
            layout["mission"] = as_table(self.mission.model_dump(exclude_none=True))
        if self.obstacles:
            layout["obstacle"] = [as_table(shape_table(o)) for o in self.obstacles]
        if self.random is not None:
            layout["random"] = self.random.to_table()
        return layout

    def to_toml(self) -> str:
        """The layout as a TOML file; numbers keep every bit."""
        return tomlkit.dumps(self.to_layout())


def shape_table(shape: Obstacle) -> dict[str, Any]:
    """The keys of an obstacle that say anything, its shape and name first."""
    table = shape.model_dump(exclude_none=True)
    empty = [key for key, value in table.items() if value in ("", ())]
    first = {key: table[key] for key in ("shape", "name")}
    if isinstance(shape, Union):
        first["parts"] = [shape_table(part) for part in shape.parts]
    return {k: v for k, v in {**first, **table, **first}.items() if k not in empty}


def as_table(value: Any) -> Any:
    """A value as TOML knows it: lists in the place of tuples."""
    if isinstance(value, Mapping):
        return {key: as_table(item) for key, item in value.items()}
    return [as_table(item) for item in value] if isinstance(value, list | tuple) else value


def world(
    name: str,
    dim: int | None = None,
    size: float | Sequence[float] | None = None,
    unsized: Callable[[int], float] | None = None,
) -> World:
    """The world of a layout (a built-in name or a TOML file), sound.

    See `world_from_layout`. Raises Refusal, also for the first error that `worlds.checks` finds.
    """
    found = world_from_layout(read_layout(name), name, dim, size, unsized)
    demand_sound(found)
    return found


def world_from_layout(
    layout: Mapping[str, Any],
    name: str,
    dim: int | None = None,
    size: float | Sequence[float] | None = None,
    unsized: Callable[[int], float] | None = None,
) -> World:
    """The world that a layout describes; `worlds.checks` tells whether it is sound.

    `dim` is 2 or 3, by default the layout's own, or 2. A flat layout stands up in three dimensions:
    its box and obstacles reach from z = 0 to `height`. `size` is one length for all sides or one
    per axis, each > 0; by default the layout's own, or `unsized(dim)`. It cannot be changed in a
    layout with obstacles. Random obstacles are not drawn yet, see `World.drawn`. Raises Refusal.
    """
    return World(**layout_fields(layout, name, dim, size, unsized))
