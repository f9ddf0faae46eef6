"""Runs of a mission from its start to the end: Liu et al. 2021, section 3.2; Wu et al. 2023."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from agents.mission_record import fly
from agents.observables.following import KERNELS
from app.studies.kinds.kind_settings import (
    COUNT,
    EITHER,
    RARE,
    RARE_PERCENT,
    Measure,
    Number,
    Settings,
)

if TYPE_CHECKING:
    from agents import Flock
    from agents.mission_record import MissionRecord


FAR = math.inf


class MissionSettings(Settings):
    """How long a mission may last, and when the flock counts as settled."""

    kind: ClassVar[str] = "mission"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("ticks", "ticks", "Ticks that the mission lasted", "ticks", whole=True),
        Measure(
            "arrived",
            "arrived",
            "Whether the path was flown to its end",
            "1",
            whole=True,
            bounds=EITHER,
        ),
        Measure(
            "success", "P_s", "Agents that have followed all the time", "%", bounds=RARE_PERCENT
        ),
        Measure(
            "d_obs",
            "D_obs",
            "Least distance to an obstacle",
            "length",
            "never near one",
            FAR,
            bounds=RARE,
        ),
        Measure(
            "d_ind",
            "D_ind",
            "Least distance of two that follow",
            "length",
            "none follow",
            FAR,
            bounds=RARE,
        ),
        Measure(
            "d_pair",
            "d_pair",
            "Least distance of two agents",
            "length",
            "one agent",
            FAR,
            bounds=RARE,
        ),
        Measure(
            "d_least",
            "d_least",
            "Least distance to anything",
            "length",
            "never near",
            FAR,
            bounds=RARE,
        ),
        Measure(
            "settled",
            "settled",
            "Time until the centre stays at the goal",
            "s",
            "never",
            FAR,
            bounds=COUNT,
            limited=True,
        ),
        Measure(
            "through",
            "through",
            "Agents that came to the goal",
            "%",
            "no goal",
            bounds=RARE_PERCENT,
        ),
    )
    measured_by: ClassVar[tuple[Callable, ...]] = KERNELS

    limit: float = Field(gt=0.0)
    """Time after which a run ends, in the body's unit: ticks or s."""
    within: float = Field(2.0, gt=0.0)
    """Distance of the flock's centre to the goal within which it is there, length."""
    spacing: float | None = Field(None, gt=0.0)
    """Distance that the agents of a flock at its goal keep, length."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Fly the mission and measure it."""
        ticks = round(self.limit / flock.dt)
        return self.measured(fly(flock, ticks, every=ticks, between=between))

    def measured(self, record: MissionRecord) -> dict[str, Number | None]:
        """The measures of a mission."""
        goal = len(record.away) > 0
        led = bool(record.informed.any())
        near = min(record.least_pair, record.least_obstacle)
        return {
            "ticks": record.ticks,
            "arrived": int(record.arrived),
            "success": 100.0 * record.success if led else None,
            "d_obs": finite(record.least_obstacle),
            "d_ind": finite(record.least_pair_of_followers) if led else None,
            "d_pair": finite(record.least_pair),
            "d_least": finite(near),
            "settled": record.settled(self.within) if goal else None,
            "through": 100.0 * record.through(self.spacing) if goal and self.spacing else None,
        }

    def limits_of(
        self, measure: Measure, values: Mapping[str, Sequence[Number | None]]
    ) -> list[float | None]:
        """As for all, but for a run that ended earlier, at the end of its path."""
        limits = super().limits_of(measure, values)
        ended = values.get("arrived")
        if not (measure.limited and ended):
            return limits
        return [None if early else limit for limit, early in zip(limits, ended, strict=True)]

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.limit / dt

    def compile(self, flock: Flock) -> None:
        """Compile what measures a mission."""
        fly(flock, 1)


def finite(value: float) -> float | None:
    """A distance; None for that to nothing, which is infinite."""
    return value if math.isfinite(value) else None
