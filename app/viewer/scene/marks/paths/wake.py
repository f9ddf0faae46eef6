"""The wake of birds: the lines that their wing tips leave behind.

The vortices that come off the tips turn against each other, up on the outside: so the left line
is cool and the right one warm. They are drawn where the tips of level wings have been; what the
flock's model knows of upwash is not read from them.
"""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.bird import TIP
from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.marks.flock.birds import SCALE, leftwards
from app.viewer.scene.marks.flock.flock_motion import FlockMotion
from app.viewer.scene.marks.paths.streaks import Streaks, chosen
from app.viewer.scene.shown import palette

MOST_BIRDS = 300


class Wake(Streaks):
    """Two thin lines behind each bird, or of very many birds behind some."""

    def __init__(self, scene: SceneApi, root: str, flight: FlockMotion) -> None:
        super().__init__(scene, f"{root}/flock/wake", thick=0.7)
        self._flight = flight

    def draw(self, picture: Picture) -> Changes:
        look = picture.look
        if not (look.wake and picture.as_birds and look.trail_length >= 1):
            return self.hide()
        rows = chosen(picture.frame.informed, MOST_BIRDS)
        aside = span(picture, rows) * leftwards(self._flight.poses.wxyz[rows])
        at, ids = picture.at[rows], picture.frame.ids[rows]
        tips = np.concatenate([at + aside, at - aside])
        tips[np.tile(picture.frame.down[rows], 2)] = np.nan
        colour = np.repeat([palette.COOL, palette.WARM], len(rows), axis=0)
        return self.follow(picture, np.concatenate([2 * ids, 2 * ids + 1]), tips, colour)


def span(picture: Picture, rows: np.ndarray) -> np.ndarray:
    """Distance of the wing tips from the middle of the birds in `rows`, (M, 1)."""
    return TIP * SCALE * picture.length * picture.size[rows, None]
