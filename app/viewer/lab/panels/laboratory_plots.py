"""The run so far as curves, of observables to choose, over the runs before it."""

from __future__ import annotations

import html
import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import viser
from viser import uplot

from agents.catalogue import short_model_name
from agents.models.model import Model
from agents.observables.catalogue import default_charts, find_observable
from app.front.controls import set_value
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.kept_runs import KeptRun, KeptRuns
from app.viewer.measuring.observable_curves import (
    ObservableHistory,
    Points,
    align_curves,
    chart_title,
    choices,
    overlay_curves,
    points,
    thin_ticks,
)
from app.viewer.measuring.observable_format import format_observable, observable_words, scale
from app.viewer.measuring.observable_table import TICKS, observable_title, table, unit
from app.viewer.measuring.run_conditions import TOLD, ConditionHistory, RunConditions
from app.viewer.panels.chart import DASH, ChartContents, ChartCurve, Line, Plot, Plotted, plot_csv
from app.viewer.panels.sending import ExportPermit, Sender
from app.viewer.panels.shell import BLUE, GREEN, key
from app.viewer.run.paired_run import ratio
from app.viewer.scene.shown.frame import Frame

# What the plots of a page show: the flocks of now, and under them the runs before.

COLOURS = (BLUE, GREEN)
"""Of the first and of the second observable in a chart."""
DOTS = ((2.0, 3.0), (2.0, 6.0), (6.0, 3.0, 1.0, 3.0))
STRENGTHS = (0.75, 0.6, 0.5)
"""How the latest of those runs is drawn, the one before it, and so on."""
THIN = 1.5
SHARE, ROOM = (0.0, 1.02), 27
"""The axis of a share, and letters that an axis of a chart has room for."""
MARKS = 60
"""Marks of a run that are drawn, about: a slider that is dragged makes one a tick."""
CAPTION = 105
"""Letters in a line of a figure's caption."""


@dataclass(frozen=True)
class OverlaidRun:
    """A kept run as it is shown under those of now."""

    run: KeptRun
    label: str
    age: int
    """0 for the latest one of its model."""
    each: float
    """Ticks of the first flock that last as long as one of its own."""
    whose: str = ""
    """The name of its model, of two."""

    @property
    def course(self) -> ObservableHistory:
        """How it went."""
        return self.run.course

    @property
    def short_label(self) -> str:
        """What its curves are called under the mouse, whatever is changed in the runs of now."""
        return ", ".join(filter(None, (self.whose, f"run {self.run.number}")))


class Overlay:
    """The runs of now, one or two side by side, over those kept runs of each model that are ticked.

    All are drawn over the time of the first, of which the `last` ticks are shown.
    """

    def __init__(self, runs: Sequence[FlockReadings], kept: KeptRuns, last: float):
        self.runs, self.last = runs, last
        self.histories = [run.conditions for run in runs]
        self.of = [history.last for history in self.histories]
        self.each = [self.ratio(conditions) for conditions in self.of]
        self.before: list[OverlaidRun] = []
        for now, history in zip(self.of, self.histories, strict=True):
            for age, run in enumerate(kept.shown_of(now.model)):
                differences = run.course.history.differences(history)
                whose = now.model.name if len(runs) > 1 else ""
                label = ", ".join(filter(None, (whose, run.label)))
                label = f"{label}: {differences}" if differences else label
                each = self.ratio(run.course.conditions)
                self.before.append(OverlaidRun(run, label, age, each, whose))

    def ratio(self, of: RunConditions) -> float:
        """Ticks of the first flock that last as long as one of another."""
        return ratio(of.dt, of.unit, self.of[0].dt, self.of[0].unit)

    @property
    def models(self) -> list[Model]:
        """Those of now."""
        return [conditions.model for conditions in self.of]

    @property
    def clock(self) -> tuple[float, str]:
        """How long a tick of the first flock lasts, and the title of an axis of time."""
        first = self.of[0]
        return (1.0, "tick") if first.unit == TICKS else (first.dt, f"time ({first.unit})")

    def chart_contents(
        self, names: tuple[str, ...], keyed: bool, changes: bool = True
    ) -> ChartContents:
        """What a chart of observables shows; `keyed` if its head tells them apart.

        `changes`: whether its head says what was changed in the runs of now.
        """
        lasts, title = self.clock
        pairs = [(place, name) for place in range(len(self.runs)) for name in names]
        at, *now = align_curves(
            [points(self.runs[k], name, self.last / self.each[k]) for k, name in pairs],
            [self.each[k] for k, _ in pairs],
        )
        under = [(run, name) for run in self.before for name in names]
        past_curves = [self.window(self.scale_run(run, name), at[-1]) for run, name in under]
        at, now, old = overlay_curves(at, now, past_curves, is_whole=np.isinf(self.last))
        at, now, old = merge_ticks(self.all_marks, at, now, old)
        curves: list[ChartCurve] = []
        for (run, name), values in zip(under, old, strict=True):
            if np.isfinite(values).any():
                colour = f"{COLOURS[names.index(name)]}{round(255 * STRENGTHS[run.age]):02x}"
                label = f"{observable_title(name, self.models)}, {run.short_label}"
                where = marks(run.course.history, run.each)
                curves += [dots(colour, values_at_ticks(where, at, values))] * bool(len(where))
                curves.append(ChartCurve(colour, values, label, DOTS[run.age], THIN))
        for (k, name), values in zip(pairs, now, strict=True):
            where = marks(self.histories[k], self.each[k])
            curves.append(dots(COLOURS[names.index(name)], values_at_ticks(where, at, values)))
        for (k, name), values in zip(pairs, now, strict=True):
            dash = DASH if k else ()
            curves.append(ChartCurve(COLOURS[names.index(name)], values, self.label(name, k), dash))
        head = self.head(names, keyed, changes)
        return ChartContents(
            head, at * lasts, tuple(curves), (title, self.axis(names)), axis(names)
        )

    @property
    def all_marks(self) -> np.ndarray:
        """The ticks (K,) of the first flock at which something was changed in any run."""
        runs = list(zip(self.histories, self.each, strict=True))
        runs += [(run.course.history, run.each) for run in self.before]
        return np.concatenate([marks(history, each) for history, each in runs])

    def scale_run(self, run: OverlaidRun, name: str) -> Points:
        """How an observable of an earlier run went over the time of the first flock."""
        at, values = run.course.points(name)
        return at * run.each, values

    def window(self, curve: Points, now: float) -> Points:
        """The part of an earlier curve that is shown: of the whole run all of it."""
        at, values = curve
        if np.isinf(self.last):
            return curve
        in_window = (at >= now - self.last) & (at <= now)
        return at[in_window], values[in_window]

    def label(self, name: str, k: int) -> str:
        """What a curve of now is: its observable, and of two flocks its model."""
        whose = f", {short_model_name(self.models[k].name)}" if len(self.runs) > 1 else ""
        return f"{observable_title(name, self.models)}{whose}"

    def axis(self, names: tuple[str, ...], room: float = ROOM) -> str:
        """The title of an axis of observables, in so many letters, about."""
        if len(names) == 1:
            return observable_title(names[0], self.models)
        units = {unit(name, self.models) for name in names}
        shared = units.pop() if len(units) == 1 else "1"
        of = "" if shared == "1" else f" ({shared})"
        for wording in (observable_words, short_name):
            title = ", ".join(map(wording, names)) + of
            if len(title) <= room:
                return title
        return f"value{of}"

    def head(self, names: tuple[str, ...], keyed: bool, changes: bool = True) -> str:
        """The key to the curves: of those of now with their values, if `keyed`, then of others."""
        if not names:
            return ""
        text = ""
        if keyed:
            entries = []
            for name, colour in zip(names, COLOURS, strict=False):
                now = " · ".join(format_observable(name, run.values.get(name)) for run in self.runs)
                entries.append((f"{html.escape(chart_title((name,)))} <b>{now}</b>", colour))
            text = key(entries)
        changed = "".join(
            f'<span><i class="fs-dot"></i>{html.escape(change)}</span>'
            for change in (self.changes() if changes else ())
        )
        text += f'<div class="fs-key fs-changed">{changed}</div>' if changed else ""
        overlaid = [run for run in self.before if any(len(run.course.points(n)[0]) for n in names)]
        lines = "".join(
            f'<span><i class="fs-line fs-before-{run.age}"></i>{html.escape(run.label)}</span>'
            for run in overlaid
        )
        return f'{text}<div class="fs-key fs-before">{lines}</div>' if lines else text

    def changes(self) -> list[str]:
        """What was changed in the runs of now, in a few entries; of two runs whose it is."""
        per_history = [history.changes() for history in self.histories]
        lines = list(per_history[0])
        if len(per_history) > 1:
            shared = [line for line in per_history[0] if line in per_history[1]]
            lines = shared + [
                f"{of.model.name}: {change}"
                for of, changes in zip(self.of, per_history, strict=True)
                for change in changes
                if change not in shared
            ]
        return [*lines[:TOLD], *["…"] * (len(lines) > TOLD)]

    def plot_contents(self, names: tuple[str, ...]) -> Plotted:
        """What a chart of observables shows, to take home."""
        lasts, title = self.clock
        courses = [ObservableHistory.of(run, names) for run in self.runs]
        now = courses[0].tick * 1.0
        lines = []
        for k, course in enumerate(courses):
            for name in names:
                at, values = course.points(name)
                at, values = self.window((at * self.each[k], values), now)
                colour, dash = COLOURS[names.index(name)], DASH if k else ()
                where = marks(self.histories[k], self.each[k])
                dots = mark_points(where, at, values, lasts)
                label = self.label(name, k)
                lines.append(Line(label, colour, at * lasts, values, dash, marks=dots))
        for run in self.before:
            for name in names:
                at, values = self.window(self.scale_run(run, name), now)
                label = f"{observable_title(name, self.models)}, {run.label}"
                colour, pen = COLOURS[names.index(name)], (DOTS[run.age], THIN, STRENGTHS[run.age])
                dots = mark_points(marks(run.course.history, run.each), at, values, lasts)
                lines.append(Line(label, colour, at * lasts, values, *pen, marks=dots))
        runs = [*zip(("now", "beside"), courses, strict=False)]
        runs += [(run.label, run.course) for run in self.before]
        return Plotted(
            name=f"{self.name(courses[0].tick)}-{'-'.join(names)}",
            caption=self.caption(courses[0].tick),
            titles=(title, self.axis(names, room=np.inf)),
            range=limits(names),
            lines=[line for line in lines if len(line.at)],
            table=lambda: plot_csv(*table(runs, names)),
        )

    def name(self, tick: int) -> str:
        """What files of these runs are called: models, seed and tick."""
        models = "-beside-".join(model.name for model in self.models)
        return f"{models}-seed{self.of[0].seed}-tick{tick}"

    def caption(self, tick: int) -> str:
        """Which run it is, in a line; below, what is not at its default, and what was changed."""
        first, *others = self.of
        dashed = "".join(f"; dashed: {conditions.model.title}" for conditions in others)
        line = f"{first.model.title}, {first.agents} agents, seed {first.seed}, tick {tick}{dashed}"
        own = [history.departures() for history in self.histories]
        more = [
            ", ".join(
                changes if len(own) == 1 else [f"{of.model.name}: {changes[0]}", *changes[1:]]
            )
            for of, changes in zip(self.of, own, strict=True)
            if changes
        ]
        return "\n".join(row for text in (line, *more) for row in textwrap.wrap(text, CAPTION))


def marks(history: ConditionHistory, each: float) -> np.ndarray:
    """The ticks (K,) at which a run was changed, `each` as many of the first flock's; not all."""
    marks = history.marks
    return marks[thin_ticks(marks, MARKS)] * each if len(marks) else marks


def merge_ticks(
    more: np.ndarray, at: np.ndarray, now: list[np.ndarray], old: list[np.ndarray]
) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray]]:
    """Curves of now and of before at ticks `at` (K,), and also at those of `more` in between."""
    more = more[(more >= at[0]) & (more <= at[-1])]
    ticks = np.union1d(at, more)
    if len(ticks) == len(at):
        return at, now, old

    def on_all(curves: list[np.ndarray]) -> list[np.ndarray]:
        return [np.interp(ticks, at, values) for values in curves]

    return ticks, on_all(now), on_all(old)


def values_at_ticks(some: np.ndarray, at: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The values of a curve at some of the ticks `at` (K,), nan at the others."""
    return np.where(np.isin(at, some), values, np.nan)


def dots(colour: str, values: np.ndarray) -> ChartCurve:
    """Marks on a curve, as a curve of dots without a label, which the mouse is told nothing of.

    It is there without any mark, too: a browser makes a chart anew that gets one more curve.
    """
    return ChartCurve(colour, values, dots=True)


def mark_points(some: np.ndarray, at: np.ndarray, values: np.ndarray, lasts: float) -> Points:
    """Times and values (M,) of a curve at some ticks that it has, of which each `lasts` so long."""
    some = some[(some >= at[0]) & (some <= at[-1])] if len(at) else some[:0]
    return some * lasts, np.interp(some, at, values) if len(some) else some


def short_name(name: str) -> str:
    """An observable in the words of its card, if it has one of its own.

    >>> short_name("mean-neighbours"), short_name("connectivity")
    ('neighbours', 'connectivity')
    """
    card = find_observable(name).card
    return (
        card.label if card is not None and isinstance(card.label, str) else observable_words(name)
    )


def limits(names: tuple[str, ...]) -> tuple[float | None, float | None]:
    """The ends of an axis of observables: 0 to 1 for shares, from 0 for counts and lengths."""
    scales = [scale(name) for name in names]
    if all(scale.is_share for scale in scales):
        return SHARE
    return (0.0, None) if all(scale.low == 0.0 for scale in scales) else (None, None)


def axis(names: tuple[str, ...]) -> uplot.Scale:
    """The same as a chart on the page has it."""
    ends = limits(names)
    return uplot.Scale() if ends == (None, None) else uplot.Scale(range=ends)


CHARTS = 3
WINDOWS = {"whole run": math.inf, "last 3000 ticks": 3000.0, "last 500 ticks": 500.0}


class LaboratoryPlots:
    """Some charts, each with the observables that it shows over time.

    A model brings its usual ones; what is chosen stays until another model comes.
    """

    def __init__(
        self, server: viser.ViserServer, runs: KeptRuns, allowed: ExportPermit | None = None
    ):
        gui = server.gui
        self.model: Model | None = None
        self.asked: tuple[Model, tuple[str, ...]] | None = None
        """What a scene shows of a model that is about to come."""
        self.offered: tuple[str, ...] = ()
        self.choices: dict[str, tuple[str, ...]] = choices(())
        self.runs = runs
        self.sender = Sender(allowed)
        self.charts = [ChosenChart(server, number, self.sender) for number in range(1, CHARTS + 1)]
        self.window = gui.add_dropdown(
            "Plots of",
            tuple(WINDOWS),
            hint="How much of the run is plotted. Susceptibility and Binder's cumulant are taken "
            "over it, too",
        )

    @property
    def names(self) -> frozenset[str]:
        """The observables that are plotted."""
        return frozenset(name for chart in self.charts for name in chart.names)

    @property
    def last(self) -> float:
        """How many ticks are plotted, up to now."""
        return WINDOWS[self.window.value]

    @property
    def chosen(self) -> tuple[str, ...]:
        """What is plotted, as the charts call it; empty where it is as usual."""
        usual = () if self.model is None else default_charts(self.model, self.offered)
        now = tuple(chart.choice.value for chart in self.charts)
        return () if now == tuple(map(chart_title, usual)) else now

    def refresh(
        self,
        readings: FlockReadings,
        frame: Frame,
        beside: FlockReadings | None = None,
        is_coming: bool = False,
    ) -> None:
        """Draw the run as far as it has come; dashed, that of the flock beside.

        `is_coming`: whether the run of a scene is yet to come, and what it plots with it.
        """
        beside = None if frame.beside is None else beside
        runs = (readings,) if beside is None else (readings, beside)
        self.runs.follow(runs)
        self.offer(readings, beside, is_coming)
        overlay = Overlay(runs, self.runs, self.last)
        first = True
        for chart in self.charts:
            chart.names = self.choices[chart.choice.value]
            chart.refresh(overlay, changes=first)
            first = first and not chart.names

    def offer(
        self, readings: FlockReadings, beside: FlockReadings | None, is_coming: bool = False
    ) -> None:
        """Let what these flocks have be chosen; of another model, choose the usual, and so where
        a flock has more to tell and nobody has chosen otherwise."""
        others = () if beside is None else beside.offered
        offered = tuple(dict.fromkeys([*readings.offered, *others]))
        is_usual = not self.chosen
        model = readings.flock.model
        if offered != self.offered:
            if is_usual:
                self.model = None
            self.offered, self.choices = offered, choices(offered)
            for chart in self.charts:
                chart.choice.options = tuple(self.choices)
        if model is not self.model:
            self.model = model
            for chart, names in zip(self.charts, default_charts(model, offered), strict=True):
                set_value(chart.choice, chart_title(names))
        if self.asked is not None and self.asked[0] is model and not is_coming:
            for chart, name in zip(self.charts, self.asked[1], strict=False):
                title = observable_words(name)  # files written by hand have the observable's name
                if title in self.choices:
                    self.show_in(chart, title)
            self.asked = None

    def show_in(self, chart: ChosenChart, name: str) -> None:
        """Have a chart show an observable; one that shows it already shows what this one did."""
        for other in self.charts:
            if other is not chart and other.choice.value == name:
                set_value(other.choice, chart.choice.value)
        set_value(chart.choice, name)


class ChosenChart:
    """A chart with the choice of what it shows as its title."""

    def __init__(self, server: viser.ViserServer, number: int, sender: Sender):
        self.names: tuple[str, ...] = ()
        self.title = f"Plot {number}"
        self.choice = server.gui.add_dropdown(
            self.title, (chart_title(()),), hint="What to measure and to plot over the run"
        )
        self.overlay: Overlay | None = None
        self.plot = Plot(server, self.title, self.plot_contents, sender)

    def plot_contents(self) -> Plotted | None:
        """What it shows, to take home; None if that is nothing."""
        if self.overlay is None or not self.names:
            return None
        return self.overlay.plot_contents(self.names)

    def refresh(self, overlay: Overlay, changes: bool) -> None:
        """Draw its observables of all runs; `changes`: say above them what was changed.

        What the values are now is said in the title if there is but one, else in a key.
        """
        lone = len(self.names) == len(overlay.runs) == 1
        first = overlay.runs[0]
        now = format_observable(self.names[0], first.values.get(self.names[0])) if lone else ""
        label = f"{self.title}: {now}" if lone else self.title
        if self.choice.label != label:
            self.choice.label = label
        self.overlay, self.plot.title = overlay, chart_title(self.names)
        content = overlay.chart_contents(self.names, not lone, changes)
        self.plot.show(content, overlay.head(self.names, keyed=True))
