"""A sample of cells: the mean of each against every axis, one panel for each."""

from __future__ import annotations

from typing import Any

from app.studies.sweeps.pictures.cell_runs import CellRuns, is_number
from app.studies.sweeps.pictures.mean_lines import COLOURS, mark

MOST = 12
"""Panels."""


def draw_points(figure: Any, name: str, groups: list[CellRuns], axes: list[str]) -> None:
    """Draw the panels, those of the first axes if there are too many."""
    shown = axes[:MOST]
    across = min(4, len(shown))
    rows = -(-len(shown) // across)
    figure.set_size_inches(1.2 + 2.9 * across, 1.0 + 2.7 * rows)
    panels = figure.subplots(rows, across, squeeze=False, sharey=True).ravel()
    for panel, axis in zip(panels, shown, strict=False):
        there = [group for group in groups if group.values and axis in group.axes]
        places = [
            group.axes[axis] if is_number(group.axes[axis]) else str(group.axes[axis])
            for group in there
        ]
        means = [group.mean for group in there]
        panel.plot(places, means, "o", color=COLOURS[0], markersize=3, alpha=0.6)
        if all(map(is_number, places)):
            mark(panel, groups, axis)
        panel.set_xlabel(axis)
    for panel in panels[len(shown) :]:
        panel.set_visible(False)
    for row in range(rows):
        panels[row * across].set_ylabel(f"{name}, mean")
