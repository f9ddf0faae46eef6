"""Means along an axis with 95 % bands, a line for each combination of the other axes."""

from __future__ import annotations

from typing import Any

from app.studies.sweeps.pictures.cell_runs import CellRuns, label, varied
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
