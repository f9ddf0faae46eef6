"""One chart: curves over time, and what is said above them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import viser
from viser import uplot

from app.viewer.panels.style import block

HEIGHT = 106
PADDING = (10, 14, 0, 0)
DASH = (6.0, 5.0)


class Curve(NamedTuple):
    """A curve and how it is drawn."""

    colour: str
    """CSS."""
    values: np.ndarray
    """(K,), NaN where there is none."""
    dashed: bool = False
    width: float = 2.0
    """Pixels."""

    @property
    def pen(self) -> tuple[str, bool, float]:
        """All but the values."""
        return self.colour, self.dashed, self.width


class Chart:
    """Shows curves; hidden while it has none."""

    def __init__(self, gui: viser.GuiApi):
        self.pens: tuple[tuple[str, bool, float], ...] = ()
        self.scales: dict[str, uplot.Scale] = {"x": uplot.Scale(time=False), "y": uplot.Scale()}
        self.head = gui.add_html("", visible=False)
        nothing = np.zeros(1)
        self.plot = gui.add_uplot(
            (nothing, nothing),
            (uplot.Series(label="t"), uplot.Series(label="nothing")),
            scales=self.scales,
            axes=(uplot.Axis(size=26), uplot.Axis(size=44)),
            legend=uplot.Legend(show=False),
            height=HEIGHT,
            padding=PADDING,
            visible=False,
        )

    def show(
        self, head: str, at: np.ndarray, curves: Sequence[Curve], x: uplot.Scale, y: uplot.Scale
    ) -> None:
        """Draw curves over `at` (K,), below the HTML of a head; each only if there is any."""
        if head:
            self.head.content = block(head)
        if curves:
            self.draw(at, curves, x, y)
        self.head.visible, self.plot.visible = bool(head), bool(curves)

    def draw(self, at: np.ndarray, curves: Sequence[Curve], x: uplot.Scale, y: uplot.Scale) -> None:
        """Tell browsers what has changed of the curves; there are some."""
        scales = {"x": x, "y": y}
        if scales != self.scales:
            self.scales = self.plot.scales = scales
        columns = (at, *(curve.values for curve in curves))
        pens = tuple(curve.pen for curve in curves)
        if pens != self.pens:
            self.pens = pens
            self.plot.data = columns
            self.plot.series = (uplot.Series(label="t"), *(series(*pen) for pen in pens))
        elif any(
            not np.array_equal(a, b, equal_nan=True)
            for a, b in zip(columns, self.plot.data, strict=True)
        ):
            self.plot.data = columns


def series(colour: str, dashed: bool, width: float) -> uplot.Series:
    """How a curve is drawn."""
    more: Any = {"dash": DASH} if dashed else {}
    return uplot.Series(stroke=colour, width=width, points={"show": False}, **more)
