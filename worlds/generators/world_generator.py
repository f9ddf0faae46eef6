"""What a kind of random world is: its parameters and the function that draws it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from worlds.mission import Mission
from worlds.obstacles import Obstacle


class GeneratorParameters(BaseModel):
    """Parameters of a kind: numbers, each with a range and what it is."""

    model_config = ConfigDict(frozen=True, extra="forbid")


@dataclass(frozen=True)
class GeneratedContents:
    """What a kind has drawn."""

    obstacles: list[Obstacle]
    mission: Mission | None = None


@dataclass(frozen=True)
class WorldGenerator:
    """A kind of random world.

    `make(rng, low, size, parameters)` draws its obstacles into the box [low, low + size]; `low` and
    `size` are (dim,) arrays in metres. It raises InputError if they do not fit.
    """

    name: str
    title: str
    parameters: type[GeneratorParameters]
    make: Callable[[np.random.Generator, np.ndarray, np.ndarray, Any], GeneratedContents]
    dimensions: tuple[int, ...] = (2,)


def length(default: float, description: str, least: float | None = None) -> Any:
    """A parameter that is a length in metres: > 0, or at least `least`."""
    above = 0.0 if least is None else None
    return Field(default, description=f"{description}, m", allow_inf_nan=False, gt=above, ge=least)


def count(default: int, description: str, least: int = 1, most: int = 100_000) -> Any:
    """A parameter that is a whole number."""
    return Field(default, description=description, ge=least, le=most, strict=True)


def share(default: float, description: str) -> Any:
    """A parameter in [0, 1]."""
    return Field(default, description=description, ge=0.0, le=1.0, allow_inf_nan=False)


def box_text(size: np.ndarray) -> str:
    """A box as a message shows it.

    >>> box_text(np.array([60.0, 40.0]))
    '60 x 40 m'
    """
    return " x ".join(f"{side:g}" for side in size) + " m"
