"""What passes from the simulation to the drawing: one frozen picture of the flock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from agents.inspection import Inspection


@dataclass(frozen=True)
class Frame:
    """The flock at one tick. Arrays are copies that nobody writes to any more."""

    run: int
    """Counts the set-ups; a new number means a new flock, not a moved one."""
    tick: int
    dim: int
    """2 or 3."""
    size: np.ndarray
    """Sides of the world's box, (dim,), length; for an open world the side it was set up with."""
    wraps: np.ndarray
    """Whether each axis wraps, (dim,) bool."""
    reach: float
    """Interaction radius, length."""
    speed_scale: float
    """Speed that counts as full colour, length/tick."""
    position: np.ndarray
    """(N, dim)."""
    heading: np.ndarray
    """(N, dim), unit vectors."""
    speed: np.ndarray
    """(N,), length/tick."""
    informed: np.ndarray
    """(N,) bool: information agents."""
    ids: np.ndarray
    """(N,) int: identity of each row."""
    layer: np.ndarray | None = None
    """(N,) int: 1 information agent, 2 in contact with one, ...; N + 1 unknown. If asked for."""
    group: np.ndarray | None = None
    """(N,) int: label of the connected group, 0 the largest. If asked for."""
    links: np.ndarray | None = None
    """(M, 2) int: rows of neighbouring pairs, if asked for."""
    inspected: Inspection | None = None
