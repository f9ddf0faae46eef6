"""What one browser plots of the run: each chooses for itself, and what it needs is worked out once
for all who have chosen the same."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

import viser

from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES, usual_charts
from app.viewer.lab.panels.plots.laboratory_plots import WINDOWS
from app.viewer.lab.panels.plots.overlay import Overlay
from app.viewer.measuring.earlier_runs import EarlierRuns
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_curves import choices, worded
from app.viewer.measuring.observable_format import COUNTED, QUICK, STEADY
from app.viewer.panels.chart import Chart, ChartContents
from app.viewer.web.values import show

CHARTS = 2
POINTS = 200
"""Points of a curve, about: every browser is sent its own."""
MOST = 6
"""Observables that are measured for those who watch, beside those that always are."""
ALWAYS = frozenset((*QUICK, *STEADY, *COUNTED))


@dataclass
class CurveCache:
    """The curves of a run as they are now; worked out when first asked for."""

    runs: tuple[FlockReadings, ...]
    earlier: EarlierRuns
    most: int
    """Earlier runs that are shown."""
    offered: tuple[str, ...]
    """What can be plotted."""
    measured: frozenset[str]
    """What is measured of it."""
    overlays: dict[float, Overlay] = field(default_factory=dict)
    made: dict[tuple[float, tuple[str, ...]], ChartContents] = field(default_factory=dict)

    @property
    def model(self) -> Model:
        """That of the first flock."""
        return self.runs[0].flock.model

    def of(self, names: tuple[str, ...], last: float) -> ChartContents:
        """What a chart of observables shows over the `last` ticks."""
        if (last, names) not in self.made:
            if last not in self.overlays:
                self.overlays[last] = Overlay(self.runs, self.earlier, self.most, last)
            shown = self.overlays[last].shown(names, keyed=True)
            missing = [name for name in names if name not in self.measured]
            if missing:
                words = html.escape(worded(tuple(missing)))
                more = f"{words}: not measured, since the class plots {MOST} others"
                shown = shown._replace(head=f'{shown.head}<div class="fs-quiet">{more}</div>')
            self.made[last, names] = shown
        return self.made[last, names]


def wanted(chosen: Iterable[Iterable[str]]) -> frozenset[str]:
    """What is to be measured for all who watch: of too much, what most of them have chosen."""
    votes = Counter(name for names in chosen for name in set(names) - ALWAYS)
    order = list(OBSERVABLES)
    first = sorted(votes, key=lambda name: (-votes[name], order.index(name)))
    return frozenset(first[:MOST])


class OwnPlots:
    """The charts of one browser, each with the choice of what it shows as its title."""

    def __init__(self, gui: viser.GuiApi):
        self.model: Model | None = None
        self.offered: tuple[str, ...] = ()
        self.choices = choices(())
        self.charts = []
        for number in range(1, CHARTS + 1):
            choice = gui.add_dropdown(
                f"Plot {number}", (worded(()),), hint="What to plot, in this browser"
            )
            self.charts.append((choice, Chart(gui, points=POINTS)))
        self.window = gui.add_dropdown(
            "Plots of", tuple(WINDOWS), hint="How much of the run is plotted, in this browser"
        )

    @property
    def names(self) -> frozenset[str]:
        """The observables that are plotted."""
        chosen = (self.choices.get(choice.value, ()) for choice, _ in self.charts)
        return frozenset(name for names in chosen for name in names)

    def refresh(self, curves: CurveCache) -> None:
        """Draw the run as far as it has come."""
        self.offer(curves)
        last = WINDOWS[self.window.value]
        for choice, chart in self.charts:
            chart.show(curves.of(self.choices.get(choice.value, ()), last))

    def offer(self, curves: CurveCache) -> None:
        """Let what these flocks have be chosen; of another model, choose the usual."""
        if curves.offered != self.offered:
            self.offered, self.choices = curves.offered, choices(curves.offered)
            for choice, _ in self.charts:
                choice.options = tuple(self.choices)
        if curves.model is not self.model:
            self.model = curves.model
            usual = usual_charts(curves.model, curves.offered)
            for (choice, _), names in zip(self.charts, usual, strict=False):
                show(choice, worded(names))
