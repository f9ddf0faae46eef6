"""A flock in its box, drawn in three dimensions: who hangs together, who lies on the floor."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from app.studies.kinds.gathering import groups_of

GROUPS = ("#2166ac", "#d9822b", "#1f9d63", "#8e44ad", "#b8860b", "#16808a")
"""Colours of the largest groups; alone are those of one."""
ALONE, CRASHED = "#7a828c", "#c0392b"
SOLID, EDGE, FLOOR = "#9fb4cc", "#aab2bd", "#eef1f4"
LENGTH = 0.06
"""Length of an arrow, of the box's longest side."""


def draw_box(axes: Any, flock: Any, shades: list[Any] | None = None) -> None:
    """Draw the box, its obstacles and the flock as it stands.

    `shades`: colours of those that fly; None: those of their groups.
    """
    from mpl_toolkits.mplot3d.art3d import (  # type: ignore[import-untyped]
        Line3DCollection,
        Poly3DCollection,
    )

    low, size = np.array(flock.world.low), np.array(flock.world.size)
    # Depth is left to the order of drawing: the floor would else hide those that lie on it.
    axes.computed_zorder = False
    axes.add_collection3d(Poly3DCollection([faces_of(low, size)[0]], facecolor=FLOOR))
    axes.add_collection3d(Line3DCollection(edges_of(low, size), colors=EDGE, linewidths=0.7))
    for obstacle in flock.world.obstacles:
        for outline, bottom, top in obstacle.spans():
            foot = low[2] if bottom is None else bottom
            height = (low[2] + size[2] if top is None else top) - foot
            x0, y0, x1, y1 = outline.bounds
            corner = np.array([x0, y0, foot])
            faces = faces_of(corner, np.array([x1 - x0, y1 - y0, height]))
            axes.add_collection3d(
                Poly3DCollection(
                    faces, facecolor=SOLID, edgecolor="white", linewidth=0.4, alpha=0.3
                )
            )
    draw_flock(axes, flock, LENGTH * float(size.max()), shades)
    axes.set(
        xlim=(low[0], low[0] + size[0]),
        ylim=(low[1], low[1] + size[1]),
        zlim=(low[2], low[2] + size[2]),
    )
    axes.set_proj_type("ortho")
    axes.set_box_aspect(size, zoom=1.1)
    axes.view_init(20, -60)
    axes.set_axis_off()


def draw_flock(axes: Any, flock: Any, length: float, shades: list[Any] | None = None) -> None:
    """Draw those that fly as arrows, those that have crashed as crosses."""
    up = flock.active
    place = np.where(flock.world.wraps, flock.position % flock.world.size, flock.position)
    if not up.all():
        axes.scatter(
            *place[~up].T, marker="x", s=16, color=CRASHED, linewidths=1.2, depthshade=False
        )
    fly, way = place[up], flock.heading[up] * length
    if len(fly):
        axes.quiver(
            *(fly - 0.5 * way).T,
            *way.T,
            colors=shades or colours(groups_of(flock)),
            linewidths=1.3,
            arrow_length_ratio=0.45,
        )


def colours(labels: np.ndarray) -> list[str]:
    """The colour of each agent's group; grey for those that are alone or in one of many."""
    sizes = np.bincount(labels)
    return [
        GROUPS[label] if label < len(GROUPS) and sizes[label] > 1 else ALONE for label in labels
    ]


def edges_of(low: np.ndarray, size: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """The twelve edges of a box."""
    corners = [np.array(corner) for corner in product((0.0, 1.0), repeat=3)]
    return [
        (low + a * size, low + b * size)
        for k, a in enumerate(corners)
        for b in corners[k + 1 :]
        if np.abs(a - b).sum() == 1.0
    ]


def faces_of(low: np.ndarray, size: np.ndarray) -> list[np.ndarray]:
    """The six faces of a box, (4, 3) each, the floor first."""
    faces = []
    for axis in (2, 1, 0):
        i, j = (k for k in range(3) if k != axis)
        for end in (0.0, 1.0):
            face = np.zeros((4, 3))
            face[:, axis] = end
            face[:, i] = (0.0, 1.0, 1.0, 0.0)
            face[:, j] = (0.0, 0.0, 1.0, 1.0)
            faces.append(low + face * size)
    return faces
