"""Layouts: worlds written as TOML files, built in or anybody's own."""

from __future__ import annotations

import functools
import shlex
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from worlds.checks import demand_sound
from worlds.generators.generate import random_obstacles
from worlds.input_error import BREAKS, InputError, shorten, unknown
from worlds.mission import mission
from worlds.number_text import counted
from worlds.obstacles import obstacle
from worlds.plug_ins import plug_ins
from worlds.text_file import read_text, toml
from worlds.world import BOUNDARY_SPACING, DISTANCES, World, box, edges_of

DRAWINGS = (".dxf", ".geojson", ".json", ".wkt")
"""Endings of files that are no layouts, but may come to be some."""
LAYOUTS = files(__package__) / "layouts"
KEYS = (
    "title",
    "source",
    "edges",
    "distance",
    "dim",
    "low",
    "size",
    "height",
    "boundary_spacing",
    "obstacle",
    "random",
    "mission",
)


BUILT_IN = {f.name.removesuffix(".toml"): f for f in LAYOUTS.iterdir() if f.name.endswith(".toml")}


def layout_of_entry(name: str, entry: object) -> tuple[str, dict[str, Any]]:
    """The layout that an entry point brings, as TOML has it. Raises TypeError if it is none."""
    if not isinstance(entry, Mapping):
        raise TypeError(f"a layout as a dictionary is needed, not {type(entry).__name__}")
    return name, dict(entry)


BROUGHT = plug_ins("flockscope.layouts", layout_of_entry, BUILT_IN)
"""The layouts of other packages."""


def layout_names() -> list[str]:
    """Names of the built-in worlds, and of those of other packages."""
    return sorted([*BUILT_IN, *BROUGHT])


def read_layout(name: str) -> dict[str, Any]:
    """The text of a built-in layout or of a TOML file, as a dictionary.

    Raises InputError for an unknown name, a missing file or a file that is not TOML.
    """
    return deepcopy(shared_layout(name))


def shared_layout(name: str) -> dict[str, Any]:
    """What `read_layout` copies, for who does not change it. Raises InputError."""
    if name in BROUGHT:
        return BROUGHT[name]
    if Path(name).suffix.lower() in DRAWINGS:
        command = f"{shlex.quote(name)} --out {shlex.quote(Path(name).stem + '.toml')}"
        raise InputError(
            f"world {name!r} is a drawing: `flockscope world import {command}` makes a layout of it"
        )
    if name not in BUILT_IN and not name.endswith(".toml"):
        raise unknown("world", name, layout_names())
    if name in BUILT_IN:
        return built_in(name)
    title = f"world file {name!r}"
    return toml(read_text(title, name), title)


@functools.cache
def built_in(name: str) -> dict[str, Any]:
    """A built-in layout, read once."""
    return toml(BUILT_IN[name].read_text(encoding="utf-8"), f"world {name!r}")


def layout_dim(name: str) -> int | None:
    """The dimension that a layout is written in, None where it fits both. Raises InputError."""
    return own_dim(shared_layout(name), name)


def world(
    name: str,
    dim: int | None = None,
    size: float | Sequence[float] | None = None,
    unsized: Callable[[int], float] | None = None,
) -> World:
    """The world of a layout (a built-in name or a TOML file), sound.

    See `world_from_layout`. Raises InputError, also for the first error that `worlds.checks` finds.
    """
    built_world = world_from_layout(shared_layout(name), name, dim, size, unsized)
    demand_sound(built_world)
    return built_world


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
    layout with obstacles. Random obstacles are not drawn yet, see
    `worlds.generators.draw_obstacles`. Raises InputError.
    """
    return Layout(name, layout).world(dim, size, unsized)


def own_dim(layout: Mapping[str, Any], name: str) -> int | None:
    """The dimension that a layout is written in, None where it fits both. Raises InputError."""
    return Layout(name, layout).own_dim()


@dataclass(frozen=True)
class Layout:
    """The keys of a layout as TOML has them; `name` is where they come from, for refusals."""

    name: str
    keys: Mapping[str, Any]

    def world(
        self,
        dim: int | None,
        size: float | Sequence[float] | None,
        unsized: Callable[[int], float] | None,
    ) -> World:
        """See `world_from_layout`. Raises InputError."""
        for key in self.keys:
            if key not in KEYS:
                raise unknown("key", key, KEYS, self.name)
        own = self.own_dim()
        dim = (own or 2) if dim is None else dim
        if dim not in (2, 3):
            raise InputError(
                f"dim = {dim!r} is not allowed: a world has 2 or 3 dimensions ({self.name})"
            )
        if own == 3 and dim == 2:
            raise InputError(f"dim = 2 is not allowed: the world {self.name} has 3 dimensions")
        stands = own == 2 and dim == 3
        edges = self.edges(dim, stands)
        distance = self.keys.get("distance", "nearest-image")
        if distance not in DISTANCES:
            raise unknown("distance", distance, DISTANCES, self.name)
        height = self.length("height", 0.0)
        solid = tuple(obstacle(values, self.name) for values in self.tables("obstacle"))
        sides = self.size(dim, size, unsized, height, bool(solid))
        low = self.keys.get("low", [0.0] * (own or dim))
        if stands and len(low) == 2:
            low = [*low, 0.0]
        task = mission(self.keys["mission"], self.name) if "mission" in self.keys else None
        if task is not None and dim == 3:
            task = task.standing(height or sides[2])
        random = self.keys.get("random")
        if "random" in self.keys:
            random = random_obstacles(random, dim, stands, self.name)
        return World(
            name=self.name,
            size=sides,
            edges=edges,
            distance=distance,
            title=self.line("title"),
            low=self.corner(low, dim),
            obstacles=solid,
            mission=task,
            height=height,
            boundary_spacing=self.length("boundary_spacing", BOUNDARY_SPACING),
            source=self.line("source"),
            random=random,
        )

    def own_dim(self) -> int | None:
        """The dimension that it is written in, None where it fits both. Raises InputError."""
        dim = self.keys.get("dim")
        if dim is not None and (isinstance(dim, bool) or dim not in (2, 3)):
            raise InputError(
                f"dim = {dim!r} is not allowed: a world has 2 or 3 dimensions ({self.name})"
            )
        for key in ("size", "low"):
            value = self.keys.get(key)
            if isinstance(value, list):
                if dim is not None and len(value) != dim:
                    raise InputError(
                        f"{key} = {value} has {counted(len(value), 'number')}, not {dim} "
                        f"({self.name})"
                    )
                dim = len(value)
        edges = self.keys.get("edges")
        return len(edges) if dim is None and isinstance(edges, list) and len(edges) == 2 else dim

    def edges(self, dim: int, stands: bool) -> tuple[str, ...]:
        """What the edge of each axis does. Raises InputError.

        Of a flat layout that stands up, floor and ceiling are as the sides are, or solid if these
        differ.
        """
        edge_kinds = self.keys.get("edges", "wrap")
        if stands and not isinstance(edge_kinds, str) and len(edge_kinds) == 2:
            edge_kinds = (*edge_kinds, edge_kinds[0] if edge_kinds[0] == edge_kinds[1] else "solid")
        return edges_of(edge_kinds, dim, self.name)

    def size(self, dim: int, size, unsized, height: float, fixed: bool):
        """The sides of the box, (dim,) of lengths. Raises InputError."""
        own: Any = self.keys.get("size")
        if own is not None:
            own = box(len(own) if isinstance(own, list) else dim, own)
            if len(own) < dim:
                own = (*own, height or 0.1 * max(own))
        if own is None and fixed:
            raise InputError(f"the world {self.name} has obstacles but no size")
        if size is None:
            if own is None and unsized is None:
                raise InputError(f"the world {self.name} has no size of its own: give one")
            return own if own is not None or unsized is None else box(dim, unsized(dim))
        sides = box(dim, size)
        if fixed and sides != own:
            raise InputError(
                f"size = {size} is not allowed: the world {self.name} has obstacles, "
                f"its size is {list(own)}"
            )
        return sides

    def tables(self, key: str) -> list[Any]:
        """A list of tables in it, [[key]] in TOML. Raises InputError."""
        value = self.keys.get(key, [])
        if not isinstance(value, list | tuple):
            raise InputError(f"{key} is not a list of tables: write [[{key}]] ({self.name})")
        return list(value)

    def line(self, key: str) -> str:
        """A text of one line in it, by default empty. Raises InputError."""
        value = self.keys.get(key, "")
        if not isinstance(value, str) or BREAKS.search(value):
            raise InputError(
                f"{key} = {shorten(value)} is not allowed: one line of text ({self.name})"
            )
        return value

    def length(self, key: str, default: float) -> float:
        """A length > 0 in it. Raises InputError."""
        value = self.keys.get(key, default)
        if value is default:
            return default
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < 1e9:
            raise InputError(
                f"{key} = {value!r} is not allowed: a length in (0, 1e9) ({self.name})"
            )
        return float(value)

    def corner(self, values: Any, dim: int) -> tuple[float, ...]:
        """The lower corner of a box. Raises InputError."""
        is_place = isinstance(values, list | tuple) and len(values) == dim
        for value in values if is_place else ():
            number = isinstance(value, int | float) and not isinstance(value, bool)
            is_place = is_place and number and -1e9 < value < 1e9
        if not is_place:
            raise InputError(
                f"low = {values!r} is not allowed: {dim} numbers in (-1e9, 1e9) ({self.name})"
            )
        return tuple(float(value) for value in values)
