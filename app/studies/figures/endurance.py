"""How a flock stands what is turned up: a row of panels per measure, a column per condition."""

from __future__ import annotations

import textwrap
from typing import Any

from agents.catalogue import model as find_model
from agents.conditions import Conditions
from agents.spec import OPTIONS
from app.studies.charts.boxes import draw_key
from app.studies.charts.colour_table import COLOURS
from app.studies.charts.mean_line import INTERVAL_WORDS, draw_mean_bars
from app.studies.experiment_file import PaperSweep
from app.studies.judge.verdict import Verdict, group_by_sweep, verdicts_on

WIDTH, HEIGHT = 3.3, 2.7
LEAST_WIDTH = 7.0
LETTERS = 34
"""Of a line above a column."""
JOINED = "\u00a0"
"""A space at which no line is broken."""
ROOM = 1.1
"""How much higher than the highest mean panels are: bars may go on beyond."""
APART = 0.008
"""By how much of the axis lines are set beside each other, so that their bars can be told apart."""

Column = tuple[str, str]
"""What is turned up, and what else agents go through, in words."""
Kind = tuple[str, str, int]
"""What tells lines apart: model, its fixed parameters, agents."""


def draw_endurance(figure: Any, verdicts: list[Verdict]) -> None:
    """Draw the panels."""
    measures = list(dict.fromkeys(verdict.measure for verdict in verdicts))
    sweeps = group_by_sweep(verdicts_on(verdicts, measures[0].name))
    columns = list(dict.fromkeys(column_of(sweep) for sweep, _, _ in sweeps))
    kinds = list(dict.fromkeys(kind_of(sweep, agents) for sweep, agents, _ in sweeps))
    width = max(LEAST_WIDTH, WIDTH * len(columns) + 0.5)
    figure.set_size_inches(width, HEIGHT * len(measures) + 1.3)
    panels = figure.subplots(len(measures), len(columns), squeeze=False, sharex="col", sharey="row")
    for row, measure in zip(panels, measures, strict=True):
        for sweep, agents, points in group_by_sweep(verdicts_on(verdicts, measure.name)):
            k = kinds.index(kind_of(sweep, agents))
            axes = row[columns.index(column_of(sweep))]
            draw_line(axes, k - 0.5 * (len(kinds) - 1), COLOURS[k % len(COLOURS)], points)
            unit = points[0].unit
        row[0].set_ylabel(measure.symbol + (f" / {unit}" if unit != "1" else ""))
        row[0].set_ylim(0.0, top_of(verdicts_on(verdicts, measure.name)))
        row[0].set_title(measure.title, loc="left", fontsize=10)
    for k, (parameter, around) in enumerate(columns):
        models = [sweep.model for sweep, _, _ in sweeps if column_of(sweep) == (parameter, around)]
        panels[-1, k].set_xlabel(parameter_title(parameter) + unit_of(parameter, models))
        if around:
            words = "\n".join(textwrap.wrap(around, LETTERS)).replace(JOINED, " ")
            panels[0, k].annotate(
                words, (0.5, 1.0), xycoords="axes fraction", xytext=(0, 26),
                textcoords="offset points", ha="center", va="bottom", fontsize=9.5,
            )  # fmt: skip
    signs = [sign_of(k, kind, sweeps) for k, kind in enumerate(kinds)]
    draw_key(figure, signs, f"mean over the runs that have the measure; {INTERVAL_WORDS}")


def column_of(sweep: PaperSweep) -> Column:
    """What is turned up in a sweep, and what else its agents go through."""
    chosen = {
        name: value for name, value in sweep.chosen.items() if name in Conditions.model_fields
    }
    words = [
        f"{parameter_title(name)} {value:g}".replace(" ", JOINED) for name, value in chosen.items()
    ]
    return sweep.parameter, ", ".join(words)


def top_of(points: list[Verdict]) -> float:
    """Up to where the panels of a measure go: the means decide, few runs have long bars."""
    return (
        ROOM * max((point.summary.mean for point in points if point.summary.runs), default=1.0)
        or 1.0
    )


def kind_of(sweep: PaperSweep, agents: int) -> Kind:
    """What tells a line of a sweep apart from the others of its column."""
    return sweep.model, repr(sorted(sweep.fixed.items())), agents


def sign_of(k: int, kind: Kind, sweeps: list[tuple[PaperSweep, int, list[Verdict]]]) -> Any:
    """What the line of a kind is called: as in the first column that has it."""
    from matplotlib.lines import Line2D

    sweep = next(sweep for sweep, agents, _ in sweeps if kind_of(sweep, agents) == kind)
    label = f"{sweep.label or sweep.model}, N = {kind[2]}"
    return Line2D([], [], color=COLOURS[k % len(COLOURS)], marker="o", markersize=4.5, label=label)


def parameter_title(parameter: str) -> str:
    """What is turned up, as an option calls itself."""
    return OPTIONS[parameter].title.lower() if parameter in OPTIONS else parameter


def unit_of(parameter: str, models: list[str]) -> str:
    """The unit of what is turned up, where it has one that is the same in all models."""
    if parameter not in OPTIONS or not OPTIONS[parameter].unit:
        return ""
    units = {find_model(name).in_units(OPTIONS[parameter].unit) for name in models}
    return f" / {units.pop()}" if len(units) == 1 else ""


def draw_line(axes: Any, aside: float, colour: str, points: list[Verdict]) -> None:
    """Draw the means of one sweep, a little aside from the others'."""
    values = [float(point.case.value or 0.0) for point in points]
    shift = aside * APART * (max(values) - min(values))
    present = [
        (x + shift, p.summary) for x, p in zip(values, points, strict=True) if p.summary.runs
    ]
    at, summaries = [x for x, _ in present], [summary for _, summary in present]
    draw_mean_bars(axes, at, summaries, colour, markersize=4.5, capsize=0.0)


PICTURES = {"endurance": draw_endurance}
