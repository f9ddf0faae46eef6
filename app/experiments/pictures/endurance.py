"""How a flock stands what is turned up: a panel per measure, a line per sweep and size."""

from __future__ import annotations

from typing import Any

from agents.spec import OPTIONS
from app.experiments.pictures.boxes import explain
from app.experiments.verdicts.verdict import Verdict, of, sweeps_of

COLOURS = ("#b07d12", "#2166ac", "#1f9d63", "#c0392b", "#7b5ea7", "#3c434b")
WIDTH, HEIGHT = 5.2, 3.7
COLUMNS = 2
APART = 0.006
"""By how much of the axis lines are set beside each other, so that their bars can be told apart."""


def draw_endurance(figure: Any, made: list[Verdict]) -> None:
    """Draw the panels."""
    measures = list(dict.fromkeys(one.measure for one in made))
    columns = min(COLUMNS, len(measures))
    rows = -(-len(measures) // columns)
    figure.set_size_inches(WIDTH * columns, HEIGHT * rows + 0.8)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True).ravel()
    for axes in panels[len(measures) :]:
        axes.set_visible(False)
    for axes, measure in zip(panels, measures, strict=False):
        found = sweeps_of(of(made, measure.name))
        for k, (sweep, agents, points) in enumerate(found):
            aside, colour = k - 0.5 * (len(found) - 1), COLOURS[k % len(COLOURS)]
            draw_line(axes, aside, colour, points, f"{sweep.label or sweep.model}, N = {agents}")
        unit = found[0][2][0].unit
        axes.set_ylabel(measure.symbol + (f" / {unit}" if unit != "1" else ""))
        axes.set_title(measure.title, loc="left", fontsize=10)
        axes.set_ylim(bottom=0.0)
        axes.tick_params(labelbottom=True)
        axes.set_xlabel(titled(found[0][0].parameter))
    signs = panels[0].get_legend_handles_labels()[0]
    explain(figure, signs, "mean over the runs that have the measure; bars: its 95 % interval")


def titled(parameter: str) -> str:
    """What is turned up, as an option calls itself."""
    return OPTIONS[parameter].title.lower() if parameter in OPTIONS else parameter


def draw_line(axes: Any, aside: float, colour: str, points: list[Verdict], label: str) -> None:
    """Draw the means of one sweep, a little aside from the others'."""
    values = [float(point.case.value or 0.0) for point in points]
    shift = aside * APART * (max(values) - min(values))
    there = [(x + shift, p.summary) for x, p in zip(values, points, strict=True) if p.summary.runs]
    line = {"color": colour, "linewidth": 1.6}
    at, means = [x for x, _ in there], [s.mean for _, s in there]
    low, high = [s.interval[0] for _, s in there], [s.interval[1] for _, s in there]
    axes.vlines(at, low, high, **line)
    axes.plot(at, means, marker="o", markersize=4.5, label=label, **line)
