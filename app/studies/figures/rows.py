"""The rows of an experiment beside each other: a panel per measure, a box per row."""

from __future__ import annotations

from typing import Any

from app.studies.charts.boxes import WORDS, box
from app.studies.charts.colour_table import COLOURS
from app.studies.judge.verdict import Verdict, verdicts_on

WIDTH, HEIGHT = 4.6, 4.4


def draw_rows(figure: Any, verdicts: list[Verdict]) -> None:
    """Draw the panels."""
    measures = list(dict.fromkeys(verdict.measure for verdict in verdicts))
    figure.set_size_inches(WIDTH * len(measures), HEIGHT)
    panels = figure.subplots(1, len(measures), squeeze=False)[0]
    for axes, measure in zip(panels, measures, strict=True):
        rows = verdicts_on(verdicts, measure.name)
        for x, row in enumerate(rows):
            box(axes, x, row.values, COLOURS[x % len(COLOURS)], 0.4)
        unit = "" if rows[0].unit == "1" else f" / {rows[0].unit}"
        axes.set_ylabel(measure.symbol + unit)
        axes.set_title(measure.title, loc="left", fontsize=10)
        axes.set_xticks(range(len(rows)), [row.case.label for row in rows])
        axes.set_xlim(-0.6, len(rows) - 0.4)
        axes.set_ylim(bottom=0.0)
    figure.supxlabel(WORDS, fontsize=8, x=0.01, ha="left")


PICTURES = {"rows": draw_rows}
