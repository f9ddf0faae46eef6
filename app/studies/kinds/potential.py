"""The potential of Tanner et al. between two agents: Jacobs and Koessler, figure 1 and (1)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field
from scipy.optimize import minimize_scalar

from app.studies.kinds.kind_settings import Measure, Number, Settings
from app.studies.kinds.squash import SquashSettings

if TYPE_CHECKING:
    from agents import Flock

STEP = 1e-6
"""Of differences, as a share of the distance."""


def tanner_potential(r):
    """V(r) = 1 / r^2 + log r^2 (1) at distances r > 0, in the paper's unit of length.

    >>> float(tanner_potential(1.0))
    1.0
    """
    r = np.asarray(r, float)
    return (1.0 / r**2 + np.log(r**2))[()]


def tanner_slope(r):
    """dV/dr = 2 / r - 2 / r^3: the force between two agents; below 0 they repel each other.

    >>> float(tanner_slope(1.0))
    0.0
    """
    r = np.asarray(r, float)
    return (2.0 / r - 2.0 / r**3)[()]


class PotentialSettings(Settings):
    """Where the potential is looked at, at random distances that follow from the seed."""

    kind: ClassVar[str] = "potential"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("lowest", "lowest", "Distance at which the potential is lowest", "1"),
        Measure("least", "least", "The potential there", "1"),
        Measure("nearer", "nearer", "Largest slope at a smaller distance", "1"),
        Measure("farther", "farther", "Least slope at a larger distance", "1"),
        Measure("pull", "pull", "Largest slope: the strongest attraction", "1"),
        Measure("push", "push", "Strongest repulsion over strongest attraction", "1"),
        Measure("off", "off", "Largest error of the slope, from differences of (1)", "1"),
        Measure("cars", "cars", "Distance at which two cars do not affect each other", "m"),
    )

    near: float = Field(gt=0.0, lt=1.0)
    """The least distance."""
    far: float = Field(gt=1.0)
    """The largest distance."""
    looks: int = Field(200, ge=10)
    """Distances, evenly drawn on a logarithmic scale."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Look at the potential, and at what two cars do to each other; the flock needs two."""
        between()
        rng = np.random.default_rng(flock.seed)
        r = np.exp(rng.uniform(np.log(self.near), np.log(self.far), self.looks))
        found = minimize_scalar(tanner_potential, bounds=(self.near, self.far), method="bounded",
                                options={"xatol": 1e-9})  # fmt: skip
        lowest, slope = float(found.x), tanner_slope(r)
        step = STEP * r
        differences = (tanner_potential(r + step) - tanner_potential(r - step)) / (2.0 * step)
        return {
            "lowest": lowest,
            "least": float(found.fun),
            "nearer": float(slope[r < lowest].max()),
            "farther": float(slope[r > lowest].min()),
            "pull": float(slope.max()),
            "push": float(-slope.min() / slope.max()),
            "off": float((np.abs(differences - slope) / np.maximum(1.0, np.abs(slope))).max()),
            "cars": self.squash.zero(flock),
        }

    @property
    def squash(self) -> SquashSettings:
        """How two cars are looked at."""
        return SquashSettings(world=self.world, near=1e-6, far=100.0, looks=200)

    def ticks(self, published: float | None, dt: float) -> float:
        """Those of looking at the cars."""
        return self.squash.ticks(published, dt)
