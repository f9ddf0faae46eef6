"""A camera that rides along: behind an agent and over it, looking where it goes."""

from __future__ import annotations

import numpy as np

from app.viewer.scene.cameras.camera import CameraView
from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.draw.seam import nearest_image

CATCH_UP, TURN = 0.10, 0.22
"""Time constants with which it catches up with the agent's place and with its heading, s."""
BEHIND, OVER, AHEAD = {2: 6.0, 3: 4.4}, {2: 3.2, 3: 1.5}, {2: 2.0, 3: 2.5}
"""Where it is and what it looks at, in lengths of the agent, by dimension."""
STEEPEST = np.deg2rad(50.0)
"""A camera does not follow a climb or a dive steeper than this: it would lose its upright."""
ABOVE_FLOOR = 0.6
"""How far it keeps above the floor, in lengths of the agent."""
FOV = 1.0


class Ride:
    """One browser's ride on the agent of one identity."""

    def __init__(
        self, picture: Picture, row: int, aside: np.ndarray, side: int, before: CameraView
    ) -> None:
        """`aside` (3,) is where the room of the flock `side` stands."""
        self.side, self.before = side, before
        self.identity = int(picture.frame.ids[row])
        self._place = self._seen = picture.at[row] + aside
        self._ahead = straightened(picture.frame.heading[row])
        self.view = self._look(picture, row, aside)

    def move(self, picture: Picture, aside: np.ndarray, passed: float) -> bool:
        """Go on to a new frame, `passed` seconds after the last; whether the agent is there."""
        rows = np.flatnonzero(picture.frame.ids == self.identity)
        if not len(rows):
            return False
        row = int(rows[0])
        at = picture.at[row] + aside
        step = at - self._seen
        # Through a seam the camera goes with its agent, and only the rest of the way smoothly.
        self._place = self._place + step - nearest_image(step[None], picture.stage.period)[0]
        self._place = self._place + (1.0 - np.exp(-passed / CATCH_UP)) * (at - self._place)
        self._seen = at
        if not picture.frame.down[row]:
            heading = straightened(picture.frame.heading[row])
            ahead = self._ahead + (1.0 - np.exp(-passed / TURN)) * (heading - self._ahead)
            if np.linalg.norm(ahead) > 1e-3:
                self._ahead = straightened(ahead)
        self.view = self._look(picture, row, aside)
        return True

    def _look(self, picture: Picture, row: int, aside: np.ndarray) -> CameraView:
        dim, length = picture.stage.dim, picture.length * float(picture.size[row])
        up = np.array([0.0, 0.0, 1.0])
        position = self._place + length * (OVER[dim] * up - BEHIND[dim] * self._ahead)
        position[2] = max(position[2], picture.stage.floor + aside[2] + ABOVE_FLOOR * length)
        return CameraView(position, self._place + AHEAD[dim] * length * self._ahead, FOV)


def straightened(heading: np.ndarray) -> np.ndarray:
    """A direction (2,) or (3,) as a unit vector (3,) that is no steeper than STEEPEST."""
    level = np.array([heading[0], heading[1], 0.0])
    across = float(np.linalg.norm(level))
    level = level / across if across > 1e-9 else np.array([1.0, 0.0, 0.0])
    rise = 0.0 if len(heading) == 2 else np.arctan2(heading[2], across)
    rise = float(np.clip(rise, -STEEPEST, STEEPEST))
    return np.cos(rise) * level + np.array([0.0, 0.0, np.sin(rise)])
