"""The potential of Tanner et al. and its slope, with what two cars do to each other beside it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field
from scipy.optimize import minimize_scalar

from app.studies.charts.boxes import draw_key
from app.studies.charts.scheme_marks import INK, sign, stroke
from app.studies.experiment import Experiment, flock_of
from app.studies.figures.squash import SquashSettings
from app.studies.measure import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# The potential of Tanner et al. between two agents: Jacobs and Koessler, figure 1 and (1).

STEP = 1e-6
"""Of differences, as a share of the distance."""


def tanner_potential(r):
    """V(r) = 1 / r^2 + log r^2 (1) at distances r > 0, in the paper's unit of length.

    >>> float(tanner_potential(1.0))
    1.0
    """
    r = np.asarray(r, float)
    return (1.0 / r**2 + np.log(r**2))[()]


def tanner_slope(r):
    """dV/dr = 2 / r - 2 / r^3: the force between two agents; below 0 they repel each other.

    >>> float(tanner_slope(1.0))
    0.0
    """
    r = np.asarray(r, float)
    return (2.0 / r - 2.0 / r**3)[()]


class PotentialSettings(Settings):
    """Where the potential is looked at, at random distances that follow from the seed."""

    kind: ClassVar[str] = "potential"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("lowest", "lowest", "Distance at which the potential is lowest", "1"),
        Measure("least", "least", "The potential there", "1"),
        Measure("nearer", "nearer", "Largest slope at a smaller distance", "1"),
        Measure("farther", "farther", "Least slope at a larger distance", "1"),
        Measure("pull", "pull", "Largest slope: the strongest attraction", "1"),
        Measure("push", "push", "Strongest repulsion over strongest attraction", "1"),
        Measure("off", "off", "Largest error of the slope, from differences of (1)", "1"),
        Measure("cars", "cars", "Distance at which two cars do not affect each other", "m"),
    )

    near: float = Field(gt=0.0, lt=1.0)
    """The least distance."""
    far: float = Field(gt=1.0)
    """The largest distance."""
    looks: int = Field(200, ge=10)
    """Distances, evenly drawn on a logarithmic scale."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Look at the potential, and at what two cars do to each other; the flock needs two."""
        between()
        rng = np.random.default_rng(flock.seed)
        r = np.exp(rng.uniform(np.log(self.near), np.log(self.far), self.looks))
        minimum = minimize_scalar(tanner_potential, bounds=(self.near, self.far), method="bounded",
                                options={"xatol": 1e-9})  # fmt: skip
        lowest, slope = float(minimum.x), tanner_slope(r)
        step = STEP * r
        differences = (tanner_potential(r + step) - tanner_potential(r - step)) / (2.0 * step)
        return {
            "lowest": lowest,
            "least": float(minimum.fun),
            "nearer": float(slope[r < lowest].max()),
            "farther": float(slope[r > lowest].min()),
            "pull": float(slope.max()),
            "push": float(-slope.min() / slope.max()),
            "off": float((np.abs(differences - slope) / np.maximum(1.0, np.abs(slope))).max()),
            "cars": self.squash_settings.zero(flock),
        }

    @property
    def squash_settings(self) -> SquashSettings:
        """How two cars are looked at."""
        return SquashSettings(world=self.world, near=1e-6, far=100.0, looks=200)

    def ticks(self, published: float | None, dt: float) -> float:
        """Those of looking at the cars."""
        return self.squash_settings.ticks(published, dt)


CURVE, CARS = "#2166ac", "#c0392b"
REPELS, ATTRACTS = "#fbf1ec", "#eef3fb"
SHOWN = 0.4, 5.0
"""Distances that are shown, of the paper's unit."""
HIGH = 6.5
LOOKS = 30


def draw_potential(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the potential left; right its slope, and the squashing function of the first row."""
    settings = experiment.settings
    assert isinstance(settings, PotentialSettings)
    flock = flock_of(experiment.cases[0], seed)
    r = np.linspace(*SHOWN, 800)
    figure.set_size_inches(12.0, 5.0)
    left, right = figure.subplots(1, 2)
    for axes in (left, right):
        axes.axvspan(0.0, 1.0, color=REPELS, zorder=0)
        axes.axvspan(1.0, SHOWN[1], color=ATTRACTS, zorder=0)
        axes.set_xlim(0.0, SHOWN[1])
        axes.set_xlabel("distance / the distance at which the force is 0")
    left.plot(r, tanner_potential(r), color=CURVE, linewidth=2.2)
    left.plot([1.0], [1.0], "D", color=INK, markersize=7, zorder=5)
    left.annotate("lowest: V(1) = 1", (1.0, 1.0), (12, -16), textcoords="offset points", color=INK)
    left.set_ylim(0.0, HIGH)
    left.set_title("(1)  V = 1 / r² + log r²", loc="left")
    left.set_ylabel("V")
    right.axhline(0.0, color=INK, linewidth=0.8)
    right.plot(r, tanner_slope(r), color=CURVE, linewidth=2.2)
    peak = float(np.sqrt(3.0))
    right.annotate(
        f"strongest attraction: {tanner_slope(peak):.2f} at {peak:.2f}", (peak, tanner_slope(peak)),
        (10, 10), textcoords="offset points", color=CURVE, fontsize=9,
    )  # fmt: skip
    zero = settings.squash_settings.zero(flock)
    looked = np.linspace(SHOWN[0] * zero, SHOWN[1] * zero, LOOKS)
    right.plot(
        looked / zero,
        settings.squash_settings.curve(flock, looked),
        "o",
        color=CARS,
        markersize=4,
        zorder=6,
    )
    right.set_ylim(-3.0, 1.3)
    right.set_title("the slope: below 0 they repel each other", loc="left")
    right.set_ylabel("dV/dr, and the squashing function")
    for axes, low in ((left, 0.94), (right, 0.04)):
        axes.text(0.5, low, "repel", transform=axes.get_xaxis_transform(), ha="center", color=CARS)
        axes.text(
            3.6, low, "attract", transform=axes.get_xaxis_transform(), ha="center", color=CURVE
        )
    draw_key(
        figure,
        [
            stroke(CURVE, "Tanner et al., (1)"),
            sign(CARS, "(3), as two cars carry it out", "o"),
            sign(INK, "no force", "D"),
        ],
        f"the paper names no unit of (1); cars do not affect each other at {zero:.3f} m, which is "
        "1 here; the ranges of the axes are ours",
    )


PICTURES = {"potential": draw_potential}
