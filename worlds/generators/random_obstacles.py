"""Random obstacles drawn from the seed of a run: the table [random] of a layout."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from worlds.checks import demand_sound
from worlds.generators.generate import GENERATORS, checked
from worlds.generators.world_generator import GeneratedContents
from worlds.input_error import InputError, unknown
from worlds.world import RandomObstacles, World

STREAM = 1
"""Sets the random numbers of the obstacles apart from those that a run of the same seed starts
with."""


def drawn(world: World, seed: int) -> World:
    """A world with its random obstacles drawn: the same seed >= 0 gives the same ones.

    They come after its own obstacles, and bring a mission where it has none. A world without
    random obstacles is drawn already. Raises InputError if they do not fit, or if the world is not
    sound with them.

    >>> from worlds.layout import world
    >>> len(drawn(world("thesis-blocks"), 1).obstacles)
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
