"""Two algorithms from the same start: their trajectories side by side, and how they get there."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.pictures.missions.flown_mission import FlownMission, flown
from app.studies.pictures.missions.mission_scene import (
    draw_agents,
    draw_links,
    draw_trails,
    draw_world,
    extent,
    show_box,
)

COLOURS = ("#b07d12", "#2166ac")
LETTERS = "abcdefgh"


def draw_duel(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the runs of that seed, one of each row."""
    labels = [case.label for case in experiment.cases]
    rows = len(labels)
    figure.set_size_inches(5.0 * rows + 0.4, 7.8)
    panels = figure.subplot_mosaic([list(LETTERS[:rows]), ["time"] * rows], height_ratios=[2.1, 1])
    draw_times(panels["time"], experiment, draw_flights(panels, experiment, seed), labels)


def draw_flights(panels: dict[str, Any], experiment: Experiment, seed: int) -> list[FlownMission]:
    """Draw the trajectories of the runs of that seed into the panels "a", "b" and so on."""
    flights = [flown(experiment, case, seed) for case in experiment.cases]
    low, high = shared_box(flights)
    for letter, case, flight, colour in zip(
        LETTERS, experiment.cases, flights, COLOURS, strict=False
    ):
        axes = panels[letter]
        draw_flight(axes, flight, colour)
        show_box(axes, low, high)
        axes.set_title(f"{case.label}: {through(experiment, flight)}", loc="left")
        axes.set_xlabel("x / m")
    panels["a"].set_ylabel("y / m")
    return flights


def shared_box(flights: list[FlownMission]) -> tuple[np.ndarray, np.ndarray]:
    """The part of the plane that holds all trajectories, obstacles and the goal."""
    boxes = [extent(flight.flock.world, flight.record.position, 2.0) for flight in flights]
    lows, highs = zip(*boxes, strict=True)
    return np.min(lows, axis=0), np.max(highs, axis=0)


def draw_flight(axes: Any, flight: FlownMission, colour: str) -> None:
    """Draw a run: trajectories, and the agents with their links at the end."""
    flock = flight.flock
    draw_world(axes, flock.world)
    draw_trails(axes, flight.record.position, [colour] * len(flock.ids))
    draw_links(axes, flock.position, flock.links())
    draw_agents(axes, flock.position, ["#c0392b"] * len(flock.ids), 16.0)


def through(experiment: Experiment, flight: FlownMission) -> str:
    """How many agents came to the goal, in words."""
    n = len(flight.flock.ids)
    share = flight.record.through(experiment.settings.spacing)  # type: ignore[attr-defined]
    return f"{round(share * n)} of {n} through"


def draw_times(
    axes: Any, experiment: Experiment, flights: list[FlownMission], labels: list[str]
) -> None:
    """Draw the distance of the flock's centre to the goal over time, with the settling times."""
    near = experiment.settings.within  # type: ignore[attr-defined]
    for flight, label, colour in zip(flights, labels, COLOURS, strict=False):
        centre, dt = flight.record.centre, flight.record.dt
        step = max(1, len(centre) // 1500)
        time = dt * np.arange(len(centre))
        settled = flight.record.settled(near)
        words = "never settles" if settled is None else f"settles at {settled:.0f} s"
        axes.plot(
            time[::step], centre[::step], color=colour, linewidth=1.8, label=f"{label}: {words}"
        )
        if settled is not None:
            axes.plot([settled], [near], "o", color=colour, markeredgecolor="white", zorder=5)
    axes.axhline(near, color="#7a828c", linewidth=1.0, linestyle=(0, (4, 3)))
    axes.set_xlim(0, max(f.record.ticks * f.record.dt for f in flights))
    axes.set_ylim(bottom=0)
    axes.set_xlabel("time / s")
    axes.set_ylabel("centre to goal / m")
    axes.legend(loc="upper right")
