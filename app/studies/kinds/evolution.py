"""Runs from disorder to consistency, measured at both ends: Liu et al. 2021, figure 4."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

from app.studies.kinds.convergence import ConvergenceSettings
from app.studies.kinds.kind_settings import SHARE, Measure, Number

if TYPE_CHECKING:
    from agents import Flock


class EvolutionSettings(ConvergenceSettings):
    """When a flock counts as consistent, and when a run is given up."""

    kind: ClassVar[str] = "evolution"
    measures: ClassVar[tuple[Measure, ...]] = (
        *ConvergenceSettings.measures,
        Measure("order_0", "order at 0", "Polarisation at the start", "1", bounds=SHARE),
        Measure("deg_0", "Deg_con at 0", "Degree of consistency (28) at the start", "1"),
        Measure("order", "order", "Polarisation when the run ends", "1", bounds=SHARE),
        Measure("deg", "Deg_con", "Degree of consistency (28) when the run ends", "1"),
    )

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """k_con (27), and the flock before and after; k_con is None if the run was given up."""
        before = {"order_0": order(flock), "deg_0": consistency(flock)}
        after = super().run(flock, between)
        return after | before | {"order": order(flock), "deg": consistency(flock)}


def order(flock: Flock) -> float:
    """The polarisation of a flock now, in [0, 1]."""
    return float(flock.observe("polarisation"))


def consistency(flock: Flock) -> float:
    """Deg_con (28) of a flock now, in [0, 1]."""
    return float(flock.observe("consistency"))
