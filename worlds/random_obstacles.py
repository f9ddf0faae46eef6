"""Obstacles that a world draws from the seed of a run: the table [random] of a layout."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from worlds.refusal import Refusal, unknown

if TYPE_CHECKING:
    from worlds.generators.kind import Kind, Made, Parameters

STREAM = 1
"""Sets the random numbers of the obstacles apart from those that a run of the same seed starts
with."""


def kinds() -> dict[str, Kind]:
    """The kinds of random obstacles by name; they make worlds themselves, and so import this."""
    from worlds.generators import GENERATORS

    return GENERATORS


@dataclass(frozen=True)
class RandomObstacles:
    """What a world draws: a kind of `worlds.generators`, its parameters, flat or in space."""

    kind: str
    parameters: Parameters
    dim: int
    """2 for flat obstacles, which stand up in a world of three dimensions; 3 for solids in it."""

    def draw(self, seed: int, low: tuple[float, ...], size: tuple[float, ...]) -> Made:
        """The obstacles of a seed >= 0 in the box [low, low + size), with their mission if any.

        Raises Refusal if they do not fit.
        """
        if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
            raise Refusal(f"seed = {seed!r} is not allowed: a whole number >= 0")
        corner, sides = np.array(low[: self.dim]), np.array(size[: self.dim])
        rng = np.random.default_rng((int(seed), STREAM))
        return kinds()[self.kind].make(rng, corner, sides, self.parameters)

    def told(self) -> str:
        """Kind and parameters, for the source of a drawn world."""
        given = ", ".join(f"{k} = {value:g}" for k, value in self.parameters.model_dump().items())
        return f"{self.kind}: {given}"

    def to_table(self) -> dict[str, Any]:
        """The table that `random_obstacles` makes this of again."""
        return {"kind": self.kind, "dim": self.dim, **self.parameters.model_dump()}


def random_obstacles(table: Any, dim: int, stands: bool, origin: str) -> RandomObstacles:
    """What the table [random] of a layout says, for a world of `dim` dimensions.

    `stands` is whether the layout is flat and its world is not; then the obstacles stay flat.
    Raises Refusal naming the key and the value; `origin` is the layout.
    """
    from worlds.generators.generate import checked

    if not isinstance(table, Mapping):
        raise Refusal(f"random = {table!r} is not a table: write [random] ({origin})")
    given = dict(table)
    if "kind" not in given:
        raise Refusal(f"[random] has no kind (known: {', '.join(kinds())}) ({origin})")
    name = given.pop("kind")
    if name not in kinds():
        raise unknown("kind of random obstacles", name, kinds(), origin)
    kind = kinds()[name]
    flat = stands or dim not in kind.dimensions
    chosen = given.pop("dim", 2 if flat else dim)
    if isinstance(chosen, bool) or chosen not in kind.dimensions or chosen > dim:
        allowed = " or ".join(str(d) for d in kind.dimensions if d <= dim)
        raise Refusal(
            f"random.dim = {chosen!r} is not allowed: {name} in a world of {dim} dimensions are "
            f"drawn in {allowed} ({origin})"
        )
    return RandomObstacles(name, checked(kind, given, origin), chosen)
