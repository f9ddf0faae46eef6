"""The mission of a world on its plan: start region, path of the information agents, goal."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from app.worlds.colours import GOAL, PATH, START
from worlds.mission import Goal, Mission, StartRegion
from worlds.mission import Path as MissionPath
from worlds.world import World

AGENTS = 100
"""Flock for which a start region of given density is drawn."""
NUMBERED = 12
"""Most waypoints that are numbered."""


def draw_mission(axes: Any, world: World, plane: tuple[int, int] = (0, 1)) -> list[Any]:
    """Draw the mission, if there is one, as seen on two of the axes; returns signs to explain."""
    mission: Mission | None = world.mission
    seen = list(plane)
    signs: list[Any] = []
    if mission and mission.start:
        signs.append(draw_start(axes, mission.start, world.dim, seen))
    if mission and mission.path:
        signs.append(draw_path(axes, mission.path, seen))
    if mission and mission.goal:
        signs.append(draw_goal(axes, mission.goal, mission.settle, seen))
    return signs


def start_box(start: StartRegion, dim: int) -> tuple[np.ndarray, np.ndarray]:
    """The corners of the start region, for AGENTS agents where it depends on their number."""
    low = np.array(start.low)
    if start.high is not None:
        return low, np.array(start.high)
    return low, low + (AGENTS / (start.density or 1.0)) ** (1.0 / dim)


def reaches(world: World) -> list[np.ndarray]:
    """Places of the mission that a plan has to show."""
    mission = world.mission
    found: list[np.ndarray] = []
    if mission and mission.start:
        found += [corner[:2] for corner in start_box(mission.start, world.dim)]
    if mission and mission.path:
        found += [np.array(point[:2]) for point in mission.path.waypoints]
    if mission and mission.goal:
        found += [np.array(point[:2]) for point in mission.goal.route]
    return found


def draw_start(axes: Any, start: StartRegion, dim: int, seen: list[int]) -> Any:
    """The start region."""
    from matplotlib.patches import Patch, Rectangle

    low, high = start_box(start, dim)
    axes.add_patch(
        Rectangle(tuple(low[seen]), *(high - low)[seen], facecolor=START + "30", edgecolor=START,
                  linewidth=1.2, zorder=3)
    )  # fmt: skip
    of = f" of {AGENTS} agents" if start.high is None else ""
    return Patch(facecolor=START + "30", edgecolor=START, label=f"start{of}")


def draw_path(axes: Any, path: MissionPath, seen: list[int]) -> Any:
    """Waypoints, joined by a line, with the circles within which the next one is taken."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Circle

    points = np.array(path.waypoints)[:, seen]
    line = np.vstack([points, points[:1]]) if path.closed else points
    axes.plot(*line.T, color=PATH, linewidth=1.4, linestyle=(0, (6, 2.5)), zorder=5)
    many = len(points) > NUMBERED
    for number, point in enumerate(points, start=1):
        axes.add_patch(Circle(tuple(point), path.switch, facecolor=PATH + "22", zorder=4))
        axes.plot(*point, "o", color=PATH, markersize=4 if many else 11, zorder=6)
        if not many:
            axes.annotate(
                str(number), point, color="white", fontsize=7.5, weight="bold",
                ha="center", va="center_baseline", zorder=7,
            )  # fmt: skip
    return Line2D([], [], color=PATH, marker="o", markersize=6, linestyle=(0, (4, 2)),
                  label="path of the information agents")  # fmt: skip


def draw_goal(axes: Any, goal: Goal, settle: float, seen: list[int]) -> Any:
    """The goal's route and, where it begins, a star with the circle within which it is reached."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Circle

    points = np.array(goal.route)[:, seen]
    if len(points) > 1:
        line = np.vstack([points, points[:1]]) if goal.closed else points
        axes.plot(*line.T, color=GOAL, linewidth=1.3, linestyle=(0, (1, 1.5)), zorder=5)
        for begin, end in pairwise(line):
            axes.annotate(
                "", 0.56 * end + 0.44 * begin, 0.5 * (begin + end), zorder=5,
                arrowprops={"arrowstyle": "-|>", "color": GOAL, "shrinkA": 0, "shrinkB": 0},
            )  # fmt: skip
    first = tuple(points[0])
    axes.add_patch(Circle(first, settle, facecolor=GOAL + "1c", edgecolor=GOAL, linewidth=0.7,
                          zorder=4))  # fmt: skip
    axes.plot(*first, "*", color=GOAL, markersize=14, markeredgecolor="white",
              markeredgewidth=0.8, zorder=7)  # fmt: skip
    label = "goal" if goal.speed == 0.0 or len(points) == 1 else f"goal, {goal.speed:g} m/s"
    return Line2D([], [], color=GOAL, marker="*", markersize=11, linestyle="none", label=label)
