"""Worlds of random obstacles by kind, seed and size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import ValidationError
from pydantic.fields import FieldInfo

from worlds.checks import demand_sound
from worlds.generators.blocks import BLOCKS
from worlds.generators.corridors import CORRIDORS
from worlds.generators.discs import DISCS
from worlds.generators.forest import FOREST
from worlds.generators.maze import MAZE
from worlds.generators.world_generator import GeneratedContents, GeneratorParameters, WorldGenerator
from worlds.input_error import InputError, shorten, unknown
from worlds.world import RandomObstacles, World, box, edges_of

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
    generator = GENERATORS[kind]
    dim = dim or (2 if np.isscalar(size) else len(np.asarray(size).ravel()))
    if dim not in generator.dimensions:
        dimensions = " and ".join(f"{d}-D" for d in generator.dimensions)
        raise InputError(f"dim = {dim} is not allowed: {kind} is made in {dimensions}")
    sides = box(dim, size)
    settings = check_parameters(generator, parameters, origin)
    contents = generator.make(np.random.default_rng(seed), np.zeros(dim), np.array(sides), settings)
    values = ", ".join(f"{name} = {value:g}" for name, value in settings.model_dump().items())
    return World(
        name=f"{kind}-{seed}",
        size=sides,
        edges=edges_of(edges, dim, origin or kind),
        title=f"{generator.title}, seed {seed}",
        obstacles=tuple(contents.obstacles),
        mission=contents.mission,
        source=f"generator {kind}: seed {seed}, {values}",
    )


def check_parameters(
    kind: WorldGenerator, values: dict[str, Any], origin: str
) -> GeneratorParameters:
    """The parameters of a kind, checked. Raises InputError naming the first that is not allowed."""
    fields = kind.parameters.model_fields
    for name in values:
        if name not in fields:
            raise unknown(f"parameter of {kind.name}", name, fields, origin)
    try:
        return kind.parameters(**values)
    except ValidationError as error:
        name = str(error.errors()[0]["loc"][0])
        location = f" ({origin})" if origin else ""
        raise InputError(
            f"{name} = {shorten(values[name])} is not allowed: "
            f"{describe_range(fields[name])}{location}"
        ) from None


def describe_range(field: FieldInfo) -> str:
    """What a parameter may be."""
    kind = "a whole number" if field.annotation is int else "a number"
    limits = {
        sign: getattr(bound, name)
        for bound in field.metadata
        for name, sign in (("gt", ">"), ("ge", ">="), ("le", "<="))
        if getattr(bound, name, None) is not None
    }
    limited = " and".join(f" {word} {value:g}" for word, value in limits.items())
    return kind + limited


# Random obstacles drawn from the seed of a run: the table [random] of a layout.

STREAM = 1
"""Sets the random numbers of the obstacles apart from those that a run of the same seed starts
with."""


def draw_obstacles(world: World, seed: int) -> World:
    """A world with its random obstacles drawn: the same seed >= 0 gives the same ones.

    They come after its own obstacles, and bring a mission where it has none. A world without
    random obstacles is drawn already. Raises InputError if they do not fit, or if the world is not
    sound with them.

    >>> from worlds.layout import world
    >>> len(draw_obstacles(world("thesis-blocks"), 1).obstacles)
    20
    """
    if world.random is None:
        return world
    contents = draw(world.random, seed, world.low, world.size)
    task = contents.mission
    if task is not None and world.dim == 3:
        task = task.standing(world.height)
    described = f"drawn from seed {seed}: {world.random.described()}"
    drawn_world = replace(
        world,
        obstacles=(*world.obstacles, *contents.obstacles),
        random=None,
        mission=world.mission or task,
        source=f"{world.source}; {described}" if world.source else described,
    )
    demand_sound(drawn_world)
    return drawn_world


def draw(
    random: RandomObstacles, seed: int, low: tuple[float, ...], size: tuple[float, ...]
) -> GeneratedContents:
    """The obstacles of a seed >= 0 in the box [low, low + size), with their mission if any.

    Raises InputError if they do not fit.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"seed = {seed!r} is not allowed: a whole number >= 0")
    corner, sides = np.array(low[: random.dim]), np.array(size[: random.dim])
    rng = np.random.default_rng((int(seed), STREAM))
    return GENERATORS[random.kind].make(rng, corner, sides, random.parameters)


def random_obstacles(table: Any, dim: int, stands: bool, origin: str) -> RandomObstacles:
    """What the table [random] of a layout says, for a world of `dim` dimensions.

    `stands` is whether the layout is flat and its world is not; then the obstacles stay flat.
    Raises InputError naming the key and the value; `origin` is the layout.
    """
    if not isinstance(table, Mapping):
        raise InputError(f"random = {table!r} is not a table: write [random] ({origin})")
    values = dict(table)
    if "kind" not in values:
        raise InputError(f"[random] has no kind (known: {', '.join(GENERATORS)}) ({origin})")
    name = values.pop("kind")
    if name not in GENERATORS:
        raise unknown("kind of random obstacles", name, GENERATORS, origin)
    kind = GENERATORS[name]
    flat = stands or dim not in kind.dimensions
    chosen_dim = values.pop("dim", 2 if flat else dim)
    if isinstance(chosen_dim, bool) or chosen_dim not in kind.dimensions or chosen_dim > dim:
        allowed = " or ".join(str(d) for d in kind.dimensions if d <= dim)
        raise InputError(
            f"random.dim = {chosen_dim!r} is not allowed: {name} in a world of {dim} dimensions "
            f"are drawn in {allowed} ({origin})"
        )
    return RandomObstacles(name, check_parameters(kind, values, origin), chosen_dim)
