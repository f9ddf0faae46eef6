"""What turns of a scene do to a run: a line per row, a dot per turn."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.verdicts.verdict import Verdict, main_ones

COLOUR = "#2166ac"


def draw_turned(figure: Any, made: list[Verdict]) -> None:
    """Draw the main measure of all runs, each row's on a line of its own."""
    rows = [one for one in main_ones(made) if any(value is not None for value in one.values)]
    figure.set_size_inches(7.6, 0.42 * len(rows) + 1.2)
    axes = figure.subplots()
    for k, one in enumerate(rows):
        values = np.array([value for value in one.values if value is not None], float)
        axes.plot(values, np.full(values.size, k), "o", markersize=5, alpha=0.35, color=COLOUR,
                  markeredgewidth=0)  # fmt: skip
    names = [f"{one.case.label}, N = {one.case.agents}" for one in rows]
    axes.set_yticks(range(len(rows)), names)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xlim(left=0.0)
    axes.grid(axis="x", alpha=0.3)
    if rows:
        axes.set_xlabel(f"{rows[0].measure.title} / {rows[0].unit}")
