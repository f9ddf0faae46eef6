"""A flock that gathers: groups and polarisation over time, and one run in its box."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.kinds.gathering import GatheringSettings
from app.studies.pictures.boxes import came, explain
from app.studies.pictures.gatherings.box import CRASHED, GROUPS, draw_box
from app.studies.trial import flock_of
from app.studies.verdicts.verdict import Verdict, of
from worlds.number_text import counted

if TYPE_CHECKING:
    from agents import Flock

COLOURS = ("#2166ac", "#b07d12", "#1f9d63", "#c0392b", "#8e44ad")
CURVES = (("groups", "groups"), ("largest", "in the largest group / %"), ("p", "polarisation"))


def draw_gathering(figure: Any, experiment: Experiment, made: list[Verdict], seed: int) -> None:
    """Draw the curves of all rows above, the first row's run of that seed below."""
    settings = experiment.settings
    assert isinstance(settings, GatheringSettings)
    captions = {int(tick): text for tick, text in settings.words.items()}
    letters = "abcdef"[: len(captions)]
    figure.set_size_inches(12.8, 8.0)
    above, below = figure.subfigures(2, 1, height_ratios=[1.0, 1.25])
    panels = above.subplots(1, 3)
    for axes, (measure, title) in zip(panels, CURVES, strict=True):
        draw_curve(axes, of(made, measure), experiment)
        axes.set_title(title, loc="left")
        axes.set_xlabel("tick")
        for tick in captions:
            axes.axvline(tick, color="#c3ccd6", linewidth=0.9, zorder=0.5)
    panels[0].set_ylim(0.0, None)
    panels[1].set_ylim(0.0, 104.0)
    panels[2].set_ylim(0.0, 1.04)
    case = experiment.cases[0]
    flock = flock_of(case, seed)
    boxes = below.subplots(1, len(captions), subplot_kw={"projection": "3d"}, squeeze=False)[0]
    for axes, letter, (tick, text) in zip(boxes, letters, captions.items(), strict=True):
        flock.run(tick - flock.tick)
        draw_box(axes, flock)
        title = f"({letter}) tick {tick}: {seen(settings, flock)}\n{text}"
        axes.set_title(title, loc="left", fontsize=9)
    explain(
        figure,
        signs(panels[0]),
        "above: mean and quartiles of the runs; below: a run of "
        f"{case.label}, seed {seed}, its groups in colours, over it what is measured of it, and in "
        "quotation marks what the source says of its own run",
    )


def seen(settings: GatheringSettings, flock: Flock) -> str:
    """What the picture shows, measured."""
    found = settings.measured(flock)
    groups, p = int(found["groups"] or 0), found["p"]
    return "nobody flies" if p is None else f"{counted(groups, 'group')}, p = {p:.2f}"


def draw_curve(axes: Any, points: list[Verdict], experiment: Experiment) -> None:
    """Draw a measure over the ticks, a line and a band for each row."""
    rows = list(dict.fromkeys(id(case.row) for case in experiment.cases))
    for row, colour in zip(rows, COLOURS, strict=False):
        mine = [one for one in points if id(one.case.row) == row and one.summary.runs]
        ticks = [one.case.tick for one in mine]
        quartiles = np.array([one.summary.quartiles for one in mine])
        if len(mine):
            axes.fill_between(ticks, quartiles[:, 0], quartiles[:, 2], color=colour, alpha=0.18)
            axes.plot(
                ticks,
                [came(one.values).mean() for one in mine],
                color=colour,
                linewidth=1.8,
                label=mine[0].case.label,
            )


def signs(axes: Any) -> list[Any]:
    """What is what."""
    from matplotlib.lines import Line2D

    handles = axes.get_legend_handles_labels()[0]
    flies = Line2D([], [], color=GROUPS[0], marker=">", linestyle="none", label="largest group")
    lies = Line2D([], [], color=CRASHED, marker="x", linestyle="none", label="crashed")
    return [*handles, flies, lies]
