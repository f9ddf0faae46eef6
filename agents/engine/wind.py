"""Wind: it carries all agents along in each tick, beside their own motion."""

from __future__ import annotations

import numpy as np

from agents.engine.block import BodyMove
from worlds.compilation import compiled

NO_WIND = np.empty((0, 3))
"""No wind."""


@compiled
def carried(moved, context, tick):
    """Where the wind of a tick has taken an agent that has moved so."""
    wind, at = context.wind, tick - context.since
    return BodyMove(
        moved.x + wind[at, 0],
        moved.y + wind[at, 1],
        moved.z + wind[at, 2],
        moved.ux,
        moved.uy,
        moved.uz,
        moved.speed,
    )
