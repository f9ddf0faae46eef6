"""How far free active particles come over time, beside the closed form, on logarithmic scales."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.experiment import Experiment, flock_of
from app.studies.measure import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# Runs in which free active particles wander: how far they come, beside the closed form.
#
# With tau = 1 / ((dim - 1) D_r), the time in which a heading is forgotten,
#
#     <r^2>(t) = 2 dim D_t t + 2 (v0 tau)^2 (t / tau - 1 + exp(-t / tau))
#
# (Bechinger et al. 2016, (8), in the plane; the same in space with that tau). For t much below tau
# it is (v0 t)^2, far above 2 dim D t with D = D_t + v0^2 tau / dim: v0^2 / (2 D_r) in the plane,
# v0^2 / (6 D_r) in space.


class DiffusionSettings(Settings):
    """When particles are looked at, in times tau; the world has no edges, nobody feels anybody."""

    kind: ClassVar[str] = "diffusion"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("short", "short", "Mean square displacement over the closed form, early", "1"),
        Measure("middle", "middle", "The same after a time tau", "1"),
        Measure("long", "long", "The same late", "1"),
        Measure("D", "D", "Diffusion, from the second half of the run, over the closed form", "1"),
        Measure("turned", "turned", "<u(tau) . u(0)>, times e", "1"),
    )

    short: float = Field(0.1, gt=0.0, lt=1.0)
    """The first look, tau."""
    long: float = Field(gt=2.0)
    """The last look, tau."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Follow the particles from where they are."""
        p: Any = flock.parameters
        dim = flock.world.dim
        tau = 1.0 / ((dim - 1) * p.D_r)
        place, heading = flock.position.copy(), flock.heading.copy()
        moments: dict[float, tuple[float, float]] = {}
        turned = np.nan
        for after in (self.short, 1.0, 0.5 * self.long, self.long):
            between()
            flock.run(round(after * tau / flock.dt) - flock.tick)
            r2 = float(((flock.position - place) ** 2).sum(axis=1).mean())
            moments[after] = (r2, squared_displacement(flock.elapsed, dim, tau, p.v0, p.D_t))
            if after == 1.0:
                turned = float((flock.heading * heading).sum(axis=1).mean())
        half, whole = moments[0.5 * self.long], moments[self.long]
        return {
            "short": moments[self.short][0] / moments[self.short][1],
            "middle": moments[1.0][0] / moments[1.0][1],
            "long": whole[0] / whole[1],
            "D": (whole[0] - half[0]) / (whole[1] - half[1]),
            "turned": turned * math.e,
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """About, for a tau of one second."""
        return self.long / dt


def squared_displacement(t: float, dim: int, tau: float, v0: float, D_t: float) -> float:
    """<r^2>(t), length^2.

    >>> squared_displacement(2.0, 2, 1e9, 3.0, 0.0) / (3.0 * 2.0) ** 2 > 0.999
    True
    """
    s = t / tau
    return float(2.0 * dim * D_t * t + 2.0 * (v0 * tau) ** 2 * (s + np.expm1(-s)))


COLOURS = ("#2166ac", "#c0392b", "#1b7837")
LOOKS = 24
FIRST, LAST = 0.02, 12.0
"""Of what is shown, in times tau."""


def draw_diffusion(figure: Any, experiment: Experiment, seed: int) -> None:
    """A line and dots for each row."""
    figure.set_size_inches(8.0, 5.6)
    axes = figure.subplots()
    for case, colour in zip(experiment.cases, COLOURS, strict=False):
        flock = flock_of(case, seed)
        p: Any = flock.parameters
        dim = flock.world.dim
        tau = 1.0 / ((dim - 1) * p.D_r)
        place = flock.position.copy()
        time, found = [], []
        for after in np.geomspace(FIRST, LAST, LOOKS):
            ticks = round(float(after) * tau / flock.dt)
            if ticks > flock.tick:
                flock.run(ticks - flock.tick)
                time.append(flock.elapsed / tau)
                found.append(float(((flock.position - place) ** 2).sum(axis=1).mean()))
        s = np.geomspace(FIRST, LAST, 200)
        expected = [squared_displacement(float(value) * tau, dim, tau, p.v0, p.D_t) for value in s]
        axes.plot(s, expected, color=colour, linewidth=1.6)
        axes.plot(time, found, "o", color=colour, markersize=4.5, label=case.label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("time, of that in which a heading is forgotten")
    axes.set_ylabel("mean square displacement / length$^2$")
    axes.legend()
    draw_key(figure, [], f"dots: the run of seed {seed}; lines: the closed form")


PICTURES = {"diffusion": draw_diffusion}
