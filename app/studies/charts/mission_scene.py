"""A world and what moves in it, drawn from above: obstacles, path, goal, trajectories."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

GROUND = "#fbfcfd"
SOLID, SOLID_EDGE = "#c3ccd6", "#5d6875"
PATH = "#8a93a0"
AGENT = "#2166ac"
LOST = "#9aa3ad"
INFORMED = "#d6403a"
GOAL = "#1f9d63"
WEAKEST = 0.22
"""Strength of a trajectory where it begins."""
PIECES = 14
"""Pieces of a trajectory, each drawn in one strength."""


def draw_obstacles(axes: Any, world: Any) -> None:
    """Draw obstacles on a ground of equal scales."""
    axes.set_facecolor(GROUND)
    axes.grid(visible=False)
    axes.set_aspect("equal")
    for obstacle in world.obstacles:
        draw_outline(axes, obstacle.footprint())


def draw_world(axes: Any, world: Any) -> None:
    """Draw obstacles, solid edges, the path of the information agents and the goal."""
    from matplotlib.patches import Rectangle

    draw_obstacles(axes, world)
    if "solid" in world.edges:
        axes.add_patch(
            Rectangle(world.low[:2], *world.size[:2], fill=False, edgecolor=SOLID_EDGE, linewidth=2)
        )
    mission = world.mission
    if mission is not None and mission.path is not None:
        way = np.array(mission.path.waypoints)
        axes.plot(*way[:, :2].T, color=PATH, linewidth=1.0, linestyle=(0, (5, 4)), zorder=1.5)
        axes.plot(*way[:, :2].T, "o", markersize=3.5, color=PATH, zorder=1.6)
    if mission is not None and mission.goal is not None:
        goal = np.array(mission.goal.route[0])
        axes.plot(
            *goal[:2],
            "^",
            markersize=9,
            color=GOAL,
            markeredgecolor="white",
            zorder=6,
            clip_on=False,
        )


def draw_outline(axes: Any, shape: Any) -> None:
    """Draw a polygon of shapely, or several, with their holes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    for part in getattr(shape, "geoms", [shape]):
        rings = [part.exterior, *part.interiors]
        path = Path.make_compound_path(*(Path(np.array(ring.coords)[:, :2]) for ring in rings))
        axes.add_patch(
            PathPatch(path, facecolor=SOLID, edgecolor=SOLID_EDGE, linewidth=0.9, zorder=2)
        )


def draw_trails(
    axes: Any, tracks: np.ndarray, colours: list[str], width: float = 0.8, strongest: float = 0.8
) -> None:
    """Draw trajectories (T, N, dim), length, a colour for each agent, weak where they are old."""
    from matplotlib.collections import LineCollection

    edges = np.linspace(0, len(tracks) - 1, PIECES + 1).astype(int)
    for k, (first, last) in enumerate(pairwise(edges)):
        if last > first:
            share = (k + 1) / PIECES
            axes.add_collection(
                LineCollection(
                    list(tracks[first : last + 1].transpose(1, 0, 2)[:, :, :2]),
                    colors=colours,
                    linewidths=width,
                    alpha=WEAKEST + (strongest - WEAKEST) * share,
                    capstyle="butt",
                    zorder=3,
                )
            )


def draw_agents(axes: Any, position: np.ndarray, colours: list[str], size: float = 14.0) -> None:
    """Draw agents (N, dim) as dots."""
    axes.scatter(
        *position[:, :2].T, s=size, c=colours, edgecolors="white", linewidths=0.5, zorder=5
    )


def draw_links(axes: Any, position: np.ndarray, links: np.ndarray) -> None:
    """Draw lines between the pairs of rows (M, 2) of agents (N, dim)."""
    from matplotlib.collections import LineCollection

    axes.add_collection(
        LineCollection(
            list(position[links][:, :, :2]), colors=AGENT, linewidths=0.5, alpha=0.35, zorder=3.5
        )
    )


def bounding_box(tracks: np.ndarray, margin: float) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner of the box around positions (..., dim) with a margin, length."""
    flat = tracks.reshape(-1, tracks.shape[-1])[:, :2]
    return flat.min(axis=0) - margin, flat.max(axis=0) + margin


def extent(world: Any, tracks: np.ndarray, margin: float) -> tuple[np.ndarray, np.ndarray]:
    """The same for positions, all obstacles and the way of a mission."""
    shapes = [obstacle.footprint().bounds for obstacle in world.obstacles]
    places = [np.array(shape).reshape(2, 2) for shape in shapes]
    if world.mission is not None and world.mission.path is not None:
        places.append(np.array(world.mission.path.waypoints)[:, :2])
    if world.mission is not None and world.mission.goal is not None:
        places.append(np.array(world.mission.goal.route)[:, :2])
    flat = tracks.reshape(-1, tracks.shape[-1])[:, :2]
    return bounding_box(np.concatenate([flat, *places]), margin)


def show_box(axes: Any, low: np.ndarray, high: np.ndarray) -> None:
    """Show the part of the plane between two corners."""
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
