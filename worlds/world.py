"""A world: a box with an edge on each axis, where a flock lives."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from worlds.refusal import Refusal, unknown

EDGES = ("wrap", "open")
"""What an edge does: agents that leave come in on the other side, or go on for ever."""
DISTANCES = ("nearest-image", "plain")
"""How distance is measured where an axis wraps: across the seam, or within the box only."""
LAYOUTS = files("worlds") / "layouts"


@dataclass(frozen=True)
class World:
    """A box [0, size) in 2 or 3 dimensions.

    `distance` is "nearest-image" where agents see each other across a wrapping seam, which is the
    right physics, and "plain" where they do not, which is what reproduces the tables of Liu et al.
    2021.
    """

    name: str
    size: tuple[float, ...]
    edges: tuple[str, ...]
    distance: str = "nearest-image"
    title: str = ""

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


def layout_names() -> list[str]:
    """Names of the built-in worlds."""
    return sorted(
        f.name.removesuffix(".toml") for f in LAYOUTS.iterdir() if f.name.endswith(".toml")
    )


def read_layout(name: str) -> dict[str, Any]:
    """The text of a built-in layout or of a TOML file, as a dictionary.

    Raises Refusal for an unknown name, a missing file or a file that is not TOML.
    """
    path = LAYOUTS / f"{name}.toml" if name in layout_names() else Path(name)
    if name not in layout_names() and not name.endswith(".toml"):
        raise unknown("world", name, layout_names())
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise Refusal(f"world file {name!r} cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise Refusal(f"world file {name!r} is not TOML: {error}") from None


def world(name: str, dim: int, size: float | Sequence[float]) -> World:
    """The world of a layout (a built-in name or a TOML file) with a box of the given size.

    `size` is one length for all sides or one per axis, each > 0. Raises Refusal.
    """
    layout = read_layout(name)
    for key in layout:
        if key not in ("title", "edges", "distance"):
            raise unknown("key", key, ("title", "edges", "distance"), name)
    edges = layout.get("edges", "wrap")
    edges = (edges,) * dim if isinstance(edges, str) else tuple(edges)
    if len(edges) != dim:
        raise Refusal(
            f"edges = {list(edges)} names {len(edges)} axes, the world has {dim} ({name})"
        )
    for edge in edges:
        if edge not in EDGES:
            raise unknown("edge", edge, EDGES, name)
    distance = layout.get("distance", "nearest-image")
    if distance not in DISTANCES:
        raise unknown("distance", distance, DISTANCES, name)
    return World(name, box(dim, size), edges, distance, str(layout.get("title", "")))


def box(dim: int, size: float | Sequence[float]) -> tuple[float, ...]:
    """The sides of a box, one per axis. Raises Refusal if a side is not a length > 0."""
    sides = (size,) * dim if np.isscalar(size) else tuple(np.asarray(size).ravel().tolist())
    if len(sides) != dim:
        raise Refusal(f"size = {size} has {len(sides)} sides, a {dim}-D world has {dim}")
    for side in sides:
        if isinstance(side, bool | str) or not (0.0 < float(side) < 1e9 and math.isfinite(side)):
            raise Refusal(f"size = {side!r} is not allowed: a side is a length in (0, 1e9)")
    return tuple(float(side) for side in sides)
