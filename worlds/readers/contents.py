"""What a file of geometry holds before any of it is taken: items on layers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from worlds.readers.shapes import Shape
from worlds.refusal import Refusal

OBSTACLE = "obstacle"
"""The layer of what names none."""
WALKABLE = "walkable"
"""The layer of a walkable area, unless another is named."""


@dataclass(frozen=True)
class Item:
    """Something drawn: its layer, and how to read it.

    `read` gives its shapes, in the units of the file, and raises Refusal with file and place for
    what cannot be used. It is called only for items on the layers that are wanted.
    """

    layer: str
    read: Callable[[], list[Shape]]


@dataclass(frozen=True)
class Contents:
    """All items of a file; `unit` is metres per unit of the file, None if it does not say.

    `layers` are all there are, also those without items. `notes` say what was left out, one line
    each.
    """

    items: tuple[Item, ...]
    layers: tuple[str, ...]
    unit: float | None
    notes: tuple[str, ...] = ()


def text_of(path: Path) -> str:
    """The text of a file. Raises Refusal."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise Refusal(f"{str(path)!r} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise Refusal(f"{str(path)!r} is not a text file") from None


def layers_of(items: list[Item]) -> tuple[str, ...]:
    """The layers of items, each once, in the order of the file."""
    return tuple(dict.fromkeys(item.layer for item in items))
