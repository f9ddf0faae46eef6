"""Layouts: how a world is written in a TOML file, and what its keys come to."""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from worlds.counting import counted
from worlds.mission import mission
from worlds.obstacles import obstacle
from worlds.plug_ins import plug_ins
from worlds.random_obstacles import random_obstacles
from worlds.reading import read_text
from worlds.refusal import Refusal, unknown
from worlds.toml import toml

EDGES = ("wrap", "open", "solid")
"""What an edge does: agents that leave come in on the other side, or go on for ever, or cannot."""
DISTANCES = ("nearest-image", "plain")
"""How distance is measured where an axis wraps: across the seam, or within the box only."""
DRAWINGS = (".dxf", ".geojson", ".json", ".wkt")
"""Endings of files that are no layouts, but may come to be some."""
LAYOUTS = files("worlds") / "layouts"
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
BOUNDARY_SPACING = 0.5
"""Of boundary points, length; the papers' value."""


BUILT_IN = {f.name.removesuffix(".toml"): f for f in LAYOUTS.iterdir() if f.name.endswith(".toml")}


def brought(name: str, thing: object) -> tuple[str, dict[str, Any]]:
    """The layout that an entry point brings, as TOML has it. Raises TypeError if it is none."""
    if not isinstance(thing, Mapping):
        raise TypeError(f"a layout as a dictionary is needed, not {type(thing).__name__}")
    return name, dict(thing)


BROUGHT = plug_ins("flockscope.layouts", brought, BUILT_IN)
"""The layouts of other packages."""


def layout_names() -> list[str]:
    """Names of the built-in worlds, and of those of other packages."""
    return sorted([*BUILT_IN, *BROUGHT])


def read_layout(name: str) -> dict[str, Any]:
    """The text of a built-in layout or of a TOML file, as a dictionary.

    Raises Refusal for an unknown name, a missing file or a file that is not TOML.
    """
    if name in BROUGHT:
        return deepcopy(BROUGHT[name])
    if Path(name).suffix.lower() in DRAWINGS:
        again = f"{shlex.quote(name)} --out {shlex.quote(Path(name).stem + '.toml')}"
        raise Refusal(
            f"world {name!r} is a drawing: `flockscope world import {again}` makes a layout of it"
        )
    if name not in BUILT_IN and not name.endswith(".toml"):
        raise unknown("world", name, layout_names())
    named = f"world file {name!r}"
    own = BUILT_IN.get(name)
    return toml(own.read_text(encoding="utf-8") if own else read_text(named, name), named)


def layout_dim(name: str) -> int | None:
    """The dimension that a layout is written in, None where it fits both. Raises Refusal."""
    return own_dim(read_layout(name), name)


def layout_fields(
    layout: Mapping[str, Any],
    name: str,
    dim: int | None,
    size: float | Sequence[float] | None,
    unsized: Callable[[int], float] | None,
) -> dict[str, Any]:
    """The fields of the `worlds.world.World` that a layout describes. Raises Refusal."""
    for key in layout:
        if key not in KEYS:
            raise unknown("key", key, KEYS, name)
    own = own_dim(layout, name)
    dim = (own or 2) if dim is None else dim
    if dim not in (2, 3):
        raise Refusal(f"dim = {dim!r} is not allowed: a world has 2 or 3 dimensions ({name})")
    if own == 3 and dim == 2:
        raise Refusal(f"dim = 2 is not allowed: the world {name} has 3 dimensions")
    stands = own == 2 and dim == 3
    edges = chosen_edges(layout, dim, stands, name)
    distance = layout.get("distance", "nearest-image")
    if distance not in DISTANCES:
        raise unknown("distance", distance, DISTANCES, name)
    height = length(layout, "height", 0.0, name)
    solid = tuple(obstacle(values, name) for values in tables(layout, "obstacle", name))
    sides = chosen_size(layout, dim, size, unsized, height, bool(solid), name)
    low = layout.get("low", [0.0] * (own or dim))
    if stands and len(low) == 2:
        low = [*low, 0.0]
    task = mission(layout["mission"], name) if "mission" in layout else None
    if task is not None and dim == 3:
        task = task.standing(height or sides[2])
    drawn = random_obstacles(layout["random"], dim, stands, name) if "random" in layout else None
    return {
        "name": name,
        "size": sides,
        "edges": edges,
        "distance": distance,
        "title": str(layout.get("title", "")),
        "low": corner(low, dim, name),
        "obstacles": solid,
        "mission": task,
        "height": height,
        "boundary_spacing": length(layout, "boundary_spacing", BOUNDARY_SPACING, name),
        "source": str(layout.get("source", "")),
        "random": drawn,
    }


def own_dim(layout: Mapping[str, Any], name: str) -> int | None:
    """The dimension that a layout is written in, None where it fits both. Raises Refusal."""
    dim = layout.get("dim")
    if dim is not None and (isinstance(dim, bool) or dim not in (2, 3)):
        raise Refusal(f"dim = {dim!r} is not allowed: a world has 2 or 3 dimensions ({name})")
    for key in ("size", "low"):
        value = layout.get(key)
        if isinstance(value, list):
            if dim is not None and len(value) != dim:
                raise Refusal(
                    f"{key} = {value} has {counted(len(value), 'number')}, not {dim} ({name})"
                )
            dim = len(value)
    edges = layout.get("edges")
    return len(edges) if dim is None and isinstance(edges, list) and len(edges) == 2 else dim


def chosen_edges(layout: Mapping[str, Any], dim: int, stands: bool, name: str) -> tuple[str, ...]:
    """What the edge of each axis does. Raises Refusal.

    Of a flat layout that stands up, floor and ceiling are as the sides are, or solid if these
    differ.
    """
    given = layout.get("edges", "wrap")
    edges = (given,) * dim if isinstance(given, str) else tuple(given)
    if stands and len(edges) == 2:
        edges = (*edges, edges[0] if edges[0] == edges[1] else "solid")
    if len(edges) != dim:
        axes = counted(len(edges), "axis", "axes")
        raise Refusal(f"edges = {list(edges)} names {axes}, the world has {dim} ({name})")
    for edge in edges:
        if edge not in EDGES:
            raise unknown("edge", edge, EDGES, name)
    return edges


def chosen_size(layout, dim: int, size, unsized, height: float, fixed: bool, name: str):
    """The sides of the box, (dim,) of lengths. Raises Refusal."""
    own = layout.get("size")
    if own is not None:
        own = box(len(own) if isinstance(own, list) else dim, own)
        if len(own) < dim:
            own = (*own, height or 0.1 * max(own))
    if own is None and fixed:
        raise Refusal(f"the world {name} has obstacles but no size")
    if size is None:
        if own is None and unsized is None:
            raise Refusal(f"the world {name} has no size of its own: give one")
        return own if own is not None or unsized is None else box(dim, unsized(dim))
    given = box(dim, size)
    if fixed and given != own:
        raise Refusal(
            f"size = {size} is not allowed: the world {name} has obstacles, its size is {list(own)}"
        )
    return given


def tables(layout: Mapping[str, Any], key: str, name: str) -> list[Any]:
    """A list of tables in a layout, [[key]] in TOML. Raises Refusal."""
    value = layout.get(key, [])
    if not isinstance(value, list | tuple):
        raise Refusal(f"{key} is not a list of tables: write [[{key}]] ({name})")
    return list(value)


def length(layout: Mapping[str, Any], key: str, default: float, name: str) -> float:
    """A length > 0 in a layout. Raises Refusal."""
    value = layout.get(key, default)
    if value is default:
        return default
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < 1e9:
        raise Refusal(f"{key} = {value!r} is not allowed: a length in (0, 1e9) ({name})")
    return float(value)


def corner(values: Any, dim: int, name: str) -> tuple[float, ...]:
    """The lower corner of a box. Raises Refusal."""
    good = isinstance(values, list | tuple) and len(values) == dim
    for value in values if good else ():
        number = isinstance(value, int | float) and not isinstance(value, bool)
        good = good and number and -1e9 < value < 1e9
    if not good:
        raise Refusal(f"low = {values!r} is not allowed: {dim} numbers in (-1e9, 1e9) ({name})")
    return tuple(float(value) for value in values)


def box(dim: int, size: float | Sequence[float]) -> tuple[float, ...]:
    """The sides of a box, one per axis. Raises Refusal if a side is not a length > 0."""
    sides = (size,) * dim if np.isscalar(size) else tuple(np.asarray(size).ravel().tolist())
    if len(sides) != dim:
        raise Refusal(f"size = {size} has {counted(len(sides), 'side')}, a {dim}-D world has {dim}")
    for side in sides:
        if isinstance(side, bool | str) or not (0.0 < float(side) < 1e9 and math.isfinite(side)):
            raise Refusal(f"size = {side!r} is not allowed: a side is a length in (0, 1e9)")
    return tuple(float(side) for side in sides)
