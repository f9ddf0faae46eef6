"""How the runs of each cell are spread: a box with every run as a point."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.sweeps.pictures.cell_runs import CellRuns, label
from app.studies.sweeps.pictures.mean_lines import CENSORED, COLOURS, FAILED
from worlds.input_error import InputError

MOST = 40
"""Cells in one picture."""


def draw_distributions(figure: Any, name: str, groups: list[CellRuns]) -> None:
    """Draw a box for each cell. Raises InputError if there are too many."""
    if len(groups) > MOST:
        raise InputError(f"{len(groups)} boxes are too many: leave cells out with --where")
    figure.set_size_inches(6.8, 1.6 + 0.42 * len(groups))
    axes = figure.subplots()
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
        axes.plot(group.values, at, ".", color=COLOURS[0], alpha=0.45, markersize=4)
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
    axes.set_xlabel(name)
