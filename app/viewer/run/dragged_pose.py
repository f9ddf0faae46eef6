"""Where an agent may be put that a browser drags about."""

from __future__ import annotations

import math

import numpy as np

from app.viewer.scene.shown.frame import Frame

FARTHEST = 100.0
"""How far out of an open world an agent may be dragged, longest sides."""


def leader(frame: Frame | None) -> int | None:
    """Row of the information agent; None if there is none."""
    if frame is None or not frame.informed.any():
        return None
    return int(np.argmax(frame.informed))


def usable_pose(
    frame: Frame, position: np.ndarray, heading: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """A position (dim,) within the world and a unit vector (dim,); None for what is neither."""
    position, heading = np.asarray(position, float), np.asarray(heading, float)
    if position.shape != (frame.dim,) or heading.shape != (frame.dim,):
        return None
    length = float(np.linalg.norm(heading))
    if not np.isfinite(position).all() or not math.isfinite(length) or length < 1e-9:
        return None
    far = FARTHEST * float(frame.size.max())
    inside = np.where(
        frame.wraps,
        position % frame.size,
        np.clip(position, frame.low - far, frame.low + far),
    )
    return inside, heading / length
