"""The energy of theorem 1 over time, and how far from the goal a flock came beside the bound."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from agents.observables.energy import furthest, hamiltonian
from app.studies.experiment import Experiment, flock_of
from app.studies.measure import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# Runs over which the energy of theorem 1 of Wu et al. 2023 is followed.

NEGLIGIBLE = 1e-6
"""Share of H_0 that is no rise: rounding, and the potential of a pair that comes within r.

H as printed counts it from there on: 0.04 m^2/s^2 each, of the 1e5 that a flock starts with.
"""


class EnergySettings(Settings):
    """How long the energy is followed, and how often it is looked at."""

    kind: ClassVar[str] = "energy"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("ratio", "far/bound", "Largest distance to the goal over its bound", "1"),
        Measure("peak", "most H/H_0", "Largest energy after the start over that at the start", "1"),
        Measure("bound", "bound", "Bound of the distance to the goal", "m"),
        Measure("far", "far", "Largest distance to the goal", "m"),
        Measure("rises", "H rises", "Looks at which the energy has risen", "%"),
        Measure("rise", "rise", "Largest rise of the energy between two looks, of H_0", "%"),
    )

    limit: float = Field(gt=0.0)
    """Time over which a run is followed, s."""
    every: int = Field(1, ge=1)
    """Ticks between two looks."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Follow H and the distance to the goal."""
        energy, away = self.follow_flock(flock, between)
        change = np.diff(energy)
        bound = furthest(energy[0], flock.parameters)
        return {
            "ratio": float(away.max() / bound),
            "peak": float(energy[1:].max() / energy[0]),
            "bound": bound,
            "far": float(away.max()),
            "rises": 100.0 * float((change > NEGLIGIBLE * energy[0]).mean()),
            "rise": 100.0 * max(0.0, float(change.max() / energy[0])),
        }

    def follow_flock(
        self, flock: Flock, between: Callable[[], None] = lambda: None
    ) -> tuple[np.ndarray, np.ndarray]:
        """H (K,), m^2/s^2, and the largest distance to the goal (K,), m, at each look."""
        surroundings = flock.engine.surroundings
        points = np.column_stack([surroundings.point_x, surroundings.point_y])
        goal = np.zeros((2, flock.world.dim))
        goal[0] = flock.goal_at([0])[0]
        energy, away = [], []
        for look in range(round(self.limit / flock.dt / self.every) + 1):
            if look:
                between()
                flock.run(self.every)
            velocity = flock.speed[:, None] * flock.heading
            energy.append(hamiltonian(flock.position, velocity, goal, points, flock.parameters))
            away.append(np.linalg.norm(flock.position - goal[0], axis=1).max())
        return np.array(energy), np.array(away)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.limit / dt


COLOURS = ("#2166ac", "#b07d12", "#1f9d63", "#c0392b")


def draw_energy(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the runs of that seed, one of each row."""
    settings = experiment.settings
    assert isinstance(settings, EnergySettings)
    figure.set_size_inches(11.0, 4.8)
    left, right = figure.subplots(1, 2)
    for case, colour in zip(experiment.cases, COLOURS, strict=False):
        flock = flock_of(case, seed)
        energy, away = settings.follow_flock(flock)
        time = flock.dt * settings.every * np.arange(len(energy))
        left.plot(time, energy / energy[0], color=colour, linewidth=1.6, label=case.label)
        bound = np.sqrt(2.0 * energy[0] / flock.parameters.c1g)  # type: ignore[attr-defined]
        right.plot(time, away / bound, color=colour, linewidth=1.6, label=case.label)
    right.axhline(1.0, color="#c0392b", linewidth=1.4)
    right.set_ylim(0.0, 1.08)
    left.set_yscale("log")
    left.set_ylabel("$H / H_0$")
    right.set_ylabel("furthest agent from the goal / bound")
    for axes in (left, right):
        axes.set_xlabel("time / s")
    left.legend()


PICTURES = {"energy": draw_energy}
