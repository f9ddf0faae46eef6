"""Runs in which a flock is left alone until its order is steady: Vicsek et al. 1995, figure 2."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from agents.observables.neighbours import nearest_neighbour
from app.studies.kinds.kind_settings import SHARE, Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock


class OrderingSettings(Settings):
    """How long a flock is left alone, and how often it is looked at then."""

    kind: ClassVar[str] = "ordering"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("order", "order", "Polarisation, mean over time", "1", bounds=SHARE),
        Measure("binder", "G", "Binder cumulant of the polarisation over time", "1"),
        Measure("chi", "chi", "N times the variance of the polarisation over time", "1"),
        Measure("d_pair", "d_pair", "Least distance of two agents", "length", "one agent"),
    )

    settle: int = Field(ge=0)
    """Ticks before a flock is looked at, from its start."""
    looks: int = Field(ge=2)
    """How often it is looked at; the measures are over the looks."""
    every: int = Field(ge=1)
    """Ticks between two looks."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let the flock settle, then look at it."""
        between()
        flock.run(self.settle)
        seen, least = np.empty(self.looks), math.inf
        for k in range(self.looks):
            between()
            flock.run(self.every)
            seen[k] = flock.observe("polarisation")
            near = nearest_neighbour(flock.position, flock.world.size, flock.world.images)
            least = min(least, near.min(initial=math.inf))
        return {
            "order": float(seen.mean()),
            "binder": binder(seen),
            "chi": len(flock.ids) * float(seen.var()),
            "d_pair": least if math.isfinite(least) else None,
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.settle + self.looks * self.every


def binder(order: np.ndarray) -> float:
    """Binder's cumulant 1 - <phi^4> / (3 <phi^2>^2) of orders (T,), Grégoire and Chaté 2004.

    2/3 for an order that does not change, 1/3 for the length of a mean of many independent vectors
    of the plane, and below both, even below 0, where the flock is now ordered and now not.

    >>> round(binder(np.full(5, 0.8)), 3)
    0.667
    """
    second = float((order**2).mean())
    return 1.0 - float((order**4).mean()) / (3.0 * second * second) if second > 0.0 else 0.0
