"""Cars behind an injected one: their ways in space and time, time upwards, and how all runs end."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Case, Experiment
from app.studies.kinds.driving import DrivingSettings
from app.studies.pictures.boxes import explain
from app.studies.trial import flock_of
from app.studies.verdicts.verdict import Verdict, of

CARS = ("#2166ac", "#1f9d63", "#c0392b", "#8e44ad", "#0b2545", "#5aa9c9", "#7a828c", "#8c510a")
INJECTED, HUNTER = "#e3b505", "#101418"
"""The injected car is yellow, as in the paper."""
TOUCH = "#d6403a"
WAYS = 3
"""Rows whose run is drawn in space and time, the first ones."""
SHOWN = 1500
"""Points of a way, about."""
BARS = {
    "ok": "#1f9d63",
    "locked": "#2166ac",
    "collision": "#c0392b",
    "stuck": "#b07d12",
    "outside": "#8e44ad",
    "caught": "#101418",
}


def draw_driving(figure: Any, experiment: Experiment, made: list[Verdict], seed: int) -> None:
    """Draw the run of that seed of the first rows above, the share of runs of all rows below."""
    settings = experiment.settings
    assert isinstance(settings, DrivingSettings)
    cases = experiment.cases[:WAYS]
    figure.set_size_inches(4.4 * max(2, len(cases)), 9.0)
    above, below = figure.subfigures(2, 1, height_ratios=[1.5, 1.0])
    panels = above.subplots(1, len(cases), subplot_kw={"projection": "3d"}, squeeze=False)[0]
    for axes, case in zip(panels, cases, strict=True):
        draw_ways(axes, case, settings, seed)
    shares, lags = below.subplots(1, 2, width_ratios=[2.2, 1.0])
    signs = draw_shares(shares, made)
    draw_lags(lags, of(made, "lag"))
    explain(
        figure,
        signs,
        f"above: a run of each of the first rows, seed {seed}, time upwards, the injected car "
        "yellow, a predator black, a red dot where cars touch; below: all runs",
    )


def draw_ways(axes: Any, case: Case, settings: DrivingSettings, seed: int) -> None:
    """Draw one run in space and time."""
    flock = flock_of(case, seed)
    drive = settings.driven(flock)
    step = max(1, len(drive.position) // SHOWN)
    ticks = np.arange(0, len(drive.position), step)
    time = flock.dt * ticks
    goal = flock.goal_at(ticks)
    if getattr(flock.parameters, "c_goal", 1.0) > 0.0:
        axes.plot(goal[:, 0], goal[:, 1], time, color=INJECTED, linewidth=2.2)
    for row in range(drive.position.shape[1]):
        way = drive.position[ticks, row]
        colour = HUNTER if drive.hunts[row] else CARS[row % len(CARS)]
        axes.plot(way[:, 0], way[:, 1], time, color=colour, linewidth=1.1)
    for tick, row in drive.touched:
        x, y = drive.position[tick, row]
        axes.plot([x], [y], [flock.dt * tick], "o", color=TOUCH, markersize=4)
    low, size = np.array(flock.world.low), np.array(flock.world.size)
    axes.set_xlim(low[0], low[0] + size[0])
    axes.set_ylim(low[1], low[1] + size[1])
    axes.set_zlim(0.0, time[-1])
    axes.set_box_aspect((size[0], size[1], 1.25 * size.max()))
    axes.set_xlabel("x / m")
    axes.set_ylabel("y / m")
    axes.set_zlabel("time / s")
    axes.set_title(f"{case.label}, N = {case.agents}", loc="left")


def draw_shares(axes: Any, made: list[Verdict]) -> list[Any]:
    """Draw the share of runs of each row that end well and of each fault; what is what."""
    from matplotlib.patches import Patch

    there = [name for name in BARS if any(one.summary.runs for one in of(made, name))]
    width = 0.8 / max(1, len(there))
    for k, name in enumerate(there):
        points = of(made, name)
        axes.bar(
            [x + (k - 0.5 * (len(there) - 1)) * width for x in range(len(points))],
            [one.summary.mean if one.summary.runs else 0.0 for one in points],
            width,
            color=BARS[name],
        )
    rows = of(made, made[0].measure.name)
    labels = [f"{one.case.label}, N = {one.case.agents}".replace(", ", "\n") for one in rows]
    axes.set_xticks(range(len(rows)), labels, fontsize=8)
    axes.tick_params(axis="x", length=0)
    axes.set_ylim(0.0, 103.0)
    axes.set_ylabel("runs / %")
    return [Patch(facecolor=BARS[name], label=name) for name in there]


def draw_lags(axes: Any, points: list[Verdict]) -> None:
    """Draw the lags of the runs that end locked, a dot for each."""
    for x, one in enumerate(points):
        values = [value for value in one.values if value is not None]
        aside = np.random.default_rng(0).uniform(-0.25, 0.25, len(values))
        axes.plot(x + aside, values, ".", color=BARS["locked"], markersize=4, alpha=0.5)
    axes.set_xticks(range(len(points)), [one.case.label for one in points], rotation=40, fontsize=8)
    axes.set_xlim(-0.6, len(points) - 0.4)
    most = max((value for one in points for value in one.values if value is not None), default=0.0)
    axes.set_ylim(0.0, 90.0 if most < 90.0 else 180.0)
    axes.set_ylabel("lag / deg")
