"""A whole mission of one run: the scene with every trajectory, and two details of it."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.pictures.missions.flown_mission import FlownMission, flown
from app.studies.pictures.missions.mission_scene import (
    AGENT,
    INFORMED,
    LOST,
    PATH,
    draw_agents,
    draw_trails,
    draw_world,
    extent,
    show_box,
)
from worlds.queries.surface import clearance

SETUP = np.array([8.0, 4.6])
DETAIL = np.array([2.4, 1.38])
"""Half the sides of the details, length."""
NEAR = "#1d5fd1"
PASSAGE = "#c0392b"


def draw_mission(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the first row's run of that seed."""
    case = experiment.cases[0]
    flight = flown(experiment, case, seed)
    figure.set_size_inches(12.4, 8.2)
    panels = figure.subplot_mosaic([["all", "all"], ["setup", "detail"]], height_ratios=[1.12, 1.0])
    whole, setup, detail = panels["all"], panels["setup"], panels["detail"]
    for axes in panels.values():
        draw_world(axes, flight.flock.world)
        draw_trails(axes, flight.record.position, colours(flight))
        leaders = flight.record.position[:, flight.record.informed]
        draw_trails(axes, leaders, [INFORMED] * leaders.shape[1], 2.0, 1.0)
        draw_agents(axes, flight.record.position[0], colours(flight), 5.0)
    draw_agents(whole, flight.record.position[-1], colours(flight), 10.0)
    kept = flight.record
    show_box(whole, *extent(flight.flock.world, kept.position[:, kept.follows], 1.0))
    whole.set_title(
        f"{case.label}, N = {case.agents}, seed {seed}: {kept.success:.0%} follow to the end, "
        f"{kept.ticks} ticks",
        loc="left",
    )
    low, high = busiest(flight)
    show_box(setup, low, high)
    mark(whole, low, high, PASSAGE)
    frame(setup, PASSAGE, "the obstacles")
    row, place = closest(flight)
    show_box(detail, place - DETAIL, place + DETAIL)
    mark(whole, place - DETAIL, place + DETAIL, NEAR)
    frame(detail, NEAR, "an agent avoids an obstacle")
    detail.plot(*kept.position[:, row, :2].T, "-", color=NEAR, linewidth=2.0, zorder=4)
    detail.plot(*kept.position[:, row, :2].T, ".", color=NEAR, markersize=5, zorder=4.1)
    signs(figure)


def colours(flight: FlownMission) -> list[str]:
    """A colour for each agent: informed, following or lost."""
    record = flight.record
    return [
        INFORMED if informed else AGENT if follows else LOST
        for informed, follows in zip(record.informed, record.follows, strict=True)
    ]


def busiest(flight: FlownMission) -> tuple[np.ndarray, np.ndarray]:
    """The corners of a box that holds the largest number of obstacles close to each other."""
    bounds = np.array([one.footprint().bounds for one in flight.flock.world.obstacles])
    centre = (bounds[:, :2] + bounds[:, 2:]) / 2.0
    inside = [(np.abs(centre - one) <= SETUP).all(axis=1) for one in centre]
    most = max(inside, key=np.count_nonzero)
    middle = (bounds[most, :2].min(axis=0) + bounds[most, 2:].max(axis=0)) / 2.0
    return middle - SETUP, middle + SETUP


def closest(flight: FlownMission) -> tuple[int, np.ndarray]:
    """The agent that followed and came closest to an obstacle, and where (2,)."""
    record = flight.record
    ordinary = record.follows & ~record.informed
    rows = np.flatnonzero(ordinary if ordinary.any() else record.follows)
    row = int(rows[record.clearance[rows].argmin()])
    track = record.position[:, row]
    return row, track[clearance(flight.flock.world, track).argmin(), :2]


def mark(axes: Any, low: np.ndarray, high: np.ndarray, colour: str) -> None:
    """Draw the frame of a detail."""
    from matplotlib.patches import Rectangle

    axes.add_patch(
        Rectangle((low[0], low[1]), *(high - low), fill=False, edgecolor=colour, linewidth=1.2,
                  linestyle=(0, (2, 1.5)), zorder=7)
    )  # fmt: skip


def frame(axes: Any, colour: str, words: str) -> None:
    """Make the axes the frame of a detail."""
    for spine in axes.spines.values():
        spine.set(visible=True, edgecolor=colour, linewidth=1.2, linestyle=(0, (2, 1.5)))
    axes.set_title(words, loc="left", color=colour)


def signs(figure: Any) -> None:
    """Say what is what."""
    from matplotlib.lines import Line2D

    lines = {"information UAV": INFORMED, "follows to the end": AGENT, "lost the flock": LOST}
    handles = [Line2D([], [], color=colour, linewidth=2, label=k) for k, colour in lines.items()]
    way = Line2D(
        [], [], color=PATH, marker="o", markersize=3.5, linestyle=(0, (5, 4)), label="path"
    )
    figure.legend(handles=[*handles, way], loc="outside lower left", ncols=4, fontsize=9)
