"""A node of line segments that may be empty."""

from __future__ import annotations

import numpy as np
from viser import LineSegmentsHandle, SceneApi

from app.viewer.scene.draw.drawn_frame import Changes

_DOT = np.zeros((1, 2, 3), dtype=np.float32)


def add_lines(
    scene: SceneApi, name: str, thickness: float, many_coloured: bool = False
) -> LineSegmentsHandle:
    """An empty set of segments, `thickness` pixels wide.

    Whether it will have one colour or a colour for each end has to be said now: viser's client
    does not compile the line's shader again when that changes.
    """
    return scene.add_line_segments(
        name,
        _DOT,
        np.zeros(_DOT.shape if many_coloured else 3, dtype=np.uint8),
        thickness=thickness,
        thickness_units="screen",
        visible=False,
    )


def segments(
    handle: LineSegmentsHandle, points: np.ndarray, colours: np.ndarray | tuple[int, int, int]
) -> Changes:
    """Draw the segments (K, 2, 3) in colours (K, 2, 3) or (3,), bytes; hide the node when K = 0.

    A browser shows a node a moment before it has its new points: what is hidden leaves its old
    ones, or they would flash up.
    """
    there = bool(len(points))
    if not there:
        points, colours = _DOT, np.zeros(_DOT.shape) if np.ndim(colours) == 3 else colours
    return [
        (handle, "points", points.astype(np.float32)),
        (handle, "colors", np.asarray(colours, dtype=np.uint8)),
        (handle, "visible", there),
    ]
