"""A layout from a file that a browser sent: TOML, or a drawing or map that the readers know."""

from __future__ import annotations

import json
import math
import re
import tempfile
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from app.sandboxed_reader import read_in_sandbox
from app.viewer.editing.editor import FAR, MOST_OBSTACLES
from worlds.checks import demand_sound
from worlds.input_error import InputError, unknown
from worlds.layout import layout_names, world_from_layout
from worlds.readers import read_geometry, world_around
from worlds.readers.drawing_contents import PlanChoice, PlanQuestion
from worlds.readers.read import READERS
from worlds.text_file import toml
from worlds.world import World

LARGEST = 5_000_000
"""Bytes of a layout file at most."""
MOST_CORNERS = 50_000
"""Corners of all obstacles together at most."""
MOST_POINTS = 100_000
"""Boundary points along all outlines at most."""
MOST_WORDS = 350
"""Letters of a drawing's refusal that are shown."""
ELSEWHERE = "options are those of 'flockscope world import', whose layout can be opened here"
PAIRS = (".yaml", ".yml")
"""Half of a map of ROS: a browser sends one file, so both come as a ZIP file."""
DRAWINGS = tuple(ending for ending in READERS if ending not in PAIRS)
ENDINGS = (".toml", *DRAWINGS)
OPTIONS = ("roles", "thickness", "unit", "degrees")
"""How a drawing can be read from the page, by the names of `read_geometry`."""


def layout_from_browser(
    name: str, content: bytes, options: Mapping[str, Any] | None = None
) -> World:
    """The world in a file that a browser sent, read in a process of its own.

    `options` are those of OPTIONS that are given. Raises InputError as `layout_of`, and where the
    file takes too much time or memory.
    """
    if len(content) > LARGEST:
        raise size_error(name, content)
    reader = f"{__name__}:layout_as_json"
    options_text = json.dumps(
        {key: (options or {})[key] for key in OPTIONS if key in (options or {})}
    )
    both = options_text.encode() + b"\n" + content
    parsed = json.loads(read_in_sandbox(reader, plain_name(name), both))
    if "question" in parsed:
        raise PlanQuestion(
            parsed["question"], tuple(PlanChoice(**choice) for choice in parsed["choices"])
        )
    return world_from_layout(parsed["layout"], parsed["name"])


def layout_as_json(name: str, content: bytes) -> bytes:
    """The layout in a file, or the question that it leaves open, as JSON.

    `content` is a line of options, as JSON, and the file. Raises InputError as `layout_of`.
    """
    options, _, file = content.partition(b"\n")
    try:
        world = layout_of(name, file, json.loads(options))
    except PlanQuestion as question:
        choices = [asdict(choice) for choice in question.choices]
        return json.dumps({"question": str(question), "choices": choices}).encode()
    return json.dumps({"name": world.name, "layout": world.to_layout()}).encode()


def layout_of(name: str, content: bytes, options: Mapping[str, Any] | None = None) -> World:
    """The world in a file of this name; `options` are how a drawing is read.

    Raises InputError with one line for a file that is too large or of another kind, that cannot be
    read, or whose world is unsound or too large for the laboratory; PlanQuestion for a drawing
    that may mean two things.
    """
    name = plain_name(name)
    ending = Path(name).suffix.lower()
    if ending in PAIRS:
        raise InputError(f"{name} is one half of a map of ROS: open a ZIP file of it and its image")
    if ending not in ENDINGS:
        raise unknown("kind of layout file", ending or name, ENDINGS)
    if len(content) > LARGEST:
        raise size_error(name, content)
    try:
        if ending == ".toml":
            world = read_layout_toml(name, content)
        else:
            world = read_drawing(name, content, options or {})
        demand_small(world, name)
        demand_sound(world)
    except InputError:
        raise
    except Exception as error:  # A broken file makes the parsers of others raise whatever they do.
        raise InputError(f"{name} cannot be read: {type(error).__name__}") from None
    return world


def size_error(name: str, content: bytes) -> InputError:
    """What a file of too many bytes is told."""
    return InputError(f"{name} has {len(content)} bytes: a layout file has {LARGEST} at most")


def plain_name(name: str) -> str:
    """The name of a file without folders and signs that mean something elsewhere.

    >>> plain_name("../../my rooms?.toml")
    'my rooms_.toml'
    """
    last = re.split(r"[/\\]", name)[-1][-80:]
    return re.sub(r"[^\w .()+-]", "_", last).strip(". ") or "layout"


def read_layout_toml(name: str, content: bytes) -> World:
    """The world of a layout in TOML. Raises InputError."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{name} is not TOML: {error}") from None
    layout = toml(text, name)
    demand_few(layout, name)
    if "size" not in layout:
        raise InputError(f"{name} has no size: the laboratory needs the sides of its box")
    own = Path(name).stem
    return world_from_layout(layout, f"{own}-file" if own in layout_names() else own)


def demand_few(layout: dict[str, Any], name: str) -> None:
    """Raise InputError for a layout with too many obstacles, before any of them is made."""
    obstacles = layout.get("obstacle", [])
    if isinstance(obstacles, list) and len(obstacles) > MOST_OBSTACLES:
        raise count_error(name, len(obstacles))


def read_drawing(name: str, content: bytes, options: Mapping[str, Any]) -> World:
    """The world around a drawing, with solid edges. Raises InputError."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        try:
            geometry = read_geometry(path, **options)
            if len(geometry.obstacles) > MOST_OBSTACLES:
                raise count_error(name, len(geometry.obstacles))
            return world_around(geometry)
        except PlanQuestion as question:
            words = str(question).replace(str(path), name)
            raise PlanQuestion(words[:MOST_WORDS], question.choices) from None
        except InputError as refusal:
            words = str(refusal).replace(str(path), name)
            # No options can be given here: where the words ask for one, they say where they can.
            hint = f" ({ELSEWHERE})" if "--" in words else ""
            raise InputError(words[:MOST_WORDS] + hint) from None


def count_error(name: str, count: int) -> InputError:
    """What a file with too many obstacles is told."""
    return InputError(
        f"{name} has {count} obstacles: the laboratory takes {MOST_OBSTACLES} at most"
    )


def demand_small(world: World, name: str) -> None:
    """Raise InputError for a world that would take the laboratory too long."""
    corners, length = 0, 0.0
    far, side = FAR * max(world.size), max(world.size)
    if len(world.obstacles) > MOST_OBSTACLES:
        raise count_error(name, len(world.obstacles))
    for obstacle in world.obstacles:
        for outline, _, _ in obstacle.spans():
            corners += len(outline.exterior.coords) + sum(len(r.coords) for r in outline.interiors)
            length += outline.length
            if max(map(abs, outline.bounds), default=0.0) > far + side + max(map(abs, world.low)):
                raise InputError(
                    f"{name}: obstacle {obstacle.label} is too far away, at most {FAR:g} sides of "
                    "the box"
                )
    if corners > MOST_CORNERS:
        raise InputError(f"{name}: its obstacles have {corners} corners, at most {MOST_CORNERS}")
    length += 2.0 * sum(world.size)
    points = length / world.boundary_spacing if world.boundary_spacing > 0.0 else math.inf
    if points > MOST_POINTS:
        raise InputError(
            f"{name}: boundary_spacing = {world.boundary_spacing:g} makes {points:.3g} boundary "
            f"points, at most {MOST_POINTS}"
        )
