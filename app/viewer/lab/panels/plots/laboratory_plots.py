"""The run so far as curves, of observables to choose, over the runs before it."""

from __future__ import annotations

import math

import viser

from agents.models.model import Model
from agents.observables.catalogue import usual_charts
from app.viewer.lab.panels.plots.overlay import Overlay
from app.viewer.measuring.earlier_runs import EarlierRuns
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_curves import choices, worded
from app.viewer.measuring.observable_format import told
from app.viewer.panels.export_permit import ExportPermit
from app.viewer.panels.plot_panel import Plot
from app.viewer.panels.plotted import Plotted
from app.viewer.panels.sending import Sender
from app.viewer.scene.shown.frame import Frame
from app.viewer.web.values import show

CHARTS = 3
WINDOWS = {"whole run": math.inf, "last 3000 ticks": 3000.0, "last 500 ticks": 500.0}
EARLIER = {"none": 0, "the last one": 1, "the last 2": 2, "the last 3": 3}


class LaboratoryPlots:
    """Some charts, each with the observables that it shows over time.

    A model brings its usual ones; what is chosen stays until another model comes.
    """

    def __init__(self, server: viser.ViserServer, allowed: ExportPermit | None = None):
        gui = server.gui
        self.model: Model | None = None
        self.asked: tuple[Model, tuple[str, ...]] | None = None
        """What a scene shows of a model that is about to come."""
        self.offered: tuple[str, ...] = ()
        self.choices: dict[str, tuple[str, ...]] = choices(())
        self.runs = EarlierRuns()
        self.sender = Sender(allowed)
        self.charts = [ChosenChart(server, number, self.sender) for number in range(1, CHARTS + 1)]
        self.window = gui.add_dropdown(
            "Plots of",
            tuple(WINDOWS),
            hint="How much of the run is plotted. Susceptibility and Binder's cumulant are taken "
            "over it, too",
        )
        self.earlier = gui.add_dropdown(
            "Earlier runs",
            tuple(EARLIER),
            initial_value="the last one",
            hint="Runs of the same model before this one, faint and dotted below it. Reset and "
            "Setup end a run; three are kept",
        )
        self.forget = gui.add_button_group("Runs kept", ("Forget them",), visible=False)
        self.forget.on_click(self.forgotten)

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

    async def forgotten(self, _event: viser.GuiEvent) -> None:
        self.runs.clear()

    def refresh(
        self, readings: FlockReadings, frame: Frame, beside: FlockReadings | None = None
    ) -> None:
        """Draw the run as far as it has come; dashed, that of the flock beside."""
        beside = None if frame.beside is None else beside
        runs = (readings,) if beside is None else (readings, beside)
        self.runs.follow(runs)
        self.offer(readings, beside)
        overlay = Overlay(runs, self.runs, EARLIER[self.earlier.value], self.last)
        first = True
        for chart in self.charts:
            chart.names = self.choices[chart.choice.value]
            chart.refresh(overlay, changes=first)
            first = first and not chart.names
        some = bool(self.runs.kept)
        if self.forget.visible != some:
            self.forget.visible = some

    def offer(self, readings: FlockReadings, beside: FlockReadings | None) -> None:
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

    def __init__(self, server: viser.ViserServer, number: int, sender: Sender):
        self.names: tuple[str, ...] = ()
        self.title = f"Plot {number}"
        self.choice = server.gui.add_dropdown(
            self.title, (worded(()),), hint="What to measure and to plot over the run"
        )
        self.overlay: Overlay | None = None
        self.plot = Plot(server, self.title, self.plotted, sender)

    def plotted(self) -> Plotted | None:
        """What it shows, to take home; None if that is nothing."""
        if self.overlay is None or not self.names:
            return None
        return self.overlay.plotted(self.names)

    def refresh(self, overlay: Overlay, changes: bool) -> None:
        """Draw its observables of all runs; `changes`: say above them what was changed.

        What the values are now is said in the title if there is but one, else in a key.
        """
        lone = len(self.names) == len(overlay.runs) == 1
        first = overlay.runs[0]
        now = told(self.names[0], first.values.get(self.names[0])) if lone else ""
        label = f"{self.title}: {now}" if lone else self.title
        if self.choice.label != label:
            self.choice.label = label
        self.overlay = overlay
        shown = overlay.shown(self.names, not lone, changes)
        self.plot.show(shown, overlay.head(self.names, keyed=True))
