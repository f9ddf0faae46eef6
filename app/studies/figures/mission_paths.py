"""Runs of several sizes of flock: trajectories on the map, and x and y over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.charts.mission_scene import (
    GOAL,
    draw_agents,
    draw_links,
    draw_trails,
    draw_world,
    extent,
    show_box,
)
from app.studies.experiment import Experiment
from app.studies.figures.mission import FlownMission, fly_mission

# Two algorithms from the same start: their trajectories side by side, and how they get there.

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
    flights = [fly_mission(experiment, case, seed) for case in experiment.cases]
    low, high = shared_box(flights)
    for letter, case, flight, colour in zip(
        LETTERS, experiment.cases, flights, COLOURS, strict=False
    ):
        axes = panels[letter]
        draw_flight(axes, flight, colour)
        show_box(axes, low, high)
        axes.set_title(f"{case.label}: {describe_arrivals(experiment, flight)}", loc="left")
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


def describe_arrivals(experiment: Experiment, flight: FlownMission) -> str:
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


# Two algorithms from the same start: trajectories, and x and y of their centres over time.

QUIET = 1.25
"""How far time is shown, of the latest time at which a centre settles."""


def draw_centres(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the runs of that seed, one of each row: trajectories above, their centres below."""
    labels = [case.label for case in experiment.cases]
    figure.set_size_inches(10.8, 8.6)
    panels = figure.subplot_mosaic([["a", "b"], ["c", "d"]], height_ratios=[1.9, 1.0])
    flights = draw_flights(panels, experiment, seed)
    end = last_time(experiment, flights)
    for letter in "ab":
        title = panels[letter].get_title(loc="left")
        panels[letter].set_title(f"({letter}) {title}", loc="left")
    for axis, (letter, name) in enumerate((("c", "x"), ("d", "y"))):
        axes = panels[letter]
        for flight, label, colour in zip(flights, labels, COLOURS, strict=False):
            time, centre = centre_of(flight)
            axes.plot(
                time,
                centre[:, axis],
                color=colour,
                linewidth=1.9,
                label=row_label(experiment, flight, label),
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


def row_label(experiment: Experiment, flight: FlownMission, label: str) -> str:
    """A row's name with the time at which its centre settles."""
    settled = flight.record.settled(experiment.settings.within)  # type: ignore[attr-defined]
    return f"{label}: " + ("never settles" if settled is None else f"settles at {settled:.0f} s")


def last_time(experiment: Experiment, flights: list[FlownMission]) -> float:
    """The time until which curves are drawn, s: a little longer than until all have settled."""
    near = experiment.settings.within  # type: ignore[attr-defined]
    ends = [flight.record.ticks * flight.record.dt for flight in flights]
    settled = [flight.record.settled(near) for flight in flights]
    times = [time for time in settled if time is not None]
    return (
        min(max(ends), QUIET * max(times))
        if len(times) == len(flights) and max(times)
        else max(ends)
    )


COLOUR = "#2166ac"
SHOWN = 120.0
"""Time that is shown, s: after it hardly anything moves."""


def draw_trajectories(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the runs of that seed, one of each row."""
    flights = [fly_mission(experiment, case, seed) for case in experiment.cases]
    figure.set_size_inches(5.6 * len(flights) + 0.4, 8.4)
    panels = figure.subplots(3, len(flights), squeeze=False, height_ratios=[2.0, 1, 1])
    low, high = shared_box(flights)
    for column, case, flight in zip(panels.T, experiment.cases, flights, strict=True):
        draw_flight(column[0], flight, COLOUR)
        show_box(column[0], low, high)
        column[0].set_title(
            f"N = {case.agents}: {describe_arrivals(experiment, flight)}", loc="left"
        )
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


PICTURES = {"duel": draw_duel, "centres": draw_centres, "trajectories": draw_trajectories}
