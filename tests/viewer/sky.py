"""Birds for the tests: frames of birds in an open sky, and a clock that they set."""

from __future__ import annotations

import numpy as np

from app.viewer.scene.draw.drawn_frame import Picture, picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown.drawing_style import DrawingStyle
from app.viewer.scene.shown.frame import Frame
from worlds.world import World

SKY = World("sky", (20.0,) * 3, ("wrap",) * 3)
STEP = 1 / 40


class Clock:
    """Time as a test wants it."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def heading(azimuth: float, elevation: float = 0.0) -> np.ndarray:
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])


def frame(headings: list[np.ndarray], tick: int = 0, **changes) -> Frame:
    count = len(headings)
    known = {
        "run": 1,
        "tick": tick,
        "world": SKY,
        "reach": 8.0,
        "speed_scale": 3.0,
        "position": 10.0 + np.arange(3.0 * count).reshape(count, 3) / (3.0 * count + 1.0),
        "heading": np.array(headings).reshape(-1, 3),
        "speed": np.full(count, 3.0),
        "informed": np.zeros(count, dtype=bool),
        "ids": np.arange(1, count + 1),
        "dt": 0.1,
        "unit": "s",
    }
    return Frame(**(known | changes))


def shown(one: Frame, look: DrawingStyle | None = None) -> Picture:
    return picture(one, look or DrawingStyle(), Stage.of(one))
