"""How a flock stands what is turned up: a panel per measure, a line per sweep and size."""

from __future__ import annotations

from typing import Any

from app.experiments.pictures.boxes import explain
from app.experiments.verdicts.verdict import Verdict, of, sweeps_of

COLOURS = ("#b07d12", "#2166ac", "#1f9d63", "#c0392b", "#7b5ea7", "#3c434b")
MARKERS = ("o", "s", "^", "D", "v", "x")
WIDTH, HEIGHT = 4.6, 4.4


def draw_endurance(figure: Any, made: list[Verdict]) -> None:
    """Draw the panels."""
    measures = list(dict.fromkeys(one.measure for one in made))
    figure.set_size_inches(WIDTH * len(measures), HEIGHT)
    panels = figure.subplots(1, len(measures), squeeze=False)[0]
    for axes, measure in zip(panels, measures, strict=True):
        found = sweeps_of(of(made, measure.name))
        for k, (sweep, agents, points) in enumerate(found):
            draw_line(axes, k, points, f"{sweep.label or sweep.model}, N = {agents}")
        unit = found[0][2][0].unit
        axes.set_xlabel(found[0][0].parameter)
        axes.set_ylabel(measure.symbol + (f" / {unit}" if unit != "1" else ""))
        axes.set_title(measure.title, loc="left", fontsize=10)
        axes.set_ylim(bottom=0.0)
    signs = panels[0].get_legend_handles_labels()[0]
    explain(figure, signs, "mean over the runs that have the measure; bars: its 95 % interval")


def draw_line(axes: Any, k: int, points: list[Verdict], label: str) -> None:
    """Draw the means of one sweep."""
    there = [point for point in points if point.summary.mean is not None]
    axes.errorbar(
        [float(point.case.value or 0.0) for point in there],
        [point.summary.mean for point in there],
        yerr=[
            [point.summary.mean - point.summary.interval[0] for point in there],
            [point.summary.interval[1] - point.summary.mean for point in there],
        ],
        color=COLOURS[k % len(COLOURS)],
        marker=MARKERS[k % len(MARKERS)],
        markersize=5,
        linewidth=1.6,
        capsize=2.5,
        label=label,
    )
