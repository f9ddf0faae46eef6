"""The contents of a drawing before they are interpreted: items on layers."""

from __future__ import annotations

import stat
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from worlds.input_error import InputError
from worlds.readers.drawn_shapes import Shape

UNNAMED = "unnamed"
"""The layer of what names none."""
LARGEST = 64_000_000
"""Bytes of a file at most."""
MOST_ITEMS = 100_000
"""Most things that a file draws, those of a block counted as often as it is inserted."""
MOST_CORNERS = 50_000
"""Corners of all that is taken of a file at most."""
DEEPEST = 50
"""Most collections, or blocks, one in another."""


@dataclass(frozen=True)
class Item:
    """Something drawn: its layer, what it is called in its file, and how to read it.

    `read` gives its shapes, in the units of the file, and raises InputError with file and place for
    what cannot be used. It is called only for items on the layers that are wanted.
    """

    layer: str
    kind: str
    read: Callable[[], list[Shape]]


@dataclass(frozen=True)
class DrawingContents:
    """All items of a file; `unit` is metres per unit of the file, None if it does not say."""

    path: Path
    items: tuple[Item, ...]
    layers: tuple[str, ...]
    """All there are, also those without items."""
    unit: float | None
    hidden: Mapping[str, str] = field(default_factory=dict)
    """Layers that the drawing does not show, and why: "frozen" or "off"."""
    left_out: Mapping[tuple[str, str], int] = field(default_factory=dict)
    """How many of a kind on a layer bound no area and are no line either."""
    roles: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    """What the format itself says that a layer is: its role, and why."""
    degrees: Literal["yes", "maybe", "no"] = "no"
    """Whether coordinates are longitudes and latitudes, where the file says so or may mean it."""


def text_of(path: Path) -> str:
    """The text of a file. Raises InputError."""
    data = bytes_of(path)
    encoding = "utf-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        # Programs of Windows still write its code page, of which Latin-1 is the most part.
        if any(sign < 32 and sign not in b"\t\n\f\r\x1a" for sign in set(data)):
            raise InputError(f"{str(path)!r} is not a text file: it holds control codes") from None
        return data.decode("cp1252", errors="replace")


def bytes_of(path: Path) -> bytes:
    """What a file holds. Raises InputError."""
    demand_file(path)
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read: {error.strerror}") from None


def demand_file(path: Path) -> None:
    """Refuse what is no file, or too large to read. Raises InputError."""
    try:
        status = path.stat()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{str(path)!r} cannot be read: {reason}") from None
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"{str(path)!r} cannot be read: it is not a file")
    if status.st_size > LARGEST:
        raise InputError(f"{path} has {status.st_size} bytes: a drawing has {LARGEST} at most")


def layers_of(items: list[Item]) -> tuple[str, ...]:
    """The layers of items, each once, in the order of the file."""
    return tuple(dict.fromkeys(item.layer for item in items))


# Questions that a drawing leaves open: one line to read, and the choices that answer it.


@dataclass(frozen=True)
class PlanChoice:
    """An answer: what a person reads, and what it adds to the call of `read_geometry`."""

    label: str
    options: Mapping[str, Any] = field(default_factory=dict)
    """Keywords; `roles` are added to those that are given."""
    thickness: bool = False
    """Whether it needs a thickness of walls beside."""


class PlanQuestion(InputError):
    """A drawing that may mean two things; its text says how the command line answers it."""

    def __init__(self, line: str, choices: tuple[PlanChoice, ...]) -> None:
        super().__init__(line)
        self.choices = choices
