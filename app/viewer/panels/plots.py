"""The run so far as curves, of observables to choose."""

from __future__ import annotations

import html
import math

import numpy as np
import viser
from viser import uplot

from agents.model import Model
from agents.observables.catalogue import usual_charts
from app.viewer.measuring.curves import choices, points, together, worded
from app.viewer.measuring.measured import scale, told
from app.viewer.measuring.readings import Readings
from app.viewer.panels.style import BLUE, GREEN, block, key
from app.viewer.run.beside import ratio
from app.viewer.scene.shown.frame import Frame
from app.viewer.web.values import show

HEIGHT = 106
PADDING = (10, 14, 0, 0)
DASH = (6.0, 5.0)
COLOURS = (BLUE, GREEN)
"""Of the first and of the second observable in a chart."""
CHARTS = 3
WINDOWS = {"whole run": math.inf, "last 3000 ticks": 3000.0, "last 500 ticks": 500.0}


class Plots:
    """Some charts, each with the observables that it shows over time.

    A model brings its usual ones; what is chosen stays until another model comes.
    """

    def __init__(self, gui: viser.GuiApi):
        self.model: Model | None = None
        self.offered: tuple[str, ...] = ()
        self.choices: dict[str, tuple[str, ...]] = choices(())
        self.charts = [Chart(gui, number) for number in range(1, CHARTS + 1)]
        self.window = gui.add_dropdown(
            "Plots of",
            tuple(WINDOWS),
            hint="How much of the run is plotted. Susceptibility and Binder's cumulant are taken "
            "over it, too",
        )

    @property
    def names(self) -> frozenset[str]:
        """The observables that are plotted."""
        return frozenset(name for one in self.charts for name in one.names)

    @property
    def last(self) -> float:
        """How many ticks are plotted, up to now."""
        return WINDOWS[self.window.value]

    def refresh(self, readings: Readings, frame: Frame, beside: Readings | None = None) -> None:
        """Draw the run as far as it has come; dashed, that of the flock beside."""
        second, each = frame.beside, 1.0
        if beside is None or second is None:
            beside = None
        else:
            each = ratio(second.dt, second.unit, frame.dt, frame.unit)
        self.offer(readings, beside)
        for chart in self.charts:
            chart.names = self.choices[chart.choice.value]
            chart.refresh(readings, beside, each, self.last)

    def offer(self, readings: Readings, beside: Readings | None) -> None:
        """Let what these flocks have be chosen; of another model, choose the usual."""
        others = () if beside is None else beside.offered
        offered = tuple(dict.fromkeys([*readings.offered, *others]))
        if offered != self.offered:
            self.offered, self.choices = offered, choices(offered)
            for chart in self.charts:
                chart.choice.options = tuple(self.choices)
        model = readings.flock.model
        if model is not self.model:
            self.model = model
            for chart, names in zip(self.charts, usual_charts(model, offered), strict=True):
                show(chart.choice, worded(names))


class Chart:
    """One chart, with the choice of what it shows as its title."""

    def __init__(self, gui: viser.GuiApi, number: int):
        self.names: tuple[str, ...] = ()
        self.drawn: tuple[tuple[str, ...], bool] = ((), False)
        """The observables that the chart is made for, and whether for two flocks."""
        self.title = f"Plot {number}"
        self.choice = gui.add_dropdown(
            self.title, (worded(()),), hint="What to measure and to plot over the run"
        )
        self.key = gui.add_html("", visible=False)
        nothing = np.zeros(1)
        self.plot = gui.add_uplot(
            (nothing,) * 5,
            series((), False),
            scales={"x": uplot.Scale(time=False), "y": uplot.Scale()},
            axes=(uplot.Axis(size=26), uplot.Axis(size=44)),
            legend=uplot.Legend(show=False),
            height=HEIGHT,
            padding=PADDING,
            visible=False,
        )

    def refresh(
        self, readings: Readings, beside: Readings | None, each: float, last: float
    ) -> None:
        """Draw the observables of the flock, and dashed those of the one beside."""
        some = bool(self.names)
        if self.plot.visible != some:
            self.plot.visible = some
        runs = (readings,) if beside is None else (readings, beside)
        self.head(runs)
        if not some:
            return
        self.remake((self.names, beside is not None))
        ratios = [1.0, each][: len(runs)]
        curves = [points(run, name, last) for run in runs for name in self.names]
        at, *values = together(curves, [ratio for ratio in ratios for _ in self.names])
        columns = [np.full(len(at), np.nan)] * 4
        for place, value in enumerate(values):
            run, name = divmod(place, len(self.names))
            columns[2 * run + name] = value
        draw(self.plot, (at, *columns))

    def head(self, runs: tuple[Readings, ...]) -> None:
        """Say what the values are now: in the title if there is but one, else in a key."""
        lone = len(self.names) == len(runs) == 1
        now = told(self.names[0], runs[0].values.get(self.names[0])) if lone else ""
        label = f"{self.title}: {now}" if lone else self.title
        if self.choice.label != label:
            self.choice.label = label
        keyed = bool(self.names) and not lone
        if self.key.visible != keyed:
            self.key.visible = keyed
        if keyed:
            self.key.content = block(head(self.names, runs))

    def remake(self, wanted: tuple[tuple[str, ...], bool]) -> None:
        """Give the chart the curves and the scale of other observables."""
        if wanted == self.drawn:
            return
        self.drawn = wanted
        self.plot.series = series(*wanted)
        self.plot.scales = {"x": uplot.Scale(time=False), "y": axis(wanted[0])}


def series(names: tuple[str, ...], both: bool) -> tuple[uplot.Series, ...]:
    """The curves of two observables, then the dashed ones of the flock beside; some hidden."""
    made = [uplot.Series(label="tick")]
    for run in range(2):
        for place, colour in enumerate(COLOURS):
            shown = place < len(names) and (both or not run)
            one = uplot.Series(stroke=colour, width=2, show=shown, points={"show": False})
            if run:
                one["dash"] = DASH
            made.append(one)
    return tuple(made)


def axis(names: tuple[str, ...]) -> uplot.Scale:
    """The vertical scale of observables: 0 to 1 for shares, from 0 for counts and lengths."""
    scales = [scale(name) for name in names]
    if all(one.is_share for one in scales):
        return uplot.Scale(range=(0.0, 1.02))
    if all(one.low == 0.0 for one in scales):
        return uplot.Scale(range=(0.0, None))
    return uplot.Scale()


def head(names: tuple[str, ...], runs: tuple[Readings, ...]) -> str:
    """The key to the curves, with the values as they are now."""
    entries = []
    for name, colour in zip(names, COLOURS, strict=False):
        now = " · ".join(told(name, run.values.get(name)) for run in runs)
        label = html.escape(worded((name,)))
        entries.append((f"{label} <b>{now}</b>", colour))
    return key(entries)


def draw(plot: viser.GuiUplotHandle, columns: tuple[np.ndarray, ...]) -> None:
    """Show columns if there is anything new in them."""
    pairs = zip(columns, plot.data, strict=True)
    if any(not np.array_equal(a, b, equal_nan=True) for a, b in pairs):
        plot.data = columns
