"""How flocks begin: the flock at tick 0, before anything has moved; thesis, figures 5.3 and 5.6."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from agents.observables.order import polarisation
from app.studies.kinds.kind_settings import RARE, SHARE, Measure, Number, Settings
from worlds.queries.surface import clearance

if TYPE_CHECKING:
    from agents import Flock


class BeginningSettings(Settings):
    """Nothing is to be said but the world: a flock is made, and looked at."""

    kind: ClassVar[str] = "beginning"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("agents", "agents", "Agents that fly", "agents", whole=True),
        Measure("obstacles", "obstacles", "Obstacles", "obstacles", whole=True),
        Measure(
            "crashed", "crashed", "Agents that have crashed", "agents", whole=True, bounds=RARE
        ),
        Measure(
            "inside",
            "inside",
            "Agents inside an obstacle or out of the box",
            "agents",
            whole=True,
            bounds=RARE,
        ),
        Measure("clear", "clear", "Least distance to what is solid", "length", "nothing is solid"),
        Measure("pair", "pair", "Least distance of two agents", "length", "one agent"),
        Measure("p", "p", "Polarisation", "1", bounds=SHARE),
        Measure("speed", "speed", "Mean speed", "length/s"),
        Measure("spread", "spread", "Standard deviation of the speeds", "length/s"),
    )

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Measure the flock as it is made."""
        between()
        low, size = np.array(flock.world.low), np.array(flock.world.size)
        clear = clearance(flock.world, flock.position)
        out = ((flock.position < low) | (flock.position > low + size)).any(axis=1)
        pairs = gaps(flock)
        solid = flock.world.is_solid
        return {
            "agents": int(flock.active.sum()),
            "obstacles": len(flock.world.obstacles),
            "crashed": len(flock.crashes.tick),
            "inside": int((out | (solid & (clear <= 0.0))).sum()),
            "clear": float(clear.min()) if solid else None,
            "pair": float(pairs.min()) if len(pairs) > 1 else None,
            "p": polarisation(flock.heading),
            "speed": float(flock.speed.mean()),
            "spread": float(flock.speed.std()),
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """None is run; making a flock counts as one."""
        return 1.0


def gaps(flock: Flock) -> np.ndarray:
    """Distance of each agent to the nearest other one, (N,), length; across edges that wrap."""
    apart = flock.position[:, None] - flock.position
    size = np.where(flock.world.images, flock.world.size, np.inf)
    apart -= np.where(np.isinf(size), 0.0, size) * np.round(apart / size)
    distance = np.linalg.norm(apart, axis=2)
    np.fill_diagonal(distance, np.inf)
    return distance.min(axis=1)
