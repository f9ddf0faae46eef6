"""Runs of cars that are to stay near a place: Jacobs and Koessler, gallery figure 1."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from app.studies.kinds.driving import STOPS
from app.studies.kinds.kind_settings import COUNT, SUCCESS, Measure, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

CHUNK = 500
"""Ticks between two looks at whether the run is to end."""


class HoldingSettings(Settings):
    """How long cars drive, and when they are to have come."""

    kind: ClassVar[str] = "holding"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure(
            "held",
            "held",
            "Runs in which no car leaves the radius again",
            "%",
            whole=True,
            bounds=SUCCESS,
        ),
        Measure("furthest", "furthest", "Largest distance to the place, once they have come", "m"),
        Measure("mean", "mean", "Mean distance to the place, once they have come", "m"),
        Measure(
            "came",
            "came",
            "Time at which the last car comes within the radius",
            "s",
            "never",
            bounds=COUNT,
            limited=True,
        ),
        Measure(
            "collision", "collision", "Runs in which cars touch", "%", whole=True, bounds=SUCCESS
        ),
    )

    limit: float = Field(gt=0.0)
    """How long a run lasts, s."""
    radius: float = Field(gt=0.0)
    """The set radius, m."""
    late: float = Field(gt=0.0)
    """Time from which on cars count as having come, s."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Drive, and measure the distances. Raises InputError if there is no place to stay near."""
        away = self.distances(flock, self.driven(flock, between))
        kept = away[round(self.late / flock.dt) :]
        inside = np.flatnonzero((away <= self.radius).all(axis=1))
        touched = STOPS in flock.model.signals and bool(flock.signal(STOPS).any())
        return {
            "held": 100 * bool((kept <= self.radius).all()),
            "furthest": float(kept.max()),
            "mean": float(kept.mean()),
            "came": float(inside[0] * flock.dt) if len(inside) else None,
            "collision": 100 * touched,
        }

    def driven(self, flock: Flock, between: Callable[[], None] = lambda: None) -> np.ndarray:
        """Positions at every tick from 0 to the limit, (T + 1, N, 2), m."""
        if flock.world.mission is None or flock.world.mission.goal is None:
            raise InputError(
                f"the world {flock.world.name!r} has no place to stay near: it has no goal"
            )
        ticks = int(self.ticks(None, flock.dt))
        kept = [flock.position[None].copy()]
        while flock.tick < ticks:
            between()
            kept.append(flock.trace(min(CHUNK, ticks - flock.tick)))
        return np.concatenate(kept)

    def distances(self, flock: Flock, position: np.ndarray) -> np.ndarray:
        """Distances of positions (T, N, 2) from tick 0 on to the place, (T, N), m."""
        goal = flock.goal_at(np.arange(len(position)))
        return np.linalg.norm(position - goal[:, None], axis=2)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return round(self.limit / dt)
