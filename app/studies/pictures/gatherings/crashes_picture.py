"""Crashes at the start of every run beside the published runs, and crashes over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.pictures.boxes import came, explain
from app.studies.pictures.convergence.models import PUBLISHED
from app.studies.pictures.gatherings.gathering_picture import COLOURS
from app.studies.verdicts.verdict import Verdict, of

WIDTH = 0.3


def draw_crashes(figure: Any, made: list[Verdict]) -> None:
    """Draw both panels."""
    figure.set_size_inches(12.4, 5.2)
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.15])
    rows: dict[int, list[Verdict]] = {}
    for one in made:
        rows.setdefault(id(one.case.row), []).append(one)
    for x, (row, colour) in enumerate(zip(rows.values(), COLOURS, strict=False)):
        draw_start(left, x, of(row, "at_0")[-1], colour)
        draw_course(right, row, colour)
    left.set_xticks(range(len(rows)), [row[0].case.label for row in rows.values()])
    left.tick_params(axis="x", length=0)
    left.set_ylabel("crashes at tick 0")
    left.set_ylim(-0.5, None)
    right.set_xscale("symlog", linthresh=1.0)
    right.set_xlabel("tick")
    right.set_ylabel("crashes so far, mean of the runs")
    right.set_ylim(0.0, None)
    right.minorticks_off()
    signs(figure)


def draw_start(axes: Any, x: int, one: Verdict, colour: str) -> None:
    """Draw the crashes at tick 0: a dot for each run, the mean, and the published runs beside."""
    values = came(one.values)
    aside = np.random.default_rng(0).uniform(-0.6 * WIDTH, 0.6 * WIDTH, values.size)
    axes.plot(x - 0.2 + aside, values, ".", color=colour, markersize=5, alpha=0.5)
    axes.plot([x - 0.2 - WIDTH / 2, x - 0.2 + WIDTH / 2], [values.mean()] * 2, color=colour, lw=2.4)
    if one.published and one.published.values:
        there = np.array(one.published.values)
        axes.plot([x + 0.22] * there.size, there, "D", color=PUBLISHED, markersize=6, alpha=0.75)
        axes.plot([x + 0.1, x + 0.34], [there.mean()] * 2, color=PUBLISHED, lw=2.0)


def draw_course(axes: Any, row: list[Verdict], colour: str) -> None:
    """Draw the mean number of crashes up to each look."""
    counts = [of(row, measure) for measure in ("at_0", "early", "late")]
    ticks = [one.case.tick for one in counts[0]]
    total = [sum(one.summary.mean for one in look) for look in zip(*counts, strict=True)]
    axes.plot(ticks, total, color=colour, marker="o", markersize=4, label=row[0].case.label)


def signs(figure: Any) -> None:
    """Say what is what, below the panels."""
    from matplotlib.lines import Line2D

    course = figure.axes[1].get_legend_handles_labels()[0]
    thesis = Line2D(
        [], [], marker="D", color=PUBLISHED, linestyle="none", label="the thesis's five runs"
    )
    explain(figure, [*course, thesis], "dots: runs; bars: means")
