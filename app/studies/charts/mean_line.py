"""Means along an axis with their 95 % intervals, and marks where runs have no value.

All of it takes a `MeasureSummary` for each place: what is drawn is what tables say. The id that
artists are given (`gid`) is their class in the page, as `page_svg` has it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from app.studies.charts.axis_limits import (
    Limits,
    measure_limits,
    parameter_limits,
    spans_decades,
)
from app.studies.charts.colour_table import CENSORED, COLOURS, FAILED
from app.studies.charts.run_group import CellRuns, RunGroup, is_number, label, varied_axes
from app.studies.judge.statistics import MeasureSummary
from app.studies.measure import UNBOUNDED, MeasureBounds
from worlds.input_error import InputError

INTERVAL_WORDS = "bars: 95 % interval of the mean"
"""What a legend says of `draw_mean_bars`."""
FEW = len(COLOURS)
"""Lines in a picture, at most."""
FOOT = 0.03
"""Where on the height of a chart runs are marked that have no value."""
MARKS = (
    ("gave_up", "v", CENSORED, "runs gave up here"),
    ("broken", "x", FAILED, "runs failed here"),
)
"""Count of a `RunGroup`, sign, colour, words in a legend."""


def draw_mean_line(
    axes: Any,
    places: Sequence[float],
    summaries: Sequence[MeasureSummary],
    colour: str = COLOURS[0],
    words: str = "",
    joined: bool = True,
    **line: Any,
) -> None:
    """Draw means as points on a line, and their intervals as a band.

    `joined`: whether there is a line; without one, as over places in no order, the points stand
    by themselves and the intervals are bars. Places without a mean are left out.
    """
    points = [
        (x, summary)
        for x, summary in zip(places, summaries, strict=True)
        if math.isfinite(summary.mean)
    ]
    at, known_summaries = [x for x, _ in points], [summary for _, summary in points]
    if not joined:
        draw_mean_bars(axes, at, known_summaries, colour, linestyle="", elinewidth=1.2)
    elif points:
        low, high = (np.array([summary.interval[k] for summary in known_summaries]) for k in (0, 1))
        band = axes.fill_between(at, low, high, color=colour, alpha=0.18, linewidth=0)
        band.set_gid("fs-band")
        axes.plot(
            at, [summary.mean for summary in known_summaries], color=colour, gid="fs-mean", **line
        )
    axes.plot(
        at, [summary.mean for summary in known_summaries], "o",
        color=colour, markersize=4, clip_on=False,
        gid="fs-point", zorder=3,
    )  # fmt: skip
    if words:  # line and points are one in the legend
        axes.plot([], [], color=colour, marker="o", markersize=4, label=words, **line)


def draw_mean_bars(
    axes: Any,
    places: Sequence[float],
    summaries: Sequence[MeasureSummary],
    colour: str = COLOURS[0],
    words: str = "",
    **style: Any,
) -> None:
    """Draw means with their intervals as bars, `style` as `errorbar` takes it.

    A side of an interval of which nothing is known, or that has no end, has no bar.
    """
    means = np.array([summary.mean for summary in summaries], float)
    sides = interval_sides(means, [summary.interval for summary in summaries])
    look = {"marker": "o", "markersize": 5, "linewidth": 1.6, "capsize": 2.5} | style
    axes.errorbar(places, means, yerr=sides, color=colour, label=words or None, **look)


def interval_sides(
    means: Sequence[float] | np.ndarray, intervals: Sequence[tuple[float, float]]
) -> np.ndarray:
    """How far intervals go below and above their means (2, M), as `errorbar` takes it.

    >>> interval_sides([2.0, 5.0], [(1.5, 3.0), (math.nan, math.inf)])
    array([[0.5, 0. ],
           [1. , 0. ]])
    """
    ends = np.array(intervals, float).reshape(-1, 2).T
    away = np.stack([np.asarray(means) - ends[0], ends[1] - np.asarray(means)])
    return np.where(np.isfinite(away), np.maximum(away, 0.0), 0.0)


def draw_runs(axes: Any, places: Sequence[float], groups: Sequence[RunGroup]) -> None:
    """Draw every run with a value as a faint dot."""
    at = [x for x, group in zip(places, groups, strict=True) for _ in group.values]
    values = [value for group in groups for value in group.values]
    axes.plot(
        at, values, "o", color="black", alpha=0.35, markersize=3.6, markeredgewidth=0,
        clip_on=False, gid="fs-run",
    )  # fmt: skip


def draw_missing(
    axes: Any, gave_up: Iterable[float], failed: Iterable[float], words: Sequence[str] = ()
) -> None:
    """Mark, at the foot, the places where runs gave up or failed; `words` are for a legend."""
    labels = words or [mark[3] for mark in MARKS]
    for places, (name, sign, colour, _), text in zip((gave_up, failed), MARKS, labels, strict=True):
        at = sorted(set(places))
        if at:
            axes.plot(
                at, [FOOT] * len(at), sign, color=colour, label=text, clip_on=False, zorder=5,
                markeredgecolor="white" if sign == "v" else colour, markersize=7,
                markeredgewidth=0.8 if sign == "v" else 1.6,
                transform=axes.get_xaxis_transform(), gid=f"fs-{name.replace('_', '-')}",
            )  # fmt: skip


def fit_axes(
    axes: Any,
    places: Sequence[float],
    groups: Sequence[RunGroup],
    along: MeasureBounds = UNBOUNDED,
    up: MeasureBounds = UNBOUNDED,
    with_runs: bool = False,
) -> None:
    """Set the ends of both axes by what is drawn of groups at `places`, and by what the quantities
    can be."""
    log = spans_decades(places)
    if log:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
        axes.minorticks_off()  # they take as long to draw as all the rest
    if places:
        axes.set_xlim(*parameter_limits(places, along, log))
    axes.set_ylim(*group_limits(groups, up, with_runs))


def group_limits(
    groups: Sequence[RunGroup], bounds: MeasureBounds = UNBOUNDED, with_runs: bool = False
) -> Limits:
    """The ends of an axis that has room for the means of groups, and for their runs if asked."""
    with_values = [group for group in groups if group.values]
    values = [group.mean for group in with_values]
    values += [value for group in with_values for value in group.values if with_runs]
    return measure_limits(values, bounds, [end for g in with_values for end in g.summary.interval])


def draw_lines(
    axes: Any,
    groups: Sequence[CellRuns],
    x: str,
    along: MeasureBounds = UNBOUNDED,
    up: MeasureBounds = UNBOUNDED,
) -> None:
    """Draw means over the axis `x`, a line for each combination of the others. Raises InputError.

    `along` and `up` bound the two axes of the chart.
    """
    others = [axis for axis in varied_axes(groups) if axis != x]
    lines: dict[str, list[CellRuns]] = {}
    for group in groups:
        if x in group.axes:
            apart = {axis: group.axes[axis] for axis in others if axis in group.axes}
            lines.setdefault(label(apart), []).append(group)
    if len(lines) > FEW:
        raise InputError(
            f"{len(lines)} lines cannot be told apart: leave cells out with --where, or draw a map"
        )
    for (words, line), colour in zip(lines.items(), COLOURS, strict=False):
        line.sort(key=lambda group: float(group.axes[x]))
        places = [float(group.axes[x]) for group in line]
        draw_mean_line(axes, places, [group.summary for group in line], colour, words)
    drawn_groups = [group for line in lines.values() for group in line]
    fit_axes(axes, [float(g.axes[x]) for g in drawn_groups], drawn_groups, along, up)
    mark_missing(axes, drawn_groups, x)


def mark_missing(axes: Any, groups: Sequence[CellRuns], x: str) -> None:
    """Mark, at the foot, where along the axis `x` runs gave up or failed."""
    present = [group for group in groups if x in group.axes]
    draw_missing(
        axes,
        [float(group.axes[x]) for group in present if group.gave_up],
        [float(group.axes[x]) for group in present if group.broken],
    )


def draw_sample(
    axes: Any,
    groups: Sequence[CellRuns],
    x: str,
    along: MeasureBounds = UNBOUNDED,
    up: MeasureBounds = UNBOUNDED,
) -> None:
    """Draw the mean of each cell of a sample over one of its axes."""
    present = [group for group in groups if group.values and x in group.axes]
    numeric = all(is_number(group.axes[x]) for group in present)
    places = [group.axes[x] if numeric else str(group.axes[x]) for group in present]
    means = [group.mean for group in present]
    axes.plot(places, means, "o", color=COLOURS[0], markersize=3, alpha=0.6, clip_on=False)
    if numeric:
        mark_missing(axes, groups, x)
        axes.set_xlim(*parameter_limits([float(place) for place in places], along))
    axes.set_ylim(*measure_limits(means, up))
