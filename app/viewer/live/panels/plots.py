"""The last minute of a room as curves: times of its loop, lags of its cars, how close they are."""

from __future__ import annotations

import html
from collections.abc import Sequence

import numpy as np
import viser
from viser import uplot

from app.viewer.live.readings import RoomReadings
from app.viewer.measuring.time_series import TimeSeries
from app.viewer.panels.chart import Chart, Curve
from app.viewer.panels.style import BLUE, GREEN, GREY, ORANGE, RED, key
from app.viewer.scene.draw import own, palette

WINDOW = 60.0
"""Seconds that are plotted."""
LIMIT = (True, 1.2)
"""How what stays the same is drawn: dashed, and thin."""
X = uplot.Scale(time=False)
"""Seconds since the room was opened."""


class LivePlots:
    """Three charts over the last minute."""

    def __init__(self, gui: viser.GuiApi, rate: float):
        """`rate` is that of the loop, Hz."""
        self.due = 1000.0 / rate
        self.times, self.lags, self.least = Chart(gui), Chart(gui), Chart(gui)

    def refresh(self, readings: RoomReadings, names: Sequence[str], length: float) -> None:
        """Draw what there is of the cars of these names, which are so long (m)."""
        at, _ = readings.loop.arrays(WINDOW)
        if not len(at):
            return
        level = np.ones(len(at))

        def curve(colour: str, series: TimeSeries) -> Curve:
            return Curve(colour, at_times(at, *series.arrays(WINDOW)))

        show(
            self.times,
            "Loop and latency, ms",
            at,
            {
                "median": curve(BLUE, readings.loop),
                "worst": curve(ORANGE, readings.worst),
                "latency": curve(GREEN, readings.latency),
                "due": Curve(GREY, self.due * level, *LIMIT),
            },
            floor=True,
            most=4.0 * self.due,
        )
        ink, lags = colours(names), readings.lags
        show(
            self.lags,
            "Phase lag behind the injected car, deg",
            at,
            {name: curve(ink[name], lags[name]) for name in names if name in lags},
        )
        show(
            self.least,
            "Least distance of two cars, m",
            at,
            {
                "least": curve(BLUE, readings.least),
                "a car's length": Curve(RED, length * level, *LIMIT),
            },
            floor=True,
        )


def show(
    chart: Chart,
    title: str,
    at: np.ndarray,
    curves: dict[str, Curve],
    floor: bool = False,
    most: float = np.inf,
) -> None:
    """Draw what is known of curves at times `at`, s, under a title and their key.

    The vertical axis begins at 0 if `floor`, and does not go beyond `most`.
    """
    known = {name: one for name, one in curves.items() if np.isfinite(one.values).any()}
    if not known:
        chart.show("", at, (), X, uplot.Scale())
        return
    entries = [(html.escape(name), one.colour) for name, one in known.items()]
    chart.show(
        f'<div class="fs-head">{html.escape(title)}</div>{key(entries)}',
        at,
        list(known.values()),
        X,
        uplot.Scale(range=around([np.minimum(one.values, most) for one in known.values()], floor)),
    )


def at_times(at: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values at some of the times `at` as values at all of them, NaN where there is none.

    >>> at_times(np.array([1.0, 2.0, 3.0]), np.array([2.0, 9.0]), np.array([7.0, 8.0]))
    array([nan,  7., nan])
    """
    found, there = np.full(len(at), np.nan), np.isin(times, at)
    found[np.searchsorted(at, times[there])] = values[there]
    return found


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


def colours(names: Sequence[str]) -> dict[str, str]:
    """The colour of each car's curve: its own, as in the scene, CSS.

    >>> colours(["red", "blue"])["red"]
    '#e30010'
    """
    return {name: palette.css(colour) for name, colour in own.by_name(names).items()}
