"""Tracks of individuals that go round in a ring, with gaps that are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.tracks.tracks import Tracks

RATE, FRAMES, COUNT = 25.0, 120, 12
RADIUS, TURN = 5.0, 1.2
"""m, and rad/s."""
GAP = slice(40, 60)
"""Where the individual in row 3 is not seen."""
LATE, GONE = 30, 80
"""The first frame of the one in row 5, and the first without the one in row 4."""


def ring_tracks(unit: str = "m", **more) -> Tracks:
    """Individuals at even distances in a ring, going round anticlockwise."""
    time = np.arange(FRAMES) / RATE
    angle = TURN * time[:, None] + 2.0 * np.pi * np.arange(COUNT) / COUNT
    position = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    position[GAP, 3] = np.nan
    position[:LATE, 5] = np.nan
    position[GONE:, 4] = np.nan
    tracks = Tracks(
        position, np.arange(FRAMES), time, tuple(f"fish {k}" for k in range(COUNT)), unit,
        name="ring.csv",
    )  # fmt: skip
    return replace(tracks, **more)
