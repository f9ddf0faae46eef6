"""The squashing function: the formula as a line, what one car does to another as dots."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.experiment import Experiment, flock_of
from app.studies.measure import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# The squashing function of Jacobs and Koessler as cars that turn on the spot carry it out.

HALVINGS = 50
"""Halvings of the interval in which the zero is sought."""


class SquashSettings(Settings):
    """Where the function is looked at: two cars are put down so far apart and go on for a tick."""

    kind: ClassVar[str] = "squash"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("zero", "zero", "Distance at which cars do not affect each other", "m"),
        Measure("touching", "at 0", "The function where cars touch", "1"),
        Measure("distant", "far", "The function far away", "1"),
        Measure("formula", "C g/(1-C)", "Distance at which the formula is 0", "m"),
        Measure("error", "error", "Largest difference from the formula (3)", "1"),
    )

    near: float = Field(1e-6, gt=0.0)
    """The least distance, m."""
    far: float = Field(gt=0.0)
    """The largest distance, m."""
    looks: int = Field(200, ge=2)
    """Distances at which it is compared with the formula, evenly on a logarithmic scale."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Measure what one car does to another; the flock needs two."""
        between()
        r = np.geomspace(self.near, self.far, self.looks)
        squashed = self.curve(flock, r)
        p = flock.parameters
        beta, c, gamma = p.beta, p.C, p.gamma  # type: ignore[attr-defined]
        return {
            "zero": self.zero(flock),
            "touching": float(squashed[0]),
            "distant": float(squashed[-1]),
            "formula": c * gamma / (1.0 - c),
            "error": float(np.abs(squashed - beta * (r / (r + gamma) - c)).max()),
        }

    def curve(self, flock: Flock, r: np.ndarray) -> np.ndarray:
        """sigma at distances (K,) > 0, m: how fast a car goes towards another, over the gain."""
        return np.array([self.pull_at(flock, distance) for distance in r])

    def pull_at(self, flock: Flock, r: float) -> float:
        """sigma at one distance r, m; above 0 cars attract each other."""
        middle = np.array(flock.world.low) + 0.5 * np.array(flock.world.size)
        flock.position[:] = middle
        flock.position[1, 0] += r
        flock.run(1)
        gain: float = flock.parameters.gain  # type: ignore[attr-defined]
        return float(flock.heading[0, 0] * flock.speed[0] / gain)

    def zero(self, flock: Flock) -> float:
        """The distance at which sigma is 0, m; by halving the interval [near, far]."""
        low, high = self.near, self.far
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if self.pull_at(flock, middle) < 0.0:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """One for each look."""
        return self.looks + HALVINGS


LINE, DOTS, INK = "#2166ac", "#c0392b", "#3c434b"
SHOWN = 3.0
"""The largest distance that is shown, m."""
LOOKS = 25


def draw_squash(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the curve of the first row's parameters, its zero and its bounds."""
    settings = experiment.settings
    assert isinstance(settings, SquashSettings)
    flock = flock_of(experiment.cases[0], seed)
    p: Any = flock.parameters
    r = np.linspace(0.0, SHOWN, 400)
    looked = np.linspace(0.02, SHOWN - 0.02, LOOKS)
    figure.set_size_inches(8.0, 5.0)
    axes = figure.subplots()
    axes.axhline(0.0, color=INK, linewidth=0.8)
    for bound, words in (
        (p.beta * (1.0 - p.C), "$\\beta (1 - C)$, far away"),
        (-p.beta * p.C, "$-\\beta C$, touching"),
    ):
        axes.axhline(bound, color=INK, linewidth=0.9, linestyle=(0, (4, 3)))
        axes.text(SHOWN, bound + 0.03, f"{words}: {bound:.2g}", ha="right", fontsize=9, color=INK)
    label = "(3)"
    axes.plot(r, p.beta * (r / (r + p.gamma) - p.C), color=LINE, linewidth=2.2, label=label)
    axes.plot(
        looked, settings.curve(flock, looked), "o", color=DOTS, markersize=4.5, label="the cars"
    )
    zero = settings.zero(flock)
    axes.plot([zero], [0.0], "D", color=INK, markersize=7, zorder=5)
    axes.annotate(
        f"zero at {zero:.4f} m", (zero, 0.0), (14, -18), textcoords="offset points", color=INK
    )
    axes.set_xlim(0.0, SHOWN)
    axes.set_xlabel("distance / m")
    axes.set_ylabel("$\\sigma$: below 0 cars repel each other")
    axes.legend(loc="center right")


PICTURES = {"squash": draw_squash}
