"""How a flock starts: positions and headings, random from the run's seed or given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from worlds.refusal import Refusal, unknown
from worlds.world import World

THETA_D = np.pi / 4
"""Heading of the information UAV (rad), theta^d of Liu et al. 2021, section 3.1."""


@dataclass(frozen=True)
class Start:
    """Where a flock begins; rows are agents."""

    position: np.ndarray
    heading: np.ndarray
    informed: np.ndarray


def random_headings(rng: np.random.Generator, n: int, dim: int) -> np.ndarray:
    """n unit vectors, uniform on the circle or the sphere, (n, dim)."""
    if dim == 2:
        theta = rng.uniform(0.0, 2.0 * np.pi, n)
        return np.column_stack([np.cos(theta), np.sin(theta)])
    vector = rng.normal(size=(n, 3))
    return vector / np.linalg.norm(vector, axis=1, keepdims=True)


def goal_heading(dim: int) -> np.ndarray:
    """The heading that information agents know, a unit vector (dim,)."""
    if dim == 2:
        return np.array([np.cos(THETA_D), np.sin(THETA_D)])
    return np.full(3, 3.0**-0.5)


def random_start(world: World, agents: int, informed: int, rng: np.random.Generator) -> Start:
    """`agents` ordinary and `informed` information agents, as Liu et al. 2021, section 3.1.

    Positions are uniform in the box and headings uniform; the first information agent is in the
    corner (0, 0), and all of them head for theta^d. Rows are numbered along space, so that agents
    near each other start near each other in memory; the information agents come first.
    """
    size = np.array(world.size)
    position = rng.uniform(0.0, 1.0, (agents, world.dim)) * size
    heading = random_headings(rng, agents, world.dim)
    position = position[along_space(position, size)]
    first = rng.uniform(0.0, 1.0, (informed, world.dim)) * size
    first[:1] = 0.0
    know = np.tile(goal_heading(world.dim), (informed, 1))
    return Start(
        np.concatenate([first, position]),
        np.concatenate([know, heading]),
        np.arange(agents + informed) < informed,
    )


def along_space(position: np.ndarray, size: np.ndarray) -> np.ndarray:
    """An order of the rows in which near agents are near each other: by strips of the box."""
    n, dim = position.shape
    strips = max(1.0, (n / 4.0) ** (1.0 / dim))
    cell = np.floor(position / size * strips)
    return np.lexsort(cell.T)


def given_start(world: World, arrays: Mapping[str, Any]) -> Start:
    """A start from arrays: `position` (N, dim), `heading` (N, dim), `informed` (N,) bool or none.

    Headings are brought to length 1. Raises Refusal naming the array, the row and the value where
    something is no finite number, has no direction, or does not fit.
    """
    for name in arrays:
        if name not in ("position", "heading", "informed"):
            raise unknown("start array", name, ("position", "heading", "informed"))
    for name in ("position", "heading"):
        if name not in arrays:
            raise Refusal(f"start has no {name!r}: position and heading, both (N, dim), are needed")
    position = rows("position", arrays["position"], world.dim)
    heading = rows("heading", arrays["heading"], world.dim)
    if len(position) != len(heading):
        raise Refusal(f"start has {len(position)} positions but {len(heading)} headings")
    if len(position) < 1:
        raise Refusal("start has 0 agents: at least 1 is needed")
    informed = np.asarray(arrays.get("informed", np.zeros(len(position), bool)))
    if informed.shape != (len(position),):
        raise Refusal(f"start array 'informed' has shape {informed.shape}, not ({len(position)},)")
    length = np.linalg.norm(heading, axis=1, keepdims=True)
    if (length == 0.0).any():
        row = int(np.flatnonzero(length == 0.0)[0])
        raise Refusal(f"heading of row {row} is a zero vector: a heading needs a direction")
    return Start(position, heading / length, informed.astype(bool))


def rows(name: str, values: object, dim: int) -> np.ndarray:
    """`values` as a float array (N, dim) of finite numbers. Raises Refusal."""
    try:
        array = np.array(values, float)
    except (TypeError, ValueError):
        raise Refusal(f"start array {name!r} is not an array of numbers") from None
    if array.ndim != 2 or array.shape[1] != dim:
        raise Refusal(f"start array {name!r} has shape {array.shape}, not (N, {dim})")
    if not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        value = array[row].tolist()
        raise Refusal(f"{name} of row {row} is {value}: every component must be a finite number")
    return array
