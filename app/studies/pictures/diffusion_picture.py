"""How far free active particles come over time, beside the closed form, on logarithmic scales."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.diffusion import squared_displacement
from app.studies.pictures.boxes import explain
from app.studies.trial import flock_of

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
        known = [squared_displacement(float(one) * tau, dim, tau, p.v0, p.D_t) for one in s]
        axes.plot(s, known, color=colour, linewidth=1.6)
        axes.plot(time, found, "o", color=colour, markersize=4.5, label=case.label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("time, of that in which a heading is forgotten")
    axes.set_ylabel("mean square displacement / length$^2$")
    axes.legend()
    explain(figure, [], f"dots: the run of seed {seed}; lines: the closed form")
