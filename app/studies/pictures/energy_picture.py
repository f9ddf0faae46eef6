"""The energy of theorem 1 over time, and how far from the goal a flock came beside the bound."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.energy import EnergySettings
from app.studies.trial import flock_of

COLOURS = ("#2166ac", "#b07d12", "#1f9d63", "#c0392b")


def draw_energy(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the runs of that seed, one of each row."""
    settings = experiment.settings
    assert isinstance(settings, EnergySettings)
    figure.set_size_inches(11.0, 4.8)
    left, right = figure.subplots(1, 2)
    for case, colour in zip(experiment.cases, COLOURS, strict=False):
        flock = flock_of(case, seed)
        energy, away = settings.followed(flock)
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
