"""Which agent a click means."""

from __future__ import annotations

import numpy as np

SLACK = 0.006
"""Half-width of the cone about the ray in which an agent counts as hit, rad."""
NEAR = 0.013
"""The same as a share of half the height of what a camera sees: some six pixels."""


def cone_half_width(fov: float) -> float:
    """Half-width of the cone for a camera that sees so much from top to bottom (rad), rad."""
    return NEAR * float(np.tan(0.5 * np.clip(fov, 0.01, 2.5)))


def pick_agent(
    origin: np.ndarray,
    direction: np.ndarray,
    at: np.ndarray,
    radius: np.ndarray,
    slack: float = SLACK,
) -> int | None:
    """Row of the agent that a ray hits, or None.

    `at` (N, 3) and `radius` (N,) are in the ray's units, `slack` is the half-width of the cone
    about the ray in which an agent counts as hit, rad. Of several, the nearest to the ray
    relative to its size is meant, a little in favour of those in front.
    """
    if not len(at) or not (np.isfinite(origin).all() and np.isfinite(direction).all()):
        return None
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        return None
    away = at - origin
    along = away @ (direction / length)
    aside = np.sqrt(np.maximum(np.einsum("ij,ij->i", away, away) - along**2, 0.0))
    miss = aside / (radius + slack * np.maximum(along, 0.0))
    miss[(along <= 0.0) | (miss > 1.0)] = np.inf
    best = int(np.argmin(miss + 0.02 * along))
    return best if np.isfinite(miss[best]) else None
