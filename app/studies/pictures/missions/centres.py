"""Two algorithms from the same start: trajectories, and x and y of their centres over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.experiment import Experiment
from app.studies.pictures.missions.duel import COLOURS, draw_flights
from app.studies.pictures.missions.flown_mission import FlownMission
from app.studies.pictures.missions.mission_scene import GOAL

QUIET = 1.25
"""How far time is shown, of the latest time at which a centre settles."""


def draw_centres(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the runs of that seed, one of each row: trajectories above, their centres below."""
    labels = [case.label for case in experiment.cases]
    figure.set_size_inches(10.8, 8.6)
    panels = figure.subplot_mosaic([["a", "b"], ["c", "d"]], height_ratios=[1.9, 1.0])
    flights = draw_flights(panels, experiment, seed)
    end = shown(experiment, flights)
    for letter in "ab":
        said = panels[letter].get_title(loc="left")
        panels[letter].set_title(f"({letter}) {said}", loc="left")
    for axis, (letter, name) in enumerate((("c", "x"), ("d", "y"))):
        axes = panels[letter]
        for flight, label, colour in zip(flights, labels, COLOURS, strict=False):
            time, centre = centre_of(flight)
            axes.plot(
                time,
                centre[:, axis],
                color=colour,
                linewidth=1.9,
                label=worded(experiment, flight, label),
            )
        goal = flights[0].flock.goal_at([0])[0, axis]
        axes.axhline(goal, color=GOAL, linewidth=1.4, linestyle=(0, (4, 3)), label="goal")
        axes.set_xlim(0.0, end)
        axes.set_title(f"({letter}) {name} of the centre", loc="left")
        axes.set_xlabel("time / s")
        axes.set_ylabel(f"{name} / m")
    handles, words = panels["c"].get_legend_handles_labels()
    figure.legend(handles, words, loc="outside lower left", ncols=len(words), fontsize=9)


def centre_of(flight: FlownMission) -> tuple[np.ndarray, np.ndarray]:
    """Time (K,), s, and the centre of the agents (K, dim), m, at the kept ticks."""
    record = flight.record
    time = record.dt * record.every * np.arange(len(record.position))
    return time, record.position.mean(axis=1)


def worded(experiment: Experiment, flight: FlownMission, label: str) -> str:
    """A row's name with the time at which its centre settles."""
    settled = flight.record.settled(experiment.settings.within)  # type: ignore[attr-defined]
    return f"{label}: " + ("never settles" if settled is None else f"settles at {settled:.0f} s")


def shown(experiment: Experiment, flights: list[FlownMission]) -> float:
    """The time until which curves are drawn, s: a little longer than until all have settled."""
    near = experiment.settings.within  # type: ignore[attr-defined]
    ends = [flight.record.ticks * flight.record.dt for flight in flights]
    settled = [flight.record.settled(near) for flight in flights]
    there = [time for time in settled if time is not None]
    return (
        min(max(ends), QUIET * max(there))
        if len(there) == len(flights) and max(there)
        else max(ends)
    )
