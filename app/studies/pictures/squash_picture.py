"""The squashing function: the formula as a line, what one car does to another as dots."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.squash import SquashSettings
from app.studies.trial import flock_of

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
