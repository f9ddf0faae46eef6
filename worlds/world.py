"""A world: a box with an edge on each axis, obstacles in it and a mission, where a flock lives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import tomlkit
from pydantic import BaseModel

from worlds.input_error import InputError, shorten, unknown
from worlds.mission import Mission
from worlds.notebook_html import svg, table
from worlds.number_text import counted
from worlds.obstacles import Obstacle, Union

EDGES = ("wrap", "open", "solid")
"""What an edge does: agents that leave come in on the other side, or go on for ever, or cannot."""
DISTANCES = ("nearest-image", "plain")
"""How distance is measured where an axis wraps: across the seam, or within the box only."""
BOUNDARY_SPACING = 0.5
"""Of boundary points, length; the papers' value."""


@dataclass(frozen=True)
class RandomObstacles:
    """What a world leaves to chance: a kind of `worlds.generators`, and its parameters."""

    kind: str
    parameters: BaseModel
    dim: int
    """2 for flat obstacles, which stand up in a world of three dimensions; 3 for solids in it."""

    def described(self) -> str:
        """Kind and parameters, for the source of a drawn world."""
        settings = ", ".join(
            f"{k} = {value:g}" for k, value in self.parameters.model_dump().items()
        )
        return f"{self.kind}: {settings}"

    def to_table(self) -> dict[str, Any]:
        """The table [random] of a layout."""
        return {"kind": self.kind, "dim": self.dim, **self.parameters.model_dump()}


@dataclass(frozen=True, repr=False)
class World:
    """A box [low, low + size) in 2 or 3 dimensions, with what is in it.

    `size` is a side per axis, or one number for a square, length; `edges` is a word per axis, or
    one for all: "wrap", "open" or "solid". `distance` is "nearest-image" where agents see each
    other across a wrapping seam, which is the right physics, and "plain" where they do not, which
    is what reproduces the tables of Liu et al. 2021. Raises InputError for sides and edges that no
    world has, and if an axis wraps whose lower end is not 0.

    >>> World(size=(20.0, 10.0), edges="open")
    <World world, 20 x 10, edges open>
    """

    name: str = "world"
    size: tuple[float, ...] = (10.0, 10.0)
    edges: tuple[str, ...] = ("wrap",)
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
    """Obstacles still to be drawn from a seed, see `worlds.generators.draw_obstacles`."""

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise InputError(
                f"name = {shorten(self.name)} is no name: give the sides as World(size=(20, 10))"
            )
        sides: Any = self.size
        dim = 2 if np.isscalar(sides) else len(sides)
        if dim not in (2, 3):
            raise InputError(
                f"size = {shorten(sides)} is not allowed: 2 or 3 sides, or one number for a square"
            )
        edges: Any = self.edges
        edges = edges[0] if not isinstance(edges, str) and len(edges) == 1 else edges
        object.__setattr__(self, "size", box(dim, sides))
        object.__setattr__(self, "edges", edges_of(edges, dim, self.name))
        if self.distance not in DISTANCES:
            raise unknown("distance", self.distance, DISTANCES, self.name)
        for name in ("low", "obstacles"):  # lists would make it no value
            object.__setattr__(self, name, tuple(getattr(self, name)))
        if not self.low:
            object.__setattr__(self, "low", (0.0,) * self.dim)
        for axis, edge in enumerate(self.edges):
            if edge == "wrap" and self.low[axis] != 0.0:
                raise InputError(
                    f"low = {list(self.low)} is not allowed: axis {'xyz'[axis]} wraps and begins "
                    f"at 0 ({self.name})"
                )
        if not self.height:
            top = self.low[2] + self.size[2] if self.dim == 3 else 0.1 * max(self.size)
            object.__setattr__(self, "height", top)

    def __repr__(self) -> str:
        parts = [self.name, " x ".join(f"{side:g}" for side in self.size)]
        parts.append(f"edges {', '.join(dict.fromkeys(self.edges))}")
        if self.obstacles:
            parts.append(counted(len(self.obstacles), "obstacle"))
        if self.random is not None:
            parts.append("obstacles drawn from the seed")
        return f"<World {', '.join(parts)}>"

    def _repr_html_(self) -> str:
        rows = {
            "size": self.size,
            "edges": self.edges,
            "distance": self.distance,
            "obstacles": len(self.obstacles) if self.random is None else self.random.described(),
            "mission": self.mission_words,
            "source": self.source or "-",
        }
        title = "World" if self.name == "world" else f"World {self.name}"
        return table(rows, title, self.picture())

    @property
    def mission_words(self) -> str:
        """What its mission has, in words."""
        if self.mission is None:
            return "none"
        parts = ("start", "sources", "exits", "path", "goal")
        return ", ".join(name for name in parts if getattr(self.mission, name))

    def picture(self, marks: Iterable[str] = ()) -> str:
        """It from above as SVG, with `marks`, SVG elements in its coordinates, over it."""
        outlines = [obstacle.footprint() for obstacle in self.obstacles]
        return svg(self.low, self.size, outlines, marks, repr(self).strip("<>"))

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

    @property
    def has_gates(self) -> bool:
        """Whether agents come in at sources or go out at exits."""
        return self.mission is not None and self.mission.has_gates

    def to_layout(self) -> dict[str, Any]:
        """The layout that `worlds.layout.world_from_layout` makes this world of again, exactly."""
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
            layout["mission"] = as_table(self.mission.to_table())
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
    empty_keys = [key for key, value in table.items() if value in ("", ())]
    first = {key: table[key] for key in ("shape", "name")}
    if isinstance(shape, Union):
        first["parts"] = [shape_table(part) for part in shape.parts]
    return {k: v for k, v in {**first, **table, **first}.items() if k not in empty_keys}


def as_table(value: Any) -> Any:
    """A value as TOML knows it: lists in the place of tuples."""
    if isinstance(value, Mapping):
        return {key: as_table(item) for key, item in value.items()}
    return [as_table(item) for item in value] if isinstance(value, list | tuple) else value


def edges_of(value: str | Sequence[str], dim: int, origin: str) -> tuple[str, ...]:
    """What the edge of each axis does, of one word for all or one per axis. Raises InputError."""
    edges = (value,) * dim if isinstance(value, str) else tuple(value)
    if len(edges) != dim:
        axes = counted(len(edges), "axis", "axes")
        raise InputError(f"edges = {list(edges)} names {axes}, the world has {dim} ({origin})")
    for edge in edges:
        if edge not in EDGES:
            raise unknown("edge", edge, EDGES, origin)
    return edges


def box(dim: int, size: float | Sequence[float]) -> tuple[float, ...]:
    """The sides of a box, one per axis. Raises InputError if a side is not a length > 0."""
    sides = (size,) * dim if np.isscalar(size) else tuple(np.asarray(size, object).ravel().tolist())
    if len(sides) != dim:
        raise InputError(
            f"size = {size} has {counted(len(sides), 'side')}, a {dim}-D world has {dim}"
        )
    for side in sides:
        if (
            isinstance(side, bool)
            or not isinstance(side, int | float | np.number)
            or not 0.0 < side < 1e9
        ):
            raise InputError(
                f"size = {shorten(side)} is not allowed: a side is a length in (0, 1e9)"
            )
    return tuple(float(side) for side in sides)
