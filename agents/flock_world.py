"""The world that a flock lives in: found by name, drawn from a seed, written into the spec."""

from __future__ import annotations

from typing import Any

from agents.models.model import Model
from agents.spec import Options, Spec
from worlds.generators import drawn
from worlds.input_error import InputError
from worlds.layout import layout_dim, layout_names, own_dim, world_from_layout
from worlds.layout import world as build_world
from worlds.world import World


def at_home(spec: Spec, model: Model) -> Spec:
    """The spec with what its model and its world have of their own, where it says nothing.

    A kind of noise that is part of the rule's definition is that of the run. The seed and the size
    stay open. Raises InputError for a world that cannot be read.
    """
    world = model.world if spec.world is None else spec.world
    if isinstance(world, World):
        dim = world.dim
    elif spec.dim is not None:
        dim = spec.dim
    else:
        own = layout_dim(world) if spec.layout is None else own_dim(spec.layout, world)
        dim = own or model.dim or model.dimensions[0]
    chosen: dict[str, Any] = {
        key: getattr(model, key)
        for key in ("agents", *Options.model_fields)
        if getattr(spec, key) is None and hasattr(model, key)
    }
    if model.rule.noise:
        chosen["noise"] = model.rule.noise
    return spec.but(world=world, dim=dim, **chosen)


def find_world(spec: Spec, model: Model) -> World:
    """The world of a spec that is `at_home`, in the dimensions in which the model is defined.

    By default it has room for the agents. Obstacles that it leaves to chance are drawn from the
    seed. Raises InputError.
    """
    assert spec.world is not None
    assert spec.seed is not None
    if isinstance(spec.world, World):
        found = spec.world
    elif spec.layout is not None:
        found = world_from_layout(spec.layout, spec.world, spec.dim, spec.size)
    else:
        found = build_world(
            spec.world, spec.dim, spec.size, lambda dim: (spec.count / model.density) ** (1.0 / dim)
        )
    found = drawn(found, spec.seed)
    if found.dim not in model.dimensions:
        allowed = " and ".join(f"{d}-D" for d in model.dimensions)
        raise InputError(
            f"dim = {found.dim!r} is not allowed: {model.name} is defined in {allowed}"
        )
    return found


def is_built_in(world: World, seed: int) -> bool:
    """Whether the name and the seed are enough to make this world again."""
    if world.name not in layout_names():
        return False
    try:
        return drawn(build_world(world.name, world.dim, world.size), seed) == world
    except InputError:
        return False
