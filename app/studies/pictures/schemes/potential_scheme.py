"""The potential of Tanner et al. and its slope, with what two cars do to each other beside it."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.potential import PotentialSettings, tanner_potential, tanner_slope
from app.studies.pictures.boxes import explain
from app.studies.pictures.schemes.scheme_marks import INK, sign, stroke
from app.studies.trial import flock_of

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
    zero = settings.squash.zero(flock)
    looked = np.linspace(SHOWN[0] * zero, SHOWN[1] * zero, LOOKS)
    right.plot(
        looked / zero, settings.squash.curve(flock, looked), "o", color=CARS, markersize=4, zorder=6
    )
    right.set_ylim(-3.0, 1.3)
    right.set_title("the slope: below 0 they repel each other", loc="left")
    right.set_ylabel("dV/dr, and the squashing function")
    for axes, low in ((left, 0.94), (right, 0.04)):
        axes.text(0.5, low, "repel", transform=axes.get_xaxis_transform(), ha="center", color=CARS)
        axes.text(
            3.6, low, "attract", transform=axes.get_xaxis_transform(), ha="center", color=CURVE
        )
    explain(
        figure,
        [
            stroke(CURVE, "Tanner et al., (1)"),
            sign(CARS, "(3), as two cars carry it out", "o"),
            sign(INK, "no force", "D"),
        ],
        f"the paper names no unit of (1); cars do not affect each other at {zero:.3f} m, which is "
        "1 here; the ranges of the axes are ours",
    )
