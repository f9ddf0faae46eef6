"""Runs in which active particles are in each other's way: how fast they get on along their heading.

In the plane, among edges that wrap. The packing is the share of the area that the discs would cover
if they did not overlap.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.kinds.kind_settings import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock


class CrowdingSettings(Settings):
    """How long particles mix, and how often they are looked at."""

    kind: ClassVar[str] = "crowding"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("packing", "packing", "Share of the area that the discs cover", "1"),
        Measure("speed", "v/v0", "Velocity along the heading, of that of a free one", "1"),
        Measure("slope", "slope", "What of it is lost, over the packing", "1"),
    )

    lasts: int = Field(ge=0)
    """Ticks before they are looked at."""
    looks: int = Field(ge=1)
    """How often they are looked at, each time for a tick."""
    every: int = Field(ge=1)
    """Ticks between two looks."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let them mix, then look at them."""
        p: Any = flock.parameters
        between()
        flock.run(self.lasts)
        seen = []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            seen.append(along(flock))
        area = float(np.prod(flock.world.size))
        packing = len(flock.ids) * math.pi * p.d**2 / (4.0 * area)
        speed = float(np.mean(seen)) / p.v0
        return {"packing": packing, "speed": speed, "slope": (1.0 - speed) / packing}

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.lasts + self.looks * (self.every + 1)


def along(flock: Flock) -> float:
    """The mean velocity along the heading in the next tick, length/s."""
    before, heading = flock.position.copy(), flock.heading.copy()
    flock.run(1)
    step = flock.position - before
    size = np.array(flock.world.size)
    step = step - np.where(flock.world.images, size * np.round(step / size), 0.0)
    return float((step * heading).sum(axis=1).mean()) / flock.dt
