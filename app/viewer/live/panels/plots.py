"""The last minute of a room as curves: times of its loop, lags of its cars, how close they are."""

from __future__ import annotations

import html
from collections.abc import Sequence

import numpy as np
import viser
from viser import uplot

from app.viewer.live.course import Course
from app.viewer.panels.plots import HEIGHT, PADDING, draw
from app.viewer.panels.style import BLUE, GREEN, GREY, ORANGE, RED, VIOLET, block, key

WINDOW = 60.0
"""Seconds that are plotted."""
CURVES = (BLUE, ORANGE, GREEN, VIOLET, RED, "#0b7285", "#a61e4d", "#5c940d")
"""Colours of the cars' curves, in turn."""
DASH = (6.0, 5.0)


class LivePlots:
    """Three charts over the last minute."""

    def __init__(self, gui: viser.GuiApi, rate: float):
        """`rate` is that of the loop, Hz."""
        self.due = 1000.0 / rate
        self.times = Chart(gui, floor=True, most=4.0 * self.due)
        self.lags = Chart(gui)
        self.least = Chart(gui, floor=True)

    def refresh(self, course: Course, names: Sequence[str], length: float) -> None:
        """Draw what there is of the cars of these names, which are so long (m)."""
        all_times = course.times
        if not len(all_times):
            return
        recent = all_times >= all_times[-1] - WINDOW
        ago = all_times[recent] - all_times[-1]

        def cut(values: np.ndarray) -> np.ndarray:
            return values[recent]

        level = np.ones(len(ago))
        self.times.show(
            "Loop and latency, ms",
            ago,
            {
                "median": (BLUE, cut(course.loop), False),
                "worst": (ORANGE, cut(course.worst), False),
                "latency": (GREEN, cut(course.latency), False),
                "due": (GREY, self.due * level, True),
            },
        )
        ink = colours(names)
        self.lags.show(
            "Phase lag behind the injected car, deg",
            ago,
            {
                name: (ink[name], cut(course.lags[name]), False)
                for name in names
                if name in course.lags
            },
        )
        self.least.show(
            "Least distance of two cars, m",
            ago,
            {
                "least": (BLUE, cut(course.least), False),
                "a car's length": (RED, length * level, True),
            },
        )


Curve = tuple[str, np.ndarray, bool]
"""Colour, values and whether it is dashed."""


class Chart:
    """One chart with its title and key; hidden while it has no curve."""

    def __init__(self, gui: viser.GuiApi, floor: bool = False, most: float = np.inf):
        """`floor`: the vertical axis begins at 0; it does not go beyond `most`."""
        self.floor = floor
        self.most = most
        self.names: tuple[str, ...] = ()
        self.bounds = (0.0, 1.0)
        self.head = gui.add_html("", visible=False)
        nothing = np.zeros(1)
        self.plot = gui.add_uplot(
            (nothing, nothing),
            (uplot.Series(label="s"), uplot.Series(label="nothing")),
            scales=scales(self.bounds),
            axes=(uplot.Axis(size=26), uplot.Axis(size=44)),
            legend=uplot.Legend(show=False),
            height=HEIGHT,
            padding=PADDING,
            visible=False,
        )

    def show(self, title: str, ago: np.ndarray, curves: dict[str, Curve]) -> None:
        """Draw curves, name -> how, over the seconds before now, all of one length."""
        known = {name: one for name, one in curves.items() if np.isfinite(one[1]).any()}
        self.plot.visible = self.head.visible = bool(known)
        if not known:
            return
        self.head.content = block(
            f'<div class="fs-head">{html.escape(title)}</div>'
            + key([(html.escape(name), colour) for name, (colour, _, _) in known.items()])
        )
        columns = reaching_back(ago, *(values for _, values, _ in known.values()))
        bounds = around(
            [np.minimum(values, self.most) for _, values, _ in known.values()], self.floor
        )
        if bounds != self.bounds:
            self.bounds = bounds
            self.plot.scales = scales(bounds)
        if tuple(known) != self.names:
            self.names = tuple(known)
            self.plot.data = columns
            self.plot.series = series(known)
        draw(self.plot, columns)


def scales(bounds: tuple[float, float]) -> dict[str, uplot.Scale]:
    """The last minute across, and what is given upwards; a chart cannot tell it where some values
    are not known."""
    return {
        "x": uplot.Scale(time=False, range=(-WINDOW, 0.0)),
        "y": uplot.Scale(range=bounds),
    }


def around(curves: Sequence[np.ndarray], floor: bool) -> tuple[float, float]:
    """Round numbers below and above all known values, from 0 if `floor`; they seldom change.

    >>> around([np.array([10.1, np.nan]), np.array([14.3])], floor=True)
    (0.0, 15.0)
    >>> around([np.array([-52.0, 34.0])], floor=False)
    (-75.0, 50.0)
    """
    known = np.concatenate([values[np.isfinite(values)] for values in curves])
    low, high = min(0.0, known.min()) if floor else known.min(), known.max()
    span = max(high - low, 1e-3)
    decade = 10.0 ** np.floor(np.log10(span))
    step = decade * (0.5 if span < 2.5 * decade else 1.0 if span < 5.0 * decade else 2.5)
    return float(step * np.floor(low / step)), float(step * (np.floor(high / step) + 1.0))


def reaching_back(ago: np.ndarray, *values: np.ndarray) -> tuple[np.ndarray, ...]:
    """Columns of a chart that begin a whole window ago, with nothing where nothing is known.

    >>> reaching_back(np.array([-1.0, 0.0]), np.array([7.0, 8.0]))
    (array([-60.,  -1.,   0.]), array([nan,  7.,  8.]))
    """
    if ago[0] <= -WINDOW:
        return ago, *values
    return np.append(-WINDOW, ago), *(np.append(np.nan, one) for one in values)


def series(curves: dict[str, Curve]) -> tuple[uplot.Series, ...]:
    """How the curves are drawn."""
    made = [uplot.Series(label="s")]
    for name, (colour, _, dashed) in curves.items():
        one = uplot.Series(label=name, stroke=colour, width=2, points={"show": False})
        if dashed:
            one["dash"], one["width"] = DASH, 1.2
        made.append(one)
    return tuple(made)


def colours(names: Sequence[str]) -> dict[str, str]:
    """The colour of each car's curve, CSS.

    >>> colours(["red", "blue"])["red"]
    '#1c7ed6'
    """
    return {name: CURVES[place % len(CURVES)] for place, name in enumerate(names)}
