"""Means along an axis with 95 % bands, a line for each combination of the other axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.sweeps.pictures.cell_runs import CellRuns, is_number, label, varied
from worlds.input_error import InputError

COLOURS = ("#2166ac", "#b2182b", "#1b7837", "#b07d12", "#762a83", "#0b7a75", "#555555", "#d6604d")
FEW = len(COLOURS)
"""Lines in a picture, at most."""
CENSORED, FAILED = "#b07d12", "#c0392b"


def draw_lines(figure: Any, name: str, groups: list[CellRuns], x: str) -> None:
    """Draw the lines. Raises InputError if there are more than can be told apart."""
    others = [axis for axis in varied(groups) if axis != x]
    lines: dict[str, list[CellRuns]] = {}
    for group in groups:
        if x in group.axes:
            apart = {axis: group.axes[axis] for axis in others if axis in group.axes}
            lines.setdefault(label(apart), []).append(group)
    if len(lines) > FEW:
        raise InputError(
            f"{len(lines)} lines cannot be told apart: leave cells out with --where, or draw a map"
        )
    figure.set_size_inches(7.2, 4.8)
    axes = figure.subplots()
    for (words, line), colour in zip(lines.items(), COLOURS, strict=False):
        line.sort(key=lambda group: float(group.axes[x]))
        there = [group for group in line if group.values]
        places = [float(group.axes[x]) for group in there]
        means = [group.mean for group in there]
        axes.plot(places, means, color=colour, marker="o", markersize=4, label=words or None)
        low = [group.mean - group.half for group in there]
        high = [group.mean + group.half for group in there]
        axes.fill_between(places, low, high, color=colour, alpha=0.18, linewidth=0)
    mark(axes, groups, x)
    if spans_decades([float(group.axes[x]) for group in groups if x in group.axes]):
        axes.set_xscale("log")
    axes.set_xlabel(x)
    axes.set_ylabel(f"{name}, mean and 95 % interval")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=9)


def mark(axes: Any, groups: list[CellRuns], x: str) -> None:
    """Mark, at the foot, where runs gave up or failed."""
    for count, sign, colour, words in (
        ("gave_up", "v", CENSORED, "runs gave up here"),
        ("broken", "x", FAILED, "runs failed here"),
    ):
        places = sorted(
            {float(group.axes[x]) for group in groups if getattr(group, count) and x in group.axes}
        )
        if places:
            foot = axes.get_xaxis_transform()
            style = {"linestyle": "", "clip_on": False, "transform": foot}
            axes.plot(places, [0.02] * len(places), marker=sign, color=colour, label=words, **style)


def spans_decades(values: list[float]) -> bool:
    """Whether values are spread so that a logarithmic axis shows them better."""
    rising = sorted(set(values))
    if len(rising) < 4 or rising[0] <= 0.0 or rising[-1] < 30.0 * rising[0]:
        return False
    return rising[len(rising) // 2] < 0.3 * rising[-1]


# A sample of cells: the mean of each against every axis, one panel for each.

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


# How the runs of each cell are spread: a box with every run as a point.

MOST_DISTRIBUTIONS = 40
"""Cells in one picture."""


def draw_distributions(figure: Any, name: str, groups: list[CellRuns]) -> None:
    """Draw a box for each cell. Raises InputError if there are too many."""
    if len(groups) > MOST_DISTRIBUTIONS:
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
