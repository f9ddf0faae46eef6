"""The run so far as curves, of observables to choose."""

from __future__ import annotations

import html
import math

import viser
from viser import uplot

from agents.models.model import Model
from agents.observables.catalogue import usual_charts
from app.viewer.measuring.curves import choices, points, together, worded
from app.viewer.measuring.measured import scale, told
from app.viewer.measuring.readings import Readings
from app.viewer.panels.chart import Chart, Curve
from app.viewer.panels.style import BLUE, GREEN, key
from app.viewer.run.beside import ratio
from app.viewer.scene.shown.frame import Frame
from app.viewer.web.values import show

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
        self.asked: tuple[Model, tuple[str, ...]] | None = None
        """What a scene shows of a model that is about to come."""
        self.offered: tuple[str, ...] = ()
        self.choices: dict[str, tuple[str, ...]] = choices(())
        self.charts = [ChosenChart(gui, number) for number in range(1, CHARTS + 1)]
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

    @property
    def chosen(self) -> tuple[str, ...]:
        """What is plotted, as the charts call it; empty where it is as usual."""
        usual = () if self.model is None else usual_charts(self.model, self.offered)
        now = tuple(chart.choice.value for chart in self.charts)
        return () if now == tuple(map(worded, usual)) else now

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
        if self.asked is not None and self.asked[0] is model:
            for chart, name in zip(self.charts, self.asked[1], strict=False):
                if name in self.choices:
                    show(chart.choice, name)
            self.asked = None


class ChosenChart:
    """A chart with the choice of what it shows as its title."""

    def __init__(self, gui: viser.GuiApi, number: int):
        self.names: tuple[str, ...] = ()
        self.title = f"Plot {number}"
        self.choice = gui.add_dropdown(
            self.title, (worded(()),), hint="What to measure and to plot over the run"
        )
        self.chart = Chart(gui)

    def refresh(
        self, readings: Readings, beside: Readings | None, each: float, last: float
    ) -> None:
        """Draw the observables of the flock, and dashed those of the one beside.

        What the values are now is said in the title if there is but one, else in a key.
        """
        runs = (readings,) if beside is None else (readings, beside)
        lone = len(self.names) == len(runs) == 1
        now = told(self.names[0], runs[0].values.get(self.names[0])) if lone else ""
        self.choice.label = f"{self.title}: {now}" if lone else self.title
        pairs = [(run, name) for run in runs for name in self.names]
        ratios = [1.0 if run is readings else each for run, _ in pairs]
        at, *values = together([points(run, name, last) for run, name in pairs], ratios)
        curves = [
            Curve(COLOURS[self.names.index(name)], value, dashed=run is not readings)
            for (run, name), value in zip(pairs, values, strict=True)
        ]
        keyed = head(self.names, runs) if self.names and not lone else ""
        self.chart.show(keyed, at, curves, uplot.Scale(time=False), axis(self.names))


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
