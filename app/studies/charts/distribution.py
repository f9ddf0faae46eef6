"""How runs are spread: a box for each group with every run as a point; bars with intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from app.studies.charts.axis_limits import measure_limits
from app.studies.charts.colour_table import CENSORED, COLOURS, FAILED
from app.studies.charts.run_group import CellRuns, label
from app.studies.measure import UNBOUNDED, MeasureBounds
from worlds.input_error import InputError

MOST_DISTRIBUTIONS = 40
"""Boxes in one chart."""


def draw_distributions(
    axes: Any, groups: Sequence[CellRuns], bounds: MeasureBounds = UNBOUNDED
) -> None:
    """Draw a box for each cell, the first at the top. Raises InputError if there are too many."""
    if len(groups) > MOST_DISTRIBUTIONS:
        raise InputError(f"{len(groups)} boxes are too many: leave cells out with --where")
    places = np.arange(len(groups))[::-1]
    axes.boxplot(
        [group.values for group in groups],
        positions=places,
        orientation="horizontal",
        widths=0.55,
        showfliers=False,
        medianprops={"color": COLOURS[0]},
        manage_ticks=False,
    )
    off = np.random.default_rng(0)
    for place, group in zip(places, groups, strict=True):
        at = place + off.uniform(-0.18, 0.18, len(group.values))
        axes.plot(group.values, at, ".", color=COLOURS[0], alpha=0.45, markersize=4, clip_on=False)
        words = []
        if group.gave_up:
            words.append((f"{group.gave_up} gave up", CENSORED))
        if group.broken:
            words.append((f"{group.broken} failed", FAILED))
        for number, (text, colour) in enumerate(words):
            where = axes.get_yaxis_transform()
            axes.text(1.01, place - 0.25 * number, text, color=colour, fontsize=8, transform=where)
    axes.set_yticks(places, [label(group.axes) or "all runs" for group in groups], fontsize=9)
    axes.grid(axis="x")
    axes.set_xlim(*measure_limits([v for group in groups for v in group.values], bounds))
