"""Worlds that the commands are given, and layouts that they write."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

from app.settings import at_least, names, numbers
from worlds.file_writer import demand_writable, write_text

if TYPE_CHECKING:
    from worlds.world import World

SIDE = 10.0
"""Side of the box of a layout that leaves it open, m."""


def given_world(name: str, dim: int | None = None, size: str | None = None, seed: int = 0) -> World:
    """The world of a built-in name or a layout file, sound or not. Raises InputError.

    Without `size` it is the layout's own, else SIDE. Random obstacles are drawn from `seed`.
    """
    from worlds.generators import drawn
    from worlds.layout import read_layout, world_from_layout

    made = world_from_layout(read_layout(name), name, dim, sides(size), lambda _: SIDE)
    at_least("--seed", seed, 0)
    return drawn(made, seed)


def sides(text: str | None) -> float | tuple[float, ...] | None:
    """One side for all axes, or one per axis. Raises InputError."""
    if text is None:
        return None
    made = numbers("--size", text)
    return made[0] if len(made) == 1 else tuple(made)


def edges_asked(text: str) -> str | tuple[str, ...]:
    """One word for all sides, or one per axis."""
    made = names(text)
    return made[0] if len(made) == 1 else tuple(made)


LAYOUTS = (".toml",)
"""Endings of layouts."""


def demand_new(
    option: str, path: Path, overwrite: bool, endings: Collection[str] = LAYOUTS
) -> None:
    """Refuse a file that cannot be written, or is there, unless asked. Raises InputError."""
    demand_writable(option, path, overwrite, endings)


def write_layout(made: World, path: Path) -> None:
    """Write the layout of a world, which must be sound. Raises InputError."""
    from worlds.checks import demand_sound

    demand_sound(made)
    write_text("--out", path, made.to_toml())


def size_text(made: World) -> str:
    """The sides of the box."""
    return " x ".join(f"{side:g}" for side in made.size) + " m"
