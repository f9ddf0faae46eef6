"""Outlines around real cars: what each of them is, in the colour of its state."""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.shapes import circle
from app.viewer.scene.marks.mission_marks import floor_places
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.frame import LATE, LOST, STOPPED, TRACKED

# Rings around cars that something keeps from getting on.

RADIUS = 0.75
"""Of a ring, as a multiple of a car's length."""


class StuckMarks:
    """A mark on each car that is stuck, as long as it is."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._lines = add_lines(scene, f"{root}/flock/stuck", thickness=2.4)

    def draw(self, picture: Picture) -> Changes:
        """Draw the marks."""
        cars = picture.frame.cars
        if cars is None or not picture.as_cars or not cars.stuck.any():
            return [(self._lines, "visible", False)]
        at = floor_places(picture, picture.frame.position[cars.stuck])
        rings = at[:, None, None, :] + RADIUS * picture.length * circle(32)
        return segments(self._lines, rings.reshape(-1, 2, 3), palette.node_colour(palette.FENCE))


CLEAR = 0.16
"""Distance of an outline from the car's sides, as a multiple of its length."""
ROUND = 8
"""Corners of the quarter of a circle at each end of its sides."""
THICK = {TRACKED: 1.8, STOPPED: 2.4, LATE: 3.2, LOST: 3.8}
"""Width in pixels: the worse, the thicker. Simulated cars have outlines of their own."""


class LiveOutlines:
    """A rounded rectangle around each real car."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._lines = {
            state: add_lines(scene, f"{root}/flock/outlines/{state}", thick)
            for state, thick in THICK.items()
        }

    def draw(self, picture: Picture) -> Changes:
        """Draw the outlines, if there are real cars."""
        live, cars, changes = picture.live, picture.frame.cars, Changes()
        for state, lines in self._lines.items():
            if live is None or cars is None:
                changes.append((lines, "visible", False))
                continue
            rows = live.is_in_state(state)
            at = floor_places(picture, picture.frame.position[rows])
            shape = picture.length * outline(cars.width / cars.length)
            outline_lines = turn_segments(shape, picture.frame.heading[rows]) + at[:, None, None, :]
            colour = palette.node_colour(palette.STATES[state])
            changes += segments(lines, outline_lines.reshape(-1, 2, 3), colour)
        return changes


def outline(slender: float) -> np.ndarray:
    """Around a car of length 1 and this width that looks along x, as line segments (K, 2, 3)."""
    angle = np.linspace(0.0, 0.5 * np.pi, ROUND)
    quarter = CLEAR * np.column_stack([np.cos(angle), np.sin(angle)])
    corner = 0.5 * np.array([1.0, slender]) + quarter
    left = np.concatenate([corner, corner[::-1] * [-1.0, 1.0]])
    around = np.concatenate([left, -left])
    points = np.column_stack([around, np.zeros(len(around))])
    return np.stack([points, np.roll(points, -1, axis=0)], axis=1)


def turn_segments(shape: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Segments (K, 2, 3) that look along x, turned to N directions (N, 2): (N, K, 2, 3)."""
    (x, y, z), (ahead_x, ahead_y) = np.moveaxis(shape, -1, 0), heading.T[:, :, None, None]
    level = np.broadcast_to(z, (len(heading), *z.shape))
    return np.stack([x * ahead_x - y * ahead_y, x * ahead_y + y * ahead_x, level], axis=-1)
