"""The world that a flock lives in: found by name, drawn from a seed, written into the spec."""

from __future__ import annotations

from typing import Any

import numpy as np

from agents.models.model import Model
from agents.spec import Spec
from worlds.generators import drawn
from worlds.layout import layout_dim, layout_names, world_from_layout
from worlds.layout import world as build_world
from worlds.refusal import Refusal
from worlds.world import World

DENSITY = 4.102
"""Agents per unit of area or volume unless a size is given: rho of Liu et al. 2021, 3.1."""


def find_world(
    model: Model,
    given: str | World | None,
    dim: int | None,
    size: Any,
    agents: int,
    seed: int,
) -> World:
    """The world asked for, in the dimensions in which the model is defined.

    `size` is one side for all, one per axis, or None. By default it is the one that the model is at
    home in, in the dimensions of its layout, else of the model, with room for so many agents.
    Obstacles that it leaves to chance are drawn. Raises Refusal.
    """
    if isinstance(given, World):
        found = given
    else:
        name = model.world if given is None else given
        if dim is None and np.ndim(size) == 0 and layout_dim(name) is None:
            dim = model.dim
        found = build_world(name, dim, size, lambda d: (agents / DENSITY) ** (1.0 / d))
    found = drawn(found, seed)
    if found.dim not in model.dimensions:
        allowed = " and ".join(f"{d}-D" for d in model.dimensions)
        raise Refusal(f"dim = {found.dim!r} is not allowed: {model.name} is defined in {allowed}")
    return found


def is_built_in(world: World, seed: int) -> bool:
    """Whether the name and the seed are enough to make this world again."""
    if world.name not in layout_names():
        return False
    try:
        return drawn(build_world(world.name, world.dim, world.size), seed) == world
    except Refusal:
        return False


def world_of(spec: Spec, model: Model) -> World:
    """The world of a run: what its spec carries with it, or what the name makes. Raises Refusal."""
    if spec.layout is not None:
        return world_from_layout(spec.layout, spec.world, spec.dim, None)
    agents = spec.agents + spec.informed
    return find_world(model, spec.world, spec.dim, spec.size, agents, spec.seed)
