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
from worlds.input_error import InputError, shortened, unknown
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
    made = draw(world.random, seed, world.low, world.size)
    task = made.mission
    if task is not None and world.dim == 3:
        task = task.standing(world.height)
    described = f"drawn from seed {seed}: {world.random.described()}"
    found = replace(
        world,
        obstacles=(*world.obstacles, *made.obstacles),
        random=None,
        mission=world.mission or task,
        source=f"{world.source}; {described}" if world.source else described,
    )
    demand_sound(found)
    return found


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
    given = dict(table)
    if "kind" not in given:
        raise InputError(f"[random] has no kind (known: {', '.join(GENERATORS)}) ({origin})")
    name = given.pop("kind")
    if name not in GENERATORS:
        raise unknown("kind of random obstacles", name, GENERATORS, origin)
    kind = GENERATORS[name]
    flat = stands or dim not in kind.dimensions
    chosen = given.pop("dim", 2 if flat else dim)
    if isinstance(chosen, bool) or chosen not in kind.dimensions or chosen > dim:
        allowed = " or ".join(str(d) for d in kind.dimensions if d <= dim)
        raise InputError(
            f"random.dim = {chosen!r} is not allowed: {name} in a world of {dim} dimensions are "
            f"drawn in {allowed} ({origin})"
        )
    return RandomObstacles(name, checked(kind, given, origin), chosen)
