"""The last minute of a room as curves: times of its loop, lags of its cars, how close they are."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import viser
from viser import uplot

from app.viewer.live.room_frame import RoomReadings
from app.viewer.measuring.time_series import TimeSeries
from app.viewer.panels.chart import (
    DASH,
    NOTHING,
    ChartContents,
    ChartCurve,
    Line,
    Plot,
    Plotted,
    plot_csv,
)
from app.viewer.panels.sending import Sender
from app.viewer.panels.shell import BLUE, GREEN, GREY, ORANGE, RED, key
from app.viewer.scene.shown import palette

WINDOW = 60.0
"""Seconds that are plotted."""


class LivePlots:
    """Three charts over the last minute."""

    def __init__(self, server: viser.ViserServer, rate: float, room: str = ""):
        """`rate` is that of the loop, Hz; `room` what the room is called."""
        self.due = 1000.0 / rate
        sender = Sender()
        self.times = LivePlot(server, "Loop and latency", "ms", room, sender)
        self.lags = LivePlot(server, "Phase lag behind the injected car", "deg", room, sender)
        self.least = LivePlot(server, "Least distance of two cars", "m", room, sender)

    def refresh(self, readings: RoomReadings, names: Sequence[str], length: float) -> None:
        """Draw what there is of the cars of these names, which are so long (m)."""
        ink, lags = colours(names), readings.lags
        self.times.refresh(
            readings.loop,
            {
                "median": LiveCurve(BLUE, readings.loop),
                "worst": LiveCurve(ORANGE, readings.worst),
                "latency": LiveCurve(GREEN, readings.latency),
                "due": LiveCurve(GREY, self.due),
            },
            floor=True,
            most=4.0 * self.due,
        )
        self.lags.refresh(
            readings.loop,
            {name: LiveCurve(ink[name], lags[name]) for name in names if name in lags},
        )
        self.least.refresh(
            readings.loop,
            {
                "least": LiveCurve(BLUE, readings.least),
                "a car's length": LiveCurve(RED, length),
            },
            floor=True,
        )


class LiveCurve(NamedTuple):
    """What is plotted of a room."""

    colour: str
    course: TimeSeries | float
    """How it goes, or what it is all the time."""

    @property
    def pen(self) -> tuple[tuple[float, ...], float]:
        """Dash and width: what stays the same is dashed, and thin."""
        return ((), 2.0) if isinstance(self.course, TimeSeries) else (DASH, 1.2)

    def values_at(self, times: np.ndarray) -> np.ndarray:
        """Its values at some times (K,), s; NaN where there is none."""
        if isinstance(self.course, TimeSeries):
            return values_at_times(times, *self.course.recorded())
        return np.full(len(times), self.course)


class LivePlot:
    """One chart of a room, with its title and the key to its curves."""

    def __init__(self, server: viser.ViserServer, title: str, unit: str, room: str, sender: Sender):
        self.title, self.unit, self.room = title, unit, room
        self.clock = TimeSeries(gaps=True)
        """Whose times those of the plot are."""
        self.known: dict[str, LiveCurve] = {}
        self.ends: tuple[float, float] = (0.0, 1.0)
        self.plot = Plot(server, title, self.plot_contents, sender, "Plot as")

    @property
    def titles(self) -> tuple[str, str]:
        """Of the axes."""
        return "time (s)", self.unit

    def refresh(
        self,
        clock: TimeSeries,
        curves: dict[str, LiveCurve],
        floor: bool = False,
        most: float = np.inf,
    ) -> None:
        """Draw what is known of curves over the last minute of a clock, under title and key.

        The vertical axis begins at 0 if `floor`, and does not go beyond `most`.
        """
        at, _ = clock.arrays(WINDOW)
        values = {name: curve.values_at(at) for name, curve in curves.items()}
        finite = {name: value for name, value in values.items() if np.isfinite(value).any()}
        self.clock, self.known = clock, {name: curves[name] for name in finite}
        if not finite:
            self.plot.show(NOTHING)
            return
        self.ends = round_limits([np.minimum(value, most) for value in finite.values()], floor)
        entries = [(html.escape(name), curves[name].colour) for name in finite]
        chart_curves = tuple(
            ChartCurve(curves[name].colour, value, f"{name} ({self.unit})", *curves[name].pen)
            for name, value in finite.items()
        )
        title = f'<h2 class="fs-head">{html.escape(self.title)}, {self.unit}</h2>'
        y = uplot.Scale(range=self.ends)
        self.plot.show(
            ChartContents(title + key(entries), at, chart_curves, self.titles, y), key(entries)
        )

    def plot_contents(self) -> Plotted | None:
        """What it shows, to take home: the picture of the last minute, the table of all."""
        at, _ = self.clock.arrays(WINDOW)
        if not self.known or not len(at):
            return None
        return Plotted(
            name=f"{self.room or 'room'}-{self.title}-{at[-1]:.0f}s",
            caption=f"{self.title}{f', {self.room}' if self.room else ''}",
            titles=self.titles,
            range=self.ends,
            lines=[
                Line(name, curve.colour, at, curve.values_at(at), *curve.pen)
                for name, curve in self.known.items()
            ],
            table=self.table,
        )

    def table(self) -> str:
        """All that is kept of its curves, as CSV."""
        at, _ = self.clock.recorded()
        columns = np.transpose([at, *(curve.values_at(at) for curve in self.known.values())])
        header = [self.titles[0], *(f"{name} ({self.unit})" for name in self.known)]
        return plot_csv(header, columns.tolist())


def values_at_times(at: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values at some of the times `at` as values at all of them, NaN where there is none.

    >>> values_at_times(np.array([1.0, 2.0, 3.0]), np.array([2.0, 9.0]), np.array([7.0, 8.0]))
    array([nan,  7., nan])
    """
    result, is_there = np.full(len(at), np.nan), np.isin(times, at)
    result[np.searchsorted(at, times[is_there])] = values[is_there]
    return result


def round_limits(curves: Sequence[np.ndarray], floor: bool) -> tuple[float, float]:
    """Round numbers below and above all known values, from 0 if `floor`; they seldom change.

    >>> round_limits([np.array([10.1, np.nan]), np.array([14.3])], floor=True)
    (0.0, 15.0)
    >>> round_limits([np.array([-52.0, 34.0])], floor=False)
    (-75.0, 50.0)
    """
    finite = np.concatenate([values[np.isfinite(values)] for values in curves])
    low, high = min(0.0, finite.min()) if floor else finite.min(), finite.max()
    span = max(high - low, 1e-3)
    decade = 10.0 ** np.floor(np.log10(span))
    step = decade * (0.5 if span < 2.5 * decade else 1.0 if span < 5.0 * decade else 2.5)
    return float(step * np.floor(low / step)), float(step * (np.floor(high / step) + 1.0))


def colours(names: Sequence[str]) -> dict[str, str]:
    """The colour of each car's curve: its own, as in the scene, CSS.

    >>> colours(["red", "blue"])["red"]
    '#e30010'
    """
    return {name: palette.css(colour) for name, colour in palette.car_colours(names).items()}
