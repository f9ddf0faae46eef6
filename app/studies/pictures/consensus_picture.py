"""How differences in velocity fall in a flock that flies apart, beside what is known beforehand."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Case, Experiment
from app.studies.kinds.consensus import ConsensusBound, ConsensusSettings
from app.studies.pictures.boxes import explain
from app.studies.trial import flock_of

COLOURS = ("#2166ac", "#c0392b", "#1b7837", "#e08214", "#762a83", "#35978f", "#8c510a", "#3c434b")
DASHES = (0, (4, 2))
LEAST = 1e-4
"""The smallest share of the differences that is shown."""


def draw_consensus(figure: Any, experiment: Experiment, seed: int) -> None:
    """Two agents on the left in the plane of V over X, flocks on the right over time."""
    settings = experiment.settings
    assert isinstance(settings, ConsensusSettings)
    figure.set_size_inches(12.4, 5.4)
    pairs, flocks = figure.subplots(1, 2)
    shown = []
    for case, colour in zip(experiment.cases, COLOURS * 2, strict=False):
        flock = flock_of(case, seed)
        time, x, v = settings.followed(flock, lambda: None)
        bound = settings.bound(flock, float(x[0]), float(v[0]))
        if case.agents == 2:
            draw_pair(pairs, case, bound, x, v, colour)
        else:
            draw_flock(flocks, case, bound, time, v, colour)
        shown.append(case)
    pairs.set_xscale("log")
    pairs.set_xlabel("distance, of that at the start")
    pairs.set_ylabel("relative speed, of the critical one")
    pairs.set_ylim(0.0, None)
    pairs.set_title("two agents that fly apart", loc="left")
    flocks.set_xscale("log")
    flocks.set_yscale("log")
    flocks.set_ylim(LEAST, 2.0)
    flocks.set_xlabel("time / s")
    flocks.set_ylabel("differences in velocity, of those at the start")
    flocks.set_title("flocks that fly apart", loc="left")
    for axes in (pairs, flocks):
        if axes.has_data():
            axes.legend(loc="best", fontsize=8)
    explain(
        figure,
        [],
        "lines: runs; dashed on the left: the closed form of two agents, on the right: the bound "
        "that no flock with a start below the critical speed may exceed",
    )


def draw_pair(
    axes: Any, case: Case, bound: ConsensusBound, x: np.ndarray, v: np.ndarray, colour: str
) -> None:
    """Two agents, in units of the critical speed, or of their own where there is none."""
    critical = bound.v0 / bound.share if bound.share > 0.0 else bound.v0
    exact = np.array([bound.v0 - bound.lost(one) for one in x])
    axes.plot(x / x[0], v / critical, color=colour, linewidth=2.0, label=f"$\\beta$ = {case.label}")
    axes.plot(x / x[0], exact / critical, color="black", linewidth=0.9, linestyle=DASHES)


def draw_flock(
    axes: Any, case: Case, bound: ConsensusBound, time: np.ndarray, v: np.ndarray, colour: str
) -> None:
    """A flock over time, with its bound if it has one."""
    axes.plot(
        time[1:],
        v[1:] / v[0],
        color=colour,
        linewidth=2.0,
        label=f"$\\beta$ = {case.label}, N = {case.agents}",
    )
    if bound.share < 1.0:
        most = bound.differences(time[1:]) / v[0]
        axes.plot(time[1:], most, color=colour, linewidth=1.0, linestyle=DASHES)
