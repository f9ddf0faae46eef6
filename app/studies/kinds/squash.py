"""The squashing function of Jacobs and Koessler as cars that turn on the spot carry it out."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from app.studies.kinds.kind_settings import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

HALVINGS = 50
"""Halvings of the interval in which the zero is sought."""


class SquashSettings(Settings):
    """Where the function is looked at: two cars are put down so far apart and go on for a tick."""

    kind: ClassVar[str] = "squash"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("zero", "zero", "Distance at which cars do not affect each other", "m"),
        Measure("touching", "at 0", "The function where cars touch", "1"),
        Measure("distant", "far", "The function far away", "1"),
        Measure("formula", "C g/(1-C)", "Distance at which the formula is 0", "m"),
        Measure("error", "error", "Largest difference from the formula (3)", "1"),
    )

    near: float = Field(1e-6, gt=0.0)
    """The least distance, m."""
    far: float = Field(gt=0.0)
    """The largest distance, m."""
    looks: int = Field(200, ge=2)
    """Distances at which it is compared with the formula, evenly on a logarithmic scale."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Measure what one car does to another; the flock needs two."""
        between()
        r = np.geomspace(self.near, self.far, self.looks)
        found = self.curve(flock, r)
        p = flock.parameters
        beta, c, gamma = p.beta, p.C, p.gamma  # type: ignore[attr-defined]
        return {
            "zero": self.zero(flock),
            "touching": float(found[0]),
            "distant": float(found[-1]),
            "formula": c * gamma / (1.0 - c),
            "error": float(np.abs(found - beta * (r / (r + gamma) - c)).max()),
        }

    def curve(self, flock: Flock, r: np.ndarray) -> np.ndarray:
        """sigma at distances (K,) > 0, m: how fast a car goes towards another, over the gain."""
        return np.array([self.pull(flock, one) for one in r])

    def pull(self, flock: Flock, r: float) -> float:
        """sigma at one distance r, m; above 0 cars attract each other."""
        middle = np.array(flock.world.low) + 0.5 * np.array(flock.world.size)
        flock.position[:] = middle
        flock.position[1, 0] += r
        flock.run(1)
        gain: float = flock.parameters.gain  # type: ignore[attr-defined]
        return float(flock.heading[0, 0] * flock.speed[0] / gain)

    def zero(self, flock: Flock) -> float:
        """The distance at which sigma is 0, m; by halving the interval [near, far]."""
        low, high = self.near, self.far
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if self.pull(flock, middle) < 0.0:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """One for each look."""
        return self.looks + HALVINGS
