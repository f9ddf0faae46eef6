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
    has_points = bool(len(points))
    if not has_points:
        points, colours = _DOT, np.zeros(_DOT.shape) if np.ndim(colours) == 3 else colours
    return [
        (handle, "points", points.astype(np.float32)),
        (handle, "colors", np.asarray(colours, dtype=np.uint8)),
        (handle, "visible", has_points),
    ]


# Lines in a world that wraps: the short way round, and never across the whole box.


def nearest_image(step: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Steps (M, 3) to the nearest image; an infinite period leaves an axis alone.

    >>> nearest_image(np.array([[9.0, 1.0, 0.0]]), np.array([10.0, np.inf, np.inf])).tolist()
    [[-1.0, 1.0, 0.0]]
    """
    finite = np.where(np.isfinite(period), period, 1.0)
    turns = np.where(np.isfinite(period), np.rint(step / finite), 0.0)
    return step - turns * finite


def split_at_seams(start: np.ndarray, end: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Straight lines between nearest images as segments (K, 2, 3) that stay inside the box.

    `start` and `end` are (M, 3), in a box centred on the origin. A line that crosses a seam
    becomes two: from each end as far as the seam.
    """
    step = nearest_image(end - start, period)
    crossing = np.any(np.abs(step - (end - start)) > 1e-9, axis=1)
    uncut = np.stack([start[~crossing], end[~crossing]], axis=1)
    if not crossing.any():
        return uncut
    outward, inward = step[crossing], -step[crossing]
    first = np.stack([start[crossing], _until_seam(start[crossing], outward, period)], axis=1)
    second = np.stack([end[crossing], _until_seam(end[crossing], inward, period)], axis=1)
    return np.concatenate([uncut, first, second])


def _until_seam(start: np.ndarray, step: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Where the lines from `start` along `step` leave the box, or their ends if they do not."""
    wall = 0.5 * period
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(step > 0.0, (wall - start) / step, (-wall - start) / step)
    share = np.where(step == 0.0, np.inf, share)
    reach = np.clip(np.min(share, axis=1), 0.0, 1.0)
    return start + reach[:, None] * step


def jumps(before: np.ndarray, after: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Which moves (..., 3) -> (..., 3) went through a seam: more than half a period, (...)."""
    return np.any(np.abs(after - before) > 0.5 * period, axis=-1)
