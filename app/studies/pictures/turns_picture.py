"""How the turn of one agent comes to the others: distance over delay, and the exponents of runs."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.turns import TurnSettings
from app.studies.pictures.boxes import explain
from app.studies.trial import flock_of
from app.studies.verdicts.verdict import Verdict, of

COLOURS = ("#2166ac", "#5aa9c9", "#1f9d63", "#c0392b", "#0b2545", "#8e44ad", "#b07d12")
LINE = "#3c434b"


def draw_turns(figure: Any, experiment: Experiment, made: list[Verdict], seed: int) -> None:
    """Draw the run of that seed of each row to the left, the exponents of all runs to the right."""
    settings = experiment.settings
    assert isinstance(settings, TurnSettings)
    figure.set_size_inches(11.4, 5.6)
    ways, exponents = figure.subplots(1, 2, width_ratios=[1.7, 1.0])
    for k, case in enumerate(experiment.cases):
        turn = settings.turned(flock_of(case, seed))
        colour = COLOURS[k % len(COLOURS)]
        ways.plot(turn.delay, turn.distance, "o-", color=colour, linewidth=1.4, label=case.label)
    time = np.array([1.0, settings.limit])
    ways.plot(time, 2.2 * time, "--", color=LINE, linewidth=1.0)
    ways.plot(time, 7.0 * time**0.5, ":", color=LINE, linewidth=1.2)
    ways.set(
        xscale="log",
        yscale="log",
        xlabel="delay / s",
        ylabel="distance to the one that turned / length",
        ylim=(0.8 * settings.nearest, 1.25 * settings.furthest),
        xlim=(0.1, settings.limit),
    )
    ways.set_yticks([4, 8, 16], ["4", "8", "16"])
    ways.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
    ways.minorticks_off()
    ways.set_title(f"seed {seed}: rings about the one that turned", loc="left")
    points = of(made, "exponent")
    for k, one in enumerate(points):
        values = [value for value in one.values if value is not None]
        aside = np.random.default_rng(0).uniform(-0.22, 0.22, len(values))
        colour = COLOURS[k % len(COLOURS)]
        exponents.plot(k + aside, values, ".", color=colour, markersize=4, alpha=0.6)
    for level in (0.5, 1.0):
        exponents.axhline(level, color=LINE, linewidth=0.9, linestyle=":")
    labels = [fill(one.case.label, 10) for one in points]
    exponents.set_xticks(range(len(points)), labels, fontsize=8)
    exponents.set_ylim(0.0, 1.4)
    exponents.set_ylabel("exponent a of distance ~ delay$^a$")
    exponents.set_title("all runs", loc="left")
    explain(
        figure,
        ways.get_legend_handles_labels()[0],
        "dashed, a = 1: a wave; dotted, a = 1/2: what diffuses",
    )
