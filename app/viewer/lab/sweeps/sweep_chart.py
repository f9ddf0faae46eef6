"""A sweep as a picture in the page: a curve over one axis, a map over two; a click opens a run."""

from __future__ import annotations

from typing import Any

from agents.catalogue import MODELS
from app.studies.charts.axis_limits import (
    column_bounds,
    observable_of,
    parameter_bounds,
)
from app.studies.charts.mean_line import (
    FOOT,
    draw_mean_line,
    draw_missing,
    draw_runs,
    fit_axes,
    group_limits,
)
from app.studies.charts.page_svg import CLICKED, ShapeLink, page_figure, page_svg
from app.studies.charts.run_group import CellRuns, is_number
from app.studies.charts.value_map import MapCell, draw_map, name_ticks, place_cells
from app.viewer.lab.sweeps.stored_sweeps import DrawnSweep, few_of
from app.viewer.lab.sweeps.sweep_request import axis_title
from app.viewer.measuring.observable_format import format_short, observable_words
from app.viewer.measuring.observable_table import observable_title
from worlds.number_text import counted

WIDTH, HEIGHT = 300.0, 210.0
"""Of a curve, units of the picture: pixels where the panel is as wide as usual."""
REACH = 9.0
"""How far around a point a click means it, pixels."""
SIDES = 70.0
"""Of the width, beside the cells of a map."""
HEAD = 96.0
"""Of the height, above and below the cells of a map: its colours, the names of its axis."""
MOST_DOTS = 400
"""Runs that are drawn each by itself."""
TALLEST = 240.0
"""Of the cells of a map."""
LABELS = 6
"""Along an axis of cells or words."""
LETTERS = 32
"""Of the name of an axis."""


def picture(shown: DrawnSweep) -> str:
    """HTML of what a sweep has come to, or why it is not drawn here. Takes some tenths of a second:
    for a thread that may wait."""
    axes = list(shown.axes)
    if len(axes) == 1:
        return draw_curve(shown, axes[0]) + describe_marks(shown)
    if len(axes) == 2:
        filled = len(shown.axes[axes[0]]) * len(shown.axes[axes[1]])
        if filled <= 2 * len(shown.cells):
            return draw_cells(shown, axes[0], axes[1]) + describe_marks(shown)
    what = "a sample" if len(axes) == 2 else counted(len(axes), "axis", "axes")
    return f'<div class="fs-quiet">{what.capitalize()}: taken as PNG below, it is drawn.</div>'


def draw_curve(shown: DrawnSweep, axis: str) -> str:
    """SVG of the means along an axis with their 95 % intervals, and the runs behind them."""
    values = shown.axes[axis]
    numeric = all(map(is_number, values))
    cells = [(place, group) for place, group in shown.cells.items() if axis in group.axes]
    cells.sort(key=lambda cell: values.index(cell[1].axes[axis]))
    groups = [group for _, group in cells]
    at = [
        float(group.axes[axis]) if numeric else float(values.index(group.axes[axis]))
        for group in groups
    ]
    with_runs = sum(group.runs for group in groups) <= MOST_DOTS
    with page_figure(WIDTH, HEIGHT) as figure:
        chart = figure.subplots()
        bounds = column_bounds(shown.column)
        if numeric:
            places = [float(value) for value in values]
            along = parameter_bounds(shown.models.of_axis(axis), axis)
            fit_axes(chart, places, groups, along, bounds, with_runs)
        else:
            name_ticks(chart.set_xticks, [shorten_name(few_of(v)) for v in values], LABELS, 0.0)
            chart.set_xlim(-0.5, len(values) - 0.5)
            chart.set_ylim(*group_limits(groups, bounds, with_runs))
        if with_runs:
            draw_runs(chart, at, groups)
        draw_mean_line(chart, at, [group.summary for group in groups], joined=numeric)
        draw_missing(
            chart,
            [x for x, group in zip(at, groups, strict=True) if group.gave_up],
            [x for x, group in zip(at, groups, strict=True) if group.broken],
        )
        chart.set_xlabel(name_axis(shown, axis))
        chart.set_ylabel(name_measure(shown))
        links = draw_targets(chart, shown, at, cells)
        return page_svg(figure, f"{name_measure(shown)} over {name_axis(shown, axis)}", links)


def draw_targets(
    chart: Any, shown: DrawnSweep, at: list[float], cells: list[tuple[int, CellRuns]]
) -> dict[str, list[ShapeLink | None]]:
    """Draw where clicks mean the cells of a curve, unseen; returns the links of these."""
    low, high = chart.get_ylim()
    foot = low + FOOT * (high - low)
    there = [(x, *cell) for x, cell in zip(at, cells, strict=True) if cell[1].has_runs]
    apart = (WIDTH - SIDES) / max(1, len(shown.axes[next(iter(shown.axes))]) - 1)
    if there:
        chart.scatter(
            [x for x, _, _ in there],
            [group.mean if group.values else foot for _, _, group in there],
            s=(2.0 * min(REACH, 0.5 * apart)) ** 2,
            linewidths=0,
            clip_on=False,
            zorder=9,
            gid=CLICKED,
        )
    return {CLICKED: [link_to(shown, place, group) for _, place, group in there]}


def draw_cells(shown: DrawnSweep, across: str, up: str) -> str:
    """SVG of the mean of each cell as a colour, over two axes."""
    columns, rows = shown.axes[across], shown.axes[up]
    tall = min(1.4 * (WIDTH - SIDES) / len(columns), TALLEST / len(rows))
    cells: list[MapCell] = []
    links: list[ShapeLink | None] = [None] * (len(columns) * len(rows))
    for place, group in shown.cells.items():
        for cell in place_cells([group], columns, rows, across, up):  # none where an axis lacks
            cells.append(cell)
            if group.has_runs:
                links[cell.row * len(columns) + cell.column] = link_to(shown, place, group)
    with page_figure(WIDTH, HEAD + tall * len(rows)) as figure:
        chart = figure.subplots()
        colours = draw_map(chart, cells, columns, rows, column_bounds(shown.column), LABELS)
        bar = figure.colorbar(colours, ax=chart, location="top", aspect=30, pad=0.02)
        bar.set_label(name_measure(shown))
        chart.set_xlabel(name_axis(shown, across))
        chart.set_ylabel(name_axis(shown, up))
        title = f"{name_measure(shown)} over {name_axis(shown, across)} and {name_axis(shown, up)}"
        return page_svg(figure, title, {"fs-cell": links})


def link_to(shown: DrawnSweep, place: int, group: CellRuns) -> ShapeLink:
    """What a click opens a run of."""
    return ShapeLink(describe_cell(shown, group), {"sweep": shown.name, "cell": place})


def describe_cell(shown: DrawnSweep, group: CellRuns) -> str:
    """What is known of a cell, and what a click does."""
    where = ", ".join(
        f"{axis} = {few_of(value)}" for axis, value in group.axes.items() if axis in shown.axes
    )
    said = f"{where}: "
    if group.values:
        half = f" ± {format_short(group.half)}" if group.half == group.half else ""
        said += f"{format_short(group.mean)}{half}, {counted(group.runs, 'run')}"
    said += f"; {group.gave_up} gave up" if group.gave_up else ""
    said += f"; {group.broken} failed" if group.broken else ""
    what = "the run nearest to the mean" if group.runs > 1 else "the run"
    return f"{said}. Click: open {what}"


def describe_marks(shown: DrawnSweep) -> str:
    """HTML of what is drawn, and what the marks mean that are there."""
    groups = shown.cells.values()
    said = []
    if len(shown.axes) == 1:
        said.append("Mean, 95 % interval and runs")
    if any(group.gave_up for group in groups):
        said.append("▼ Runs gave up: in no mean")
    if any(group.broken for group in groups):
        said.append("× Runs failed")
    said.append("Click: open the run nearest to the mean")
    return f'<div class="fs-quiet">{". ".join(said)}.</div>'


def name_axis(shown: DrawnSweep, axis: str) -> str:
    """An axis as its slider is called."""
    title = axis_title(shown.models.of_axis(axis), axis)
    return shorten_name(title) if title == axis else title


def name_measure(shown: DrawnSweep) -> str:
    """What is measured, as plots call it."""
    name = observable_of(shown.column)
    if not name:
        return shorten_name(observable_words(shown.column))
    models = [MODELS[shown.models.flock]] if shown.models.flock in MODELS else []
    over = shown.column.partition("-over-")[2]
    return observable_title(name, models) + (f", last {over} ticks" if over else "")


def shorten_name(name: str) -> str:
    """A name of a user's own, so short that it has room along an axis.

    >>> shorten_name("a" * 40)
    'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa…'
    """
    return name if len(name) <= LETTERS else f"{name[: LETTERS - 1]}…"
