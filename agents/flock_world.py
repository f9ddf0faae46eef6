"""The world that a flock lives in: found by name, drawn from a seed, written into the spec."""

from __future__ import annotations

import secrets
from typing import Any

from agents.kinds import complete_kinds
from agents.models.model import Model
from agents.spec import CompleteSpec, Options, Spec
from worlds.generators import draw_obstacles
from worlds.input_error import InputError
from worlds.layout import layout_dim, layout_names, own_dim, world_from_layout
from worlds.layout import world as build_world
from worlds.world import World

LARGEST_DRAWN = 2**31
"""Seeds that are drawn are below: short enough to be typed again."""


def complete_spec(spec: Spec, model: Model) -> CompleteSpec:
    """The run with what its model and its world have of their own, where nothing is asked for.

    A kind of noise that is part of the rule's definition is that of the run, and kinds of agents
    that the rule knows are there. A seed is drawn where there is none; a size that is not given
    stays None. Raises InputError for a world that cannot be read.
    """
    world = model.world if spec.world is None else spec.world
    if isinstance(world, World):
        dim = world.dim
    elif spec.dim is not None:
        dim = spec.dim
    else:
        own = layout_dim(world) if spec.layout is None else own_dim(spec.layout, world)
        dim = own or model.dim or model.dimensions[0]
    choices: dict[str, Any] = {
        key: getattr(model, key)
        for key in ("agents", *Options.model_fields)
        if getattr(spec, key) is None and hasattr(model, key)
    }
    if model.rule.noise:
        choices["noise"] = model.rule.noise
    seed = secrets.randbelow(LARGEST_DRAWN) if spec.seed is None else spec.seed
    if model.rule.kinds:
        table = complete_kinds(model.rule.kinds, spec.kinds, spec.to)
        choices |= {"kinds": table.kinds, "to": table.to}
    return CompleteSpec(**{**dict(spec), "world": world, "dim": dim, "seed": seed, **choices})


def world_of_any_seed(spec: CompleteSpec, model: Model) -> World:
    """The world of a run before its random obstacles are drawn, in as many dimensions as the model
    is defined in.

    By default it has room for the agents. Raises InputError.
    """
    if isinstance(spec.world, World):
        world = spec.world
    elif spec.layout is not None:
        world = world_from_layout(spec.layout, spec.world, spec.dim, spec.size)
    else:
        world = build_world(
            spec.world, spec.dim, spec.size, lambda dim: (spec.count / model.density) ** (1.0 / dim)
        )
    if world.dim not in model.dimensions:
        allowed = " and ".join(f"{d}-D" for d in model.dimensions)
        raise InputError(
            f"dim = {world.dim!r} is not allowed: {model.name} is defined in {allowed}"
        )
    return world


def find_world(spec: CompleteSpec, model: Model) -> World:
    """The world of a run, with obstacles that it leaves to chance drawn from the seed.

    Raises InputError.
    """
    return draw_obstacles(world_of_any_seed(spec, model), spec.seed)


def is_built_in(world: World, seed: int) -> bool:
    """Whether the name and the seed are enough to make this world again."""
    if world.name not in layout_names():
        return False
    try:
        return draw_obstacles(build_world(world.name, world.dim, world.size), seed) == world
    except InputError:
        return False
