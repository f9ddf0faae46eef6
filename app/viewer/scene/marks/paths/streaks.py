"""Lines that moving points leave behind them; they fade with age and break at the seams.

Past places are kept, about `KNOTS` a line. The older part is sent only when a knot is added; each
frame sends no more than the stretch from the last knot.
"""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.seam import jumps
from app.viewer.scene.marks.paths.trail_history import TrailHistory
from app.viewer.scene.shown import tone

KNOTS = 16
FAINTEST, STRONGEST = 0.80, 0.20
"""Share of the backdrop in the colour of a line at its old and at its new end."""


class Streaks:
    """The lines of one run; forgotten when the run changes."""

    def __init__(self, scene: SceneApi, name: str, thick: float = 1.0) -> None:
        self._old = add_lines(scene, f"{name}/old", thick, many_coloured=True)
        self._young = add_lines(scene, f"{name}/young", 1.8 * thick, many_coloured=True)
        self._tip = add_lines(scene, f"{name}/tip", 2.2 * thick, many_coloured=True)
        self._past = TrailHistory()

    def hide(self) -> Changes:
        """Forget them, and draw nothing."""
        self._past.clear()
        return [(lines, "visible", False) for lines in (self._old, self._young, self._tip)]

    def follow(
        self, picture: Picture, ids: np.ndarray, here: np.ndarray, colour: np.ndarray
    ) -> Changes:
        """Draw the lines of points `here` (M, 3), NaN for none, with identities (M,) and colours
        (M, 3); they reach back as far as the look wants trails to."""
        length = picture.look.trail_length
        added = self._past.remember(picture.frame, ids, here, length, KNOTS)
        changes = self._draw_tip(picture, here, colour)
        return changes + self._draw_history(picture, colour) if added else changes

    def _draw_history(self, picture: Picture, colour: np.ndarray) -> Changes:
        knots = np.stack(self._past.knots)
        points = np.stack([knots[:-1], knots[1:]], axis=2)
        kept = ~jumps(points[:, :, 0], points[:, :, 1], picture.stage.period)
        kept &= np.isfinite(points).all(axis=(2, 3))
        age = (picture.frame.tick - np.array(self._past.ticks)) / picture.look.trail_length
        share = STRONGEST + (FAINTEST - STRONGEST) * np.clip(age, 0.0, 1.0)
        faded = picture.mixed(colour, share[:, None, None])
        colours = tone.unlit(np.stack([faded[:-1], faded[1:]], axis=2))
        half = len(points) // 2
        old, young = slice(None, half), slice(half, None)
        return segments(self._old, points[old][kept[old]], colours[old][kept[old]]) + segments(
            self._young, points[young][kept[young]], colours[young][kept[young]]
        )

    def _draw_tip(self, picture: Picture, here: np.ndarray, colour: np.ndarray) -> Changes:
        points = np.stack([self._past.knots[-1], here], axis=1)
        kept = ~jumps(points[:, 0], points[:, 1], picture.stage.period)
        kept &= np.isfinite(points).all(axis=(1, 2))
        colours = tone.unlit(picture.mixed(colour, STRONGEST))
        return segments(self._tip, points[kept], np.repeat(colours[kept][:, None], 2, axis=1))


def chosen(informed: np.ndarray, most: int) -> np.ndarray:
    """Rows whose lines are drawn: all, or evenly spaced ones and the first information agents."""
    count = len(informed)
    if count <= most:
        return np.arange(count)
    even = np.linspace(0, count - 1, most).astype(int)
    return np.union1d(even, np.flatnonzero(informed)[: most // 4])
