"""Runs until a flock is consistent: Liu et al. 2021, section 3.1."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from agents.state.start import goal_heading
from app.studies.kinds.kind_settings import COUNT, HALF_TURN, Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

UNKNOWN_TICKS = 30.0
"""Ticks to convergence where nothing is published."""


class ConvergenceSettings(Settings):
    """When a flock counts as consistent, and when a run is given up."""

    kind: ClassVar[str] = "convergence"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure(
            "k_con",
            "k_con",
            "Time to consistency",
            "ticks",
            "not consistent",
            whole=True,
            bounds=COUNT,
            limited=True,
        ),
        Measure(
            "off",
            "off theta_d",
            "Angle of the mean heading to the reference state at the end",
            "deg",
            bounds=HALF_TURN,
        ),
    )

    desired: float = Field(gt=0.0, lt=1.0)
    hold: int = Field(ge=1)
    limit: int = Field(ge=1)

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """k_con (27); None if the run was given up."""
        k = flock.run_until_consistent(self.limit, self.desired, self.hold, between=between)
        return {"k_con": k, "off": from_reference(flock)}

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """The published time and the ticks for which it has to hold."""
        return (published or UNKNOWN_TICKS) + self.hold


def from_reference(flock: Flock) -> float:
    """Angle of the mean heading of a flock to the reference state, theta_d, degrees."""
    mean, reference = flock.heading.sum(0), goal_heading(flock.heading.shape[1])
    mean /= np.linalg.norm(mean)
    half = math.atan2(np.linalg.norm(mean - reference), np.linalg.norm(mean + reference))
    return math.degrees(2.0 * half)
