"""Runs in which people walk both ways along a corridor: Helbing and Molnar 1995, figure 2."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from agents.observables.lanes import lane_order
from app.studies.kinds.kind_settings import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

WAY = "way_x"
"""The signal that tells where an agent wants to go along the corridor, +1 or -1."""
DEALS = 40
"""How often the ways are dealt out anew to tell what a mixed crowd would have."""


class LaneSettings(Settings):
    """How long people walk before they are looked at, how often, and how wide a strip is."""

    kind: ClassVar[str] = "lanes"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("order", "order", "Lane order", "1"),
        Measure("mixed", "mixed", "Lane order of the same places, the ways dealt by chance", "1"),
        Measure("gain", "gain", "Lane order above that of ways dealt by chance", "1"),
        Measure("start", "start", "Lane order at the start", "1"),
        Measure("progress", "progress", "Mean speed along the own way, of the mean desired", "%"),
    )

    settle: int = Field(ge=1)
    """Ticks before people are looked at."""
    looks: int = Field(ge=1)
    """How often they are looked at; the measures are means over the looks."""
    every: int = Field(ge=1)
    """Ticks between two looks."""
    width: float = Field(gt=0.0)
    """Of the strips in which ways are counted, m."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let people walk, then look at them."""
        between()
        begun = self.order(flock, ways_of(flock))
        flock.run(self.settle)
        seen = []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            ways = ways_of(flock)
            dealt = [self.order(flock, flock.rng.permutation(ways)) for _ in range(DEALS)]
            gone = flock.speed * (flock.heading[:, 0] * ways)
            seen.append((self.order(flock, ways), np.mean(dealt), gone.mean()))
        order, mixed, gone = (float(mean) for mean in np.mean(seen, axis=0))
        return {
            "order": order,
            "mixed": mixed,
            "gain": order - mixed,
            "start": begun,
            "progress": 100.0 * gone / flock.parameters.v0,  # type: ignore[attr-defined]
        }

    def order(self, flock: Flock, ways: np.ndarray) -> float:
        """The lane order of people who want to go these ways (N,), +1 or -1."""
        aims = np.column_stack([ways, np.zeros(len(ways))])
        size = np.array(flock.world.size)
        return lane_order(flock.position, aims, size, flock.world.images, self.width)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.settle + self.looks * self.every


def ways_of(flock: Flock) -> np.ndarray:
    """Where each of the flock wants to go along the corridor, +1 or -1, (N,)."""
    return flock.signal(WAY)
