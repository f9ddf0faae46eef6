"""Which run is proposed: a model in the world that it is at home in; and what worlds are called."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from agents.catalogue import model as find_model
from agents.flock_world import complete_spec
from agents.spec import DEFAULT, CompleteSpec, Spec
from app.viewer.scene.shown.drawing_style import DrawingDefaults, default_style
from worlds.layout import layout_names, own_dim, shared_layout
from worlds.world import World

MOST_AGENTS = 200_000
"""More agents than this are set up from the command line or a script, not from a browser."""
COMMON_SPEED, HURRY = 15.0, 5.0
"""Ticks per second for bodies that count ticks; seconds per second for those that count seconds."""
WORLDS = {
    "wrap": "wraps around",
    "wrap-plain": "wraps, seam is a wall",
    "open": "open plane",
    "thesis-sky": "thesis: empty, wraps",
    "thesis-blocks": "thesis: 20 blocks, solid walls",
}
"""Short words for some worlds; the others go by their titles."""


@dataclass(frozen=True)
class WorldDefaults:
    """What a world decides by itself."""

    dim: int | None
    """Dimensions that it is written in, None where it fits both."""
    sized: bool
    """Whether it has a size of its own."""


def world_defaults(world: str | World) -> WorldDefaults:
    """What a world decides by itself. Raises InputError for a file that cannot be read."""
    if isinstance(world, World):
        return WorldDefaults(world.dim, True)
    layout = shared_layout(world)
    return WorldDefaults(own_dim(layout, world), "size" in layout)


def preset_spec(model: str = DEFAULT, **options: Any) -> CompleteSpec:
    """A run of a model in the world that it is at home in, where nothing else is `given`.

    What is None counts as not given; the seed is 1 then. Raises InputError.

    >>> preset_spec("hwvem").world, preset_spec("hwvem", world="open").world
    ('wrap', 'open')
    """
    given_options = {name: value for name, value in options.items() if value is not None}
    return complete_spec(Spec(model, **{"seed": 1, **given_options}), find_model(model))


def lively_speed(spec: Spec) -> float:
    """Ticks per second at which a run can be watched: five times as fast as a body's seconds pass.

    >>> lively_speed(preset_spec("hwvem"))
    15.0
    """
    if find_model(spec.model).body.unit == "ticks":
        return COMMON_SPEED
    return HURRY / tick_of(spec)


def tick_of(spec: Spec) -> float:
    """How long a tick of a run lasts, in its unit of time."""
    model = find_model(spec.model)
    parameters = {k: v for k, v in spec.parameters.items() if k in model.parameters.model_fields}
    return model.body.lasts(model.parameters(**parameters))


def drawing_defaults(spec: Spec) -> DrawingDefaults:
    """How a run is drawn as long as nobody chooses otherwise.

    >>> [drawing_defaults(preset_spec(name)).look.colour for name in ("squashing-cars", "vem")]
    ['each its own', 'heading']
    """
    model = find_model(spec.model)
    return default_style(model, spec.agents, tick_of(spec), bool(spec.kinds))


def world_titles() -> dict[str, str | World]:
    """The built-in worlds by what a person may call them, the empty ones first."""
    names = [*WORLDS, *(name for name in layout_names() if name not in WORLDS)]
    return {world_title(name): name for name in names}


def world_title(world: str | World) -> str:
    """What a person may call a world."""
    if isinstance(world, World):
        return world.title or world.name
    return WORLDS.get(world) or str(shared_layout(world).get("title", "")) or world
