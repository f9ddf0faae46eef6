"""Rings around cars that something keeps from getting on."""

from __future__ import annotations

from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.shapes import circle
from app.viewer.scene.marks.world.mission_marks import on_floor
from app.viewer.scene.shown import palette, tone

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
        at = on_floor(picture, picture.frame.position[cars.stuck])
        rings = at[:, None, None, :] + RADIUS * picture.length * circle(32)
        return segments(self._lines, rings.reshape(-1, 2, 3), tone.single(palette.FENCE))
