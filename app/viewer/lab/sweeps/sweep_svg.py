"""A sweep as a picture in the page: a curve over one axis, a map over two; a click opens a run."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from agents.catalogue import MODELS
from app.studies.charts.axis_limits import spans_decades
from app.studies.charts.run_group import CellRuns, is_number
from app.viewer.lab.sweeps.stored_sweeps import DrawnSweep, few_of, observable_of
from app.viewer.lab.sweeps.sweep_request import AGENTS, numbers
from app.viewer.measuring.observable_format import few, scale, words
from app.viewer.measuring.observable_table import titled
from app.viewer.panels.parameters import worded
from worlds.number_text import counted

WIDTH, HEIGHT = 300.0, 210.0
"""Of a curve, units of the picture: pixels where the panel is as wide as usual."""
LEFT, RIGHT, TOP, BOTTOM = 54.0, 10.0, 8.0, 36.0
ROUND = 9.0
"""How far around a point a click means it."""
MOST_DOTS = 400
"""Runs that are drawn each by itself."""
TALLEST = 240.0
"""Of a map."""
VIRIDIS = (
    (68, 1, 84), (71, 45, 123), (59, 82, 139), (44, 114, 142), (33, 145, 140), (40, 174, 128),
    (94, 201, 98), (173, 220, 48), (253, 231, 37),
)  # fmt: skip
"""The colours of a map, the least value first: those of the pictures that are written."""
ROOM = 5
"""Labels along an axis."""


def picture(shown: DrawnSweep) -> str:
    """HTML of what a sweep has come to, or why it is not drawn here."""
    axes = list(shown.axes)
    if len(axes) == 1:
        return curve(shown, axes[0])
    if len(axes) == 2:
        filled = len(shown.axes[axes[0]]) * len(shown.axes[axes[1]])
        if filled <= 2 * len(shown.cells):
            return colour_map(shown, axes[0], axes[1])
    what = "a sample" if len(axes) == 2 else counted(len(axes), "axis", "axes")
    return f'<div class="fs-quiet">{what.capitalize()}: taken as PNG below, it is drawn.</div>'


def curve(shown: DrawnSweep, axis: str) -> str:
    """Means along an axis with their 95 % intervals, and the runs behind them."""
    values = shown.axes[axis]
    numeric = all(map(is_number, values))
    at = [float(one) for one in values] if numeric else [float(k) for k in range(len(values))]
    log = numeric and spans_decades(at)
    right, foot = WIDTH - RIGHT, HEIGHT - BOTTOM
    x = AxisScale(at[0], at[-1], LEFT + 8.0, right - 8.0, log)
    groups = [
        (place, x(at[values.index(group.axes[axis])]), group)
        for place, group in shown.cells.items()
        if axis in group.axes
    ]
    groups.sort(key=lambda one: one[1])
    seen = [value for _, _, group in groups for value in ends(group)]
    low, high = limits(shown.column, seen)
    y = AxisScale(low, high, foot, TOP)
    made = [frame(x, y, at if numeric and len(at) <= ROOM else None, numeric, values)]
    there = [(place, px, group) for place, px, group in groups if group.values]
    band = [(px, group) for _, px, group in there if group.half == group.half]
    if len(band) > 1:
        upper = [f"{px:.1f},{y(group.mean + group.half):.1f}" for px, group in band]
        lower = [f"{px:.1f},{y(group.mean - group.half):.1f}" for px, group in reversed(band)]
        made.append(f'<polygon class="fs-band" points="{" ".join(upper + lower)}"/>')
    dots = sum(len(group.values) for _, _, group in there)
    if dots <= MOST_DOTS:
        made += [
            f'<circle class="fs-run" cx="{px:.1f}" cy="{y(value):.1f}" r="1.8"/>'
            for _, px, group in there
            for value in group.values
        ]
    if len(there) > 1 and numeric:
        points = " ".join(f"{px:.1f},{y(group.mean):.1f}" for _, px, group in there)
        made.append(f'<polyline class="fs-mean" points="{points}"/>')
    reach = min(ROUND, 0.5 * (right - LEFT) / max(1, len(values) - 1))
    for place, px, group in groups:
        made += signs(group, px, foot)
        py = y(group.mean) if group.values else foot - 6.0
        if group.values:
            made.append(f'<circle class="fs-point" cx="{px:.1f}" cy="{py:.1f}" r="3.2"/>')
        if group.values or group.gave_up or group.broken:
            target = f'<circle class="fs-target" cx="{px:.1f}" cy="{py:.1f}" r="{reach:.1f}"/>'
            made.append(link(shown, place, group, target))
    made.append(axis_titles(named(shown, axis), measure(shown), HEIGHT))
    return svg(HEIGHT, f"{measure(shown)} over {named(shown, axis)}", made) + key(shown)


def colour_map(shown: DrawnSweep, across: str, up: str) -> str:
    """The mean of each cell as a colour, over two axes."""
    columns, rows = shown.axes[across], shown.axes[up]
    wide = (WIDTH - LEFT - RIGHT) / len(columns)
    tall = min(wide * 1.4, TALLEST / len(rows))
    foot = TOP + tall * len(rows)
    height = foot + BOTTOM
    means = [group.mean for group in shown.cells.values() if group.values]
    low, high = rounded(means)
    made = [f'<rect class="fs-ground" x="{LEFT}" y="{TOP}" width="{wide * len(columns):.2f}" '
            f'height="{foot - TOP:.2f}"/>']  # fmt: skip
    for place, group in shown.cells.items():
        if across not in group.axes or up not in group.axes:
            continue
        px = LEFT + wide * columns.index(group.axes[across])
        py = foot - tall * (rows.index(group.axes[up]) + 1)
        box = f'x="{px:.2f}" y="{py:.2f}" width="{wide:.2f}" height="{tall:.2f}"'
        if not group.values and not group.gave_up and not group.broken:
            continue
        fill = f' fill="{colour(group.mean, low, high)}"' if group.values else ""
        style = "fs-cell" if group.values else "fs-cell fs-none"
        parts = [f'<rect class="{style}" {box}{fill}/>']
        parts += signs(group, px + 0.5 * wide, py + tall - 1.0)
        made.append(link(shown, place, group, "".join(parts)))
    made += [
        f'<text class="fs-tick" x="{LEFT + wide * (k + 0.5):.1f}" y="{foot + 13:.1f}" '
        f'text-anchor="middle">{html.escape(few_of(columns[k]))}</text>'
        for k in spread(len(columns))
    ]
    made += [
        f'<text class="fs-tick" x="{LEFT - 4}" y="{foot - tall * (k + 0.5) + 3.5:.1f}" '
        f'text-anchor="end">{html.escape(few_of(rows[k]))}</text>'
        for k in spread(len(rows))
    ]
    made.append(axis_titles(named(shown, across), named(shown, up), height))
    title = f"{measure(shown)} over {named(shown, across)} and {named(shown, up)}"
    return scale_key(shown, low, high) + svg(height, title, made) + key(shown)


class AxisScale:
    """Where a value lies along an axis of a picture."""

    def __init__(self, low: float, high: float, start: float, end: float, log: bool = False):
        self.low, self.high, self.start, self.end, self.log = low, high, start, end, log

    def __call__(self, value: float) -> float:
        low, high, value = (
            (math.log(one) for one in (self.low, self.high, value))
            if self.log
            else (self.low, self.high, value)
        )
        share = 0.5 if high == low else (value - low) / (high - low)
        return self.start + min(max(share, 0.0), 1.0) * (self.end - self.start)


def frame(
    x: AxisScale, y: AxisScale, places: list[float] | None, numeric: bool, values: Sequence[Any]
) -> str:
    """Lines and numbers at the axes."""
    made = [
        f'<line class="fs-grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y(one):.1f}" '
        f'y2="{y(one):.1f}"/><text class="fs-tick" x="{LEFT - 4}" y="{y(one) + 3.5:.1f}" '
        f'text-anchor="end">{few(one)}</text>'
        for one in steps(y.low, y.high)
    ]
    foot = y.start
    made.append(f'<line class="fs-edge" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{foot}" y2="{foot}"/>')
    if not numeric:
        marks = [(x(float(k)), few_of(values[k])) for k in spread(len(values))]
    elif places is not None:
        marks = [(x(one), few(one)) for one in places]
    elif x.log:
        powers = range(math.ceil(math.log10(x.low) - 1e-9), math.floor(math.log10(x.high)) + 1)
        found = [10.0**power for power in powers]
        found = found if len(found) > 1 else [x.low, math.sqrt(x.low * x.high), x.high]
        marks = [(x(one), few(one)) for one in found]
    else:
        marks = [(x(one), few(one)) for one in steps(x.low, x.high)]
    made += [
        f'<line class="fs-edge" x1="{px:.1f}" x2="{px:.1f}" y1="{foot}" y2="{foot + 4}"/>'
        f'<text class="fs-tick" x="{px:.1f}" y="{foot + 14}" text-anchor="middle">'
        f"{html.escape(words)}</text>"
        for px, words in marks
    ]
    return "".join(made)


def axis_titles(below: str, beside: str, height: float) -> str:
    """What the axes are."""
    middle = 0.5 * (TOP + height - BOTTOM)
    return (
        f'<text class="fs-axis" x="{0.5 * (LEFT + WIDTH - RIGHT)}" y="{height - 4}" '
        f'text-anchor="middle">{html.escape(below)}</text>'
        f'<text class="fs-axis" transform="translate(9 {middle:.1f}) rotate(-90)" '
        f'text-anchor="middle">{html.escape(beside)}</text>'
    )


def svg(height: float, title: str, parts: list[str]) -> str:
    """A picture as wide as its panel."""
    return (
        f'<svg class="fs-sweep" viewBox="0 0 {WIDTH:g} {height:.0f}" role="img" '
        f'aria-label="{html.escape(title)}">{"".join(parts)}</svg>'
    )


def link(shown: DrawnSweep, place: int, group: CellRuns, inside: str) -> str:
    """What a click opens a run of."""
    told = html.escape(told_of(shown, group))
    return (
        f'<g data-sweep="{html.escape(shown.name)}" data-cell="{place}" tabindex="0" '
        f'role="button"><title>{told}</title>{inside}</g>'
    )


def told_of(shown: DrawnSweep, group: CellRuns) -> str:
    """What is known of a cell, and what a click does."""
    where = ", ".join(
        f"{axis} = {few_of(value)}" for axis, value in group.axes.items() if axis in shown.axes
    )
    said = f"{where}: "
    if group.values:
        half = f" ± {few(group.half)}" if group.half == group.half else ""
        said += f"{few(group.mean)}{half}, {counted(len(group.values), 'run')}"
    said += f"; {group.gave_up} gave up" if group.gave_up else ""
    said += f"; {group.broken} failed" if group.broken else ""
    what = "the run nearest to the mean" if len(group.values) > 1 else "the run"
    return f"{said}. Click: open {what}"


def signs(group: CellRuns, x: float, foot: float) -> list[str]:
    """Marks of runs that gave up or failed."""
    made = []
    if group.gave_up:
        made.append(f'<path class="fs-gave-up" d="M{x - 3.5:.1f} {foot - 7:.1f}h7l-3.5 6z"/>')
    if group.broken:
        made.append(f'<path class="fs-broken" d="M{x - 3:.1f} {foot - 7:.1f}l6 6m0 -6l-6 6"/>')
    return made


def key(shown: DrawnSweep) -> str:
    """What is drawn, and what the marks mean that are there."""
    groups = shown.cells.values()
    more = []
    if any(group.gave_up for group in groups):
        more.append("▼ Runs gave up: in no mean")
    if any(group.broken for group in groups):
        more.append("× Runs failed")
    if len(shown.axes) == 1:
        more.insert(0, "Mean, 95 % interval and runs")
    more.append("Click: open the run nearest to the mean")
    return f'<div class="fs-quiet">{". ".join(more)}.</div>'


def scale_key(shown: DrawnSweep, low: float, high: float) -> str:
    """What the colours of a map mean."""
    stops = ", ".join(f"rgb{one}" for one in VIRIDIS)
    return (
        f'<div class="fs-scale"><span>{html.escape(measure(shown))}</span><span>{few(low)}</span>'
        f'<i style="background:linear-gradient(to right, {stops})"></i><span>{few(high)}</span>'
        "</div>"
    )


def ends(group: CellRuns) -> list[float]:
    """The values that a curve has to have room for."""
    if not group.values:
        return []
    half = group.half if group.half == group.half else 0.0
    return [*group.values, group.mean - half, group.mean + half]


def limits(column: str, seen: list[float]) -> tuple[float, float]:
    """The ends of the axis of what is measured: 0 to 1 for shares, else round ones."""
    name = observable_of(column)
    if name and scale(name).is_share:
        return 0.0, 1.02
    low, high = rounded(seen)
    return (0.0, high) if name and scale(name).low == 0.0 and low > 0.0 else (low, high)


def rounded(values: Sequence[float]) -> tuple[float, float]:
    """Round numbers about some values, which seldom change while more come.

    >>> rounded([0.13, 0.92]), rounded([])
    ((0.0, 1.0), (0.0, 1.0))
    """
    known = [one for one in values if math.isfinite(one)]
    if not known:
        return 0.0, 1.0
    low, high = min(known), max(known)
    if high - low < 1e-9 * max(1.0, abs(high)):
        low, high = low - 0.5 * max(abs(low), 1.0), high + 0.5 * max(abs(high), 1.0)
    step = nice((high - low) / 4.0)
    return math.floor(low / step + 1e-9) * step, math.ceil(high / step - 1e-9) * step


def nice(step: float) -> float:
    """The next of 1, 2, 2.5, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(step))
    return next(
        one * power for one in (1.0, 2.0, 2.5, 5.0, 10.0) if one * power >= step * (1 - 1e-9)
    )


def steps(low: float, high: float) -> list[float]:
    """Round numbers along an axis.

    >>> steps(0.0, 1.02)
    [0.0, 0.25, 0.5, 0.75, 1.0]
    """
    step = nice((high - low) / 4.2)
    first = math.ceil(low / step - 1e-9)
    return [round(k * step, 12) for k in range(first, math.floor(high / step + 1e-9) + 1)]


def spread(count: int) -> list[int]:
    """The places of at most so many labels as there is room for, evenly.

    >>> spread(3), spread(20)
    ([0, 1, 2], [0, 5, 10, 14, 19])
    """
    if count <= ROOM + 1:
        return list(range(count))
    return [round(one) for one in np.linspace(0, count - 1, ROOM).tolist()]


def colour(value: float, low: float, high: float) -> str:
    """The colour of a value in a map.

    >>> colour(0.0, 0.0, 1.0), colour(1.0, 0.0, 1.0)
    ('#440154', '#fde725')
    """
    share = min(max((value - low) / (high - low), 0.0), 1.0) * (len(VIRIDIS) - 1)
    k = min(int(share), len(VIRIDIS) - 2)
    mixed = (
        round(a + (b - a) * (share - k)) for a, b in zip(VIRIDIS[k], VIRIDIS[k + 1], strict=True)
    )
    return "#" + "".join(f"{one:02x}" for one in mixed)


def named(shown: DrawnSweep, axis: str) -> str:
    """An axis as its slider is called."""
    if axis == AGENTS:
        return "Agents"
    known = {one.name: one for one in numbers(shown.model)} if shown.model in MODELS else {}
    return worded(known[axis])[0] if axis in known else axis


def measure(shown: DrawnSweep) -> str:
    """What is measured, as plots call it."""
    name = observable_of(shown.column)
    if not name:
        return words(shown.column)
    models = [MODELS[shown.model]] if shown.model in MODELS else []
    over = shown.column.partition("-over-")[2]
    return titled(name, models) + (f", last {over} ticks" if over else "")
