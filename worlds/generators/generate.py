"""Worlds of random obstacles by kind, seed and size."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydantic import ValidationError
from pydantic.fields import FieldInfo

from worlds.generators.blocks import BLOCKS
from worlds.generators.corridors import CORRIDORS
from worlds.generators.discs import DISCS
from worlds.generators.forest import FOREST
from worlds.generators.maze import MAZE
from worlds.generators.world_generator import GeneratorParameters, WorldGenerator
from worlds.input_error import InputError, shortened, unknown
from worlds.world import World, box, edges_of

GENERATORS = {kind.name: kind for kind in (DISCS, BLOCKS, FOREST, CORRIDORS, MAZE)}
"""All kinds by name."""


def generate(
    kind: str,
    seed: int,
    size: float | Sequence[float],
    edges: str | Sequence[str] = "solid",
    dim: int | None = None,
    origin: str = "",
    **parameters: Any,
) -> World:
    """A world of a kind. The same seed, size and parameters give the same world.

    `size` is one side for all or one per axis, m; `dim` is 2 unless size has three sides. `origin`
    is where the parameters come from, for refusals. Raises InputError for an unknown kind or
    parameter, a value that is not allowed, or obstacles that do not fit.
    """
    if kind not in GENERATORS:
        raise unknown("kind of world", kind, GENERATORS)
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise InputError(f"seed = {seed!r} is not allowed: a whole number >= 0")
    one = GENERATORS[kind]
    dim = dim or (2 if np.isscalar(size) else len(np.asarray(size).ravel()))
    if dim not in one.dimensions:
        where = " and ".join(f"{d}-D" for d in one.dimensions)
        raise InputError(f"dim = {dim} is not allowed: {kind} is made in {where}")
    sides = box(dim, size)
    given = checked(one, parameters, origin)
    made = one.make(np.random.default_rng(seed), np.zeros(dim), np.array(sides), given)
    values = ", ".join(f"{name} = {value:g}" for name, value in given.model_dump().items())
    return World(
        name=f"{kind}-{seed}",
        size=sides,
        edges=edges_of(edges, dim, origin or kind),
        title=f"{one.title}, seed {seed}",
        obstacles=tuple(made.obstacles),
        mission=made.mission,
        source=f"generator {kind}: seed {seed}, {values}",
    )


def checked(kind: WorldGenerator, values: dict[str, Any], origin: str) -> GeneratorParameters:
    """The parameters of a kind, checked. Raises InputError naming the first that is not allowed."""
    fields = kind.parameters.model_fields
    for name in values:
        if name not in fields:
            raise unknown(f"parameter of {kind.name}", name, fields, origin)
    try:
        return kind.parameters(**values)
    except ValidationError as error:
        name = str(error.errors()[0]["loc"][0])
        where = f" ({origin})" if origin else ""
        raise InputError(
            f"{name} = {shortened(values[name])} is not allowed: {allowed(fields[name])}{where}"
        ) from None


def allowed(field: FieldInfo) -> str:
    """What a parameter may be."""
    kind = "a whole number" if field.annotation is int else "a number"
    limits = {
        word: getattr(bound, name)
        for bound in field.metadata
        for name, word in (("gt", ">"), ("ge", ">="), ("le", "<="))
        if getattr(bound, name, None) is not None
    }
    limited = " and".join(f" {word} {value:g}" for word, value in limits.items())
    return kind + limited
