"""Runs of several sizes of flock: trajectories on the map, and x and y over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.pictures.missions.duel import draw_flight, shared_box, through
from app.studies.pictures.missions.flown_mission import FlownMission, flown
from app.studies.pictures.missions.mission_scene import show_box

COLOUR = "#2166ac"
SHOWN = 120.0
"""Time that is shown, s: after it hardly anything moves."""


def draw_trajectories(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the runs of that seed, one of each row."""
    flights = [flown(experiment, case, seed) for case in experiment.cases]
    figure.set_size_inches(5.6 * len(flights) + 0.4, 8.4)
    panels = figure.subplots(3, len(flights), squeeze=False, height_ratios=[2.0, 1, 1])
    low, high = shared_box(flights)
    for column, case, flight in zip(panels.T, experiment.cases, flights, strict=True):
        draw_flight(column[0], flight, COLOUR)
        show_box(column[0], low, high)
        column[0].set_title(f"N = {case.agents}: {through(experiment, flight)}", loc="left")
        for axis, name in enumerate("xy"):
            draw_over_time(column[1 + axis], flight, axis, name)
        column[2].set_xlabel("time / s")


def draw_over_time(axes: Any, flight: FlownMission, axis: int, name: str) -> None:
    """Draw one coordinate of all agents over time."""
    record = flight.record
    time = record.dt * record.every * np.arange(len(record.position))
    axes.plot(time, record.position[:, :, axis], color=COLOUR, linewidth=0.6, alpha=0.45)
    goal = flight.flock.goal_at([0])[0, axis]
    axes.axhline(goal, color="#1f9d63", linewidth=1.2, linestyle=(0, (4, 3)), label="goal")
    axes.set_xlim(0, min(time[-1], SHOWN))
    axes.set_ylabel(f"{name} / m")
