"""One chart: curves over time between titled axes, and what is said above them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import viser
from viser import uplot

from app.viewer.measuring.observable_curves import thinned
from app.viewer.panels.plotted import DOT
from app.viewer.panels.style import block

HEIGHT, POINTS = 190, 400
"""Of a chart in a panel: pixels, and points of a curve at most, about."""
LARGE_HEIGHT, LARGE_POINTS = 400, 1500
"""The same of one that is shown large."""
PADDING = (10, 14, 0, 0)
DASH = (6.0, 5.0)
X = uplot.Scale(time=False)
"""Numbers, and no dates."""
TYPE = '11px "Flockscope Sans", sans-serif'
ROOM = {"x": 28, "y": 42, "title": 18}
"""Pixels for the numbers at the axes, and for the title of one."""


class ChartCurve(NamedTuple):
    """A curve and how it is drawn."""

    colour: str
    """CSS."""
    values: np.ndarray
    """(K,), NaN where there is none."""
    label: str = ""
    """What it is, with its unit, where the values under the mouse are told."""
    dash: tuple[float, ...] = ()
    """Pixels drawn and left out in turn; none: all are drawn."""
    width: float = 2.0
    """Pixels."""
    dots: bool = False
    """Whether its values are dots and no line."""

    @property
    def pen(self) -> tuple[str, str, tuple[float, ...], float, bool]:
        """All but the values."""
        return self.colour, self.label, self.dash, self.width, self.dots


class ChartContents(NamedTuple):
    """What a chart shows."""

    head: str
    """HTML above it; nothing if it is empty."""
    at: np.ndarray
    """(K,) times."""
    curves: tuple[ChartCurve, ...]
    """Nothing is drawn without any."""
    titles: tuple[str, str]
    """Of the axes, with units: of the times, and of the values."""
    y: uplot.Scale


NOTHING = ChartContents("", np.zeros(1), (), ("", ""), uplot.Scale())


class Chart:
    """Shows curves; hidden while it has none."""

    def __init__(self, gui: viser.GuiApi, height: int = HEIGHT, points: int = POINTS):
        self.points = points
        self.pens: tuple[Any, ...] = ()
        self.titles = ("", "")
        self.scales: dict[str, uplot.Scale] = {"x": X, "y": uplot.Scale()}
        self.head = gui.add_html("", visible=False)
        nothing = np.zeros(1)
        self.plot = gui.add_uplot(
            (nothing, nothing),
            (uplot.Series(label="t"), uplot.Series(label="nothing")),
            scales=self.scales,
            axes=axes(*self.titles),
            height=height,
            padding=PADDING,
            visible=False,
        )

    def show(self, shown: ChartContents) -> None:
        """Draw curves below the HTML of a head; each only if there is any."""
        if shown.head:
            self.head.content = block(shown.head)
        if shown.curves:
            self.draw(shown)
        self.head.visible, self.plot.visible = bool(shown.head), bool(shown.curves)

    def draw(self, shown: ChartContents) -> None:
        """Tell browsers what has changed of the curves; there are some.

        Whatever is not only new data has a browser make the chart anew. viser's client then takes
        the share of the times that it shows from the old chart and the new data, and is wrong if
        those have other ends: so the new ones only come with the next call.
        """
        columns = self.columns(shown)
        scales = {"x": X, "y": shown.y}
        pens = (shown.titles[0], *(curve.pen for curve in shown.curves))
        anew = (scales, shown.titles, pens) != (self.scales, self.titles, self.pens)
        if anew and self.plot.visible:
            columns = self.between(columns, others=pens != self.pens)
        if not same(columns, self.plot.data):
            self.plot.data = columns
        if scales != self.scales:
            self.scales = self.plot.scales = scales
        if shown.titles != self.titles:
            self.titles = shown.titles
            self.plot.axes = axes(*shown.titles)
        if pens != self.pens:
            self.pens = pens
            made = (series(*curve.pen) for curve in shown.curves)
            self.plot.series = (uplot.Series(label=shown.titles[0]), *made)

    def columns(self, shown: ChartContents) -> tuple[np.ndarray, ...]:
        """The times and the curves as they are drawn: over some time, be it ever so short."""
        drawn = self.drawn(shown)
        columns = (shown.at[drawn], *(curve.values[drawn] for curve in shown.curves))
        if columns[0][0] < columns[0][-1]:
            return columns
        return (
            columns[0][:1] + np.array([0.0, 1.0]),
            *(np.append(one[:1], np.nan) for one in columns[1:]),
        )

    def between(self, columns: tuple[np.ndarray, ...], others: bool) -> tuple[np.ndarray, ...]:
        """What a chart that is made anew begins with: its curves, if their ends are the same.

        If not, the curves as they were, or none if they are `others`.
        """
        before = self.plot.data
        ends = before[0][[0, -1]]
        if np.array_equal(ends, columns[0][[0, -1]]):
            return columns
        if not others:
            return before
        return (ends, *(np.full(2, np.nan) for _ in columns[1:]))

    def drawn(self, shown: ChartContents) -> np.ndarray:
        """Which of the points are drawn: few enough, always every dot and the last of a curve."""
        known = (
            np.flatnonzero(np.isfinite(curve.values))[0 if curve.dots else -1 :]
            for curve in shown.curves
        )
        return np.unique(np.concatenate([thinned(shown.at, self.points), *known]))


def same(columns: Sequence[np.ndarray], others: Sequence[np.ndarray]) -> bool:
    """Whether all of some columns are those of others."""
    return len(columns) == len(others) and all(
        np.array_equal(a, b, equal_nan=True) for a, b in zip(columns, others, strict=True)
    )


def axes(x: str, y: str) -> tuple[uplot.Axis, uplot.Axis]:
    """The axes below and to the left, by their titles."""
    type: Any = {"font": TYPE, "labelFont": TYPE, "labelSize": ROOM["title"], "labelGap": 0}
    return (
        uplot.Axis(label=x, size=ROOM["x"], **type),
        uplot.Axis(label=y, size=ROOM["y"], **type),
    )


def series(
    colour: str, label: str, dash: tuple[float, ...], width: float, dots: bool
) -> uplot.Series:
    """How a curve is drawn."""
    if dots:
        shape: Any = {"show": True, "size": DOT, "fill": colour, "width": 0}
        # They lie on curves. Without one of them uPlot would find no end of the axis.
        return uplot.Series(label=label, stroke=colour, width=0, points=shape, auto=False)
    more: Any = {"dash": dash} if dash else {}
    return uplot.Series(label=label, stroke=colour, width=width, points={"show": False}, **more)
