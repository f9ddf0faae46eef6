"""Where agents have crashed: a ring and a cross, and in space a line down; they fade with time."""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.shapes import circle
from app.viewer.scene.marks.world.mission_marks import on_floor
from app.viewer.scene.shown import palette, tone

MOST = 80
"""Only so many of the latest crashes are marked."""
FADES = 100
"""Time in which a mark fades, ticks; a pale one stays."""
PALEST = 0.72
"""Share of the backdrop in the colour of a mark that has faded."""
DROP = 0.68
"""The same of the line down from a new one, which vanishes."""
RADIUS, RADIUS_CAR = 0.55, 0.95
"""Of the ring, as a multiple of an agent's length, and of a car's."""


class CrashMarks:
    """Marks at the places, drawn of the latest crashes."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._lines = add_lines(scene, f"{root}/flock/crashes", thickness=1.5, many_coloured=True)

    def draw(self, picture: Picture) -> Changes:
        crashes = picture.frame.crashes
        if crashes is None or not len(crashes):
            return [(self._lines, "visible", False)]
        at = on_floor(picture, crashes.place[-MOST:])
        age = np.clip((picture.frame.tick - crashes.tick[-MOST:]) / FADES, 0.0, 1.0)
        radius = RADIUS_CAR if picture.as_cars else RADIUS
        sign = radius * picture.length * mark()
        lines = [(at[:, None, None, :] + sign).reshape(-1, 2, 3)]
        colours = [np.repeat(shown(picture, PALEST * age), len(sign), axis=0)]
        if picture.stage.dim == 3:
            fresh = age < 1.0
            foot = at.copy()
            foot[:, 2] = picture.stage.floor
            lines.append(np.stack([at, foot], axis=1)[fresh])
            colours.append(shown(picture, DROP + (1.0 - DROP) * age[fresh]))
        ends = np.repeat(np.concatenate(colours)[:, None], 2, axis=1)
        return segments(self._lines, np.concatenate(lines), ends)


def shown(picture: Picture, share: np.ndarray) -> np.ndarray:
    """The colour of a mark with shares (M,) of the backdrop, bytes (M, 3)."""
    return tone.unlit(picture.mixed(palette.CRASH, share[:, None]))


def mark() -> np.ndarray:
    """A level ring of radius 1 with a cross in it, as line segments (K, 2, 3)."""
    half = 0.5 * np.sqrt(0.5)
    cross = half * np.array([[[-1.0, -1, 0], [1, 1, 0]], [[-1, 1, 0], [1, -1, 0]]])
    return np.concatenate([circle(20), cross])
