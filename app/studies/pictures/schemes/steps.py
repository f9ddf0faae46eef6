"""A flock at several ticks, each agent in the colour of what it goes by; and how it moves."""

from __future__ import annotations

from typing import Any

import numpy as np

from agents.observables.order import polarisation
from app.studies.experiment import Experiment
from app.studies.kinds.branching import BranchingSettings, push_on
from app.studies.kinds.zoning import around_of, branch_of
from app.studies.pictures.boxes import explain
from app.studies.pictures.missions.mission_scene import draw_obstacles
from app.studies.pictures.schemes.scheme_marks import (
    FAINT,
    INK,
    ZONE_COLOURS,
    arrow,
    bare,
    dart,
    sign,
    stroke,
)
from app.studies.trial import flock_of

BLOCK = "#c0392b"
COLOURS = (FAINT, ZONE_COLOURS[0], ZONE_COLOURS[1], ZONE_COLOURS[2], "#7b5ea7")
WORDS = ("notices nobody", "(3.9) away", "(3.10) aligns", "(3.11) goes there", "(3.12) both")
SHOWN = 4


def draw_steps(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the first row's flock of that seed at four ticks, the last at the experiment's end."""
    settings = experiment.settings
    assert isinstance(settings, BranchingSettings)
    case = experiment.cases[0]
    flock = settings.prepared(flock_of(case, seed))
    ticks = [0, *(round(settings.limit * share) for share in (0.1, 0.4, 1.0))]
    figure.set_size_inches(11.0, 11.0)
    for axes, tick, letter in zip(figure.subplots(2, 2).ravel(), ticks, "abcd", strict=True):
        flock.run(tick - flock.tick)
        pushes = draw_flock(axes, flock)
        p = polarisation(flock.heading[flock.active])
        seen = f", {pushes} pushed by an obstacle" if flock.world.is_solid else ""
        axes.set_title(f"({letter}) tick {tick}: polarisation {p:.2f}{seen}", loc="left")
    found = [sign(colour, words, ">") for colour, words in zip(COLOURS, WORDS, strict=True)]
    if flock.world.is_solid:
        found.append(stroke(BLOCK, "push of obstacles"))
    explain(
        figure,
        found,
        f"a run of {case.label}, N = {case.agents}, seed {seed}; the thesis draws a scheme",
    )


def draw_flock(axes: Any, flock: Any) -> int:
    """Draw a flock in its box; how many are pushed by an obstacle."""
    low, size = np.array(flock.world.low), np.array(flock.world.size)
    draw_obstacles(axes, flock.world)
    axes.add_patch(frame(low, size))
    place = np.where(flock.world.wraps, low + (flock.position - low) % size, flock.position)
    pushed = 0
    for row in np.flatnonzero(flock.active):
        branch = branch_of(around_of(flock, int(row)).zone)
        dart(axes, place[row], flock.heading[row], COLOURS[branch], 0.042 * size[0])
        force = push_on(flock, int(row))
        if force.any():
            pushed += 1
            length = 0.03 + 0.05 * np.tanh(float(np.linalg.norm(force)))
            arrow(axes, place[row], length * size[0] * force / np.linalg.norm(force), BLOCK, 1.3)
    bare(axes, low + 0.5 * size, 0.52 * float(size.max()))
    return pushed


def frame(low: np.ndarray, size: np.ndarray) -> Any:
    """The box."""
    from matplotlib.patches import Rectangle

    return Rectangle(tuple(low), *size, fill=False, edgecolor="#aab2bd", linewidth=1.0)


def draw_motion(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw how the agents move at the start and at the end: arrows as long as they are fast."""
    settings = experiment.settings
    assert isinstance(settings, BranchingSettings)
    case = experiment.cases[0]
    flock = settings.prepared(flock_of(case, seed))
    figure.set_size_inches(11.6, 6.3)
    for axes, tick, letter in zip(figure.subplots(1, 2), (0, settings.limit), "ab", strict=True):
        flock.run(tick - flock.tick)
        low, size = np.array(flock.world.low), np.array(flock.world.size)
        place = np.where(flock.world.wraps, low + (flock.position - low) % size, flock.position)
        axes.add_patch(frame(low, size))
        for at, heading, speed in zip(place, flock.heading, flock.speed, strict=True):
            arrow(axes, at, 0.035 * size[0] * speed * heading, ZONE_COLOURS[2], 1.5, 5.0)
        axes.plot(*place.T, "o", markersize=8, markerfacecolor="white", markeredgecolor=INK,
                  linestyle="none", zorder=6)  # fmt: skip
        bare(axes, low + 0.5 * size, 0.52 * float(size.max()))
        axes.set_title(
            f"({letter}) tick {tick}: speeds {flock.speed.min():.1f} to {flock.speed.max():.1f}, "
            f"polarisation {polarisation(flock.heading):.2f}", loc="left",
        )  # fmt: skip
    explain(
        figure, [sign(INK, "agent", "o", hollow=True), stroke(ZONE_COLOURS[2], "its velocity")],
        f"a run of {case.label}, N = {case.agents}, seed {seed}; an arrow is as long as the agent "
        "is fast",
    )  # fmt: skip
