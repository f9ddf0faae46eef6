"""Simulated cars beside real ones: of glass, with their outlines drawn."""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.car_solid import HEIGHT, cabin, hull, outline
from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.marks.flock.fleet import add_cars, facing
from app.viewer.scene.shown import palette, tone
from app.viewer.scene.shown.live_cars import SIMULATED

OUTLINE = outline()
INK = tone.single(palette.STATES[SIMULATED])
GLASSY = 0.35
"""Opacity of a hull."""
THICK = 1.8
"""Width of its outline, pixels."""


class Ghosts:
    """They cast no shadow: nothing stands there."""

    def __init__(self, scene: SceneApi, root: str) -> None:
        name = f"{root}/flock/simulated"
        self._hulls = add_cars(scene, f"{name}/hulls", hull(), GLASSY)
        self._cabins = add_cars(scene, f"{name}/cabins", cabin(), GLASSY)
        self._lines = add_lines(scene, f"{name}/outlines", THICK)

    def draw(self, picture: Picture) -> Changes:
        """Draw the simulated cars, if there are real ones."""
        live, cars = picture.live, picture.frame.cars
        rows = np.empty(0, int) if live is None else np.flatnonzero(live.are(SIMULATED))
        if cars is None or not len(rows):
            nodes = (self._hulls, self._cabins, self._lines)
            return [(node, "visible", False) for node in nodes]
        at, heading = picture.at[rows] * [1.0, 1.0, 0.0], picture.frame.heading[rows]
        length = picture.length * picture.size[rows]
        width = length * cars.width / cars.length
        size = np.column_stack([length, width, HEIGHT * width])
        turned = facing(np.arctan2(heading[:, 1], heading[:, 0]))
        changes: Changes = []
        for node, paint in (
            (self._hulls, picture.colour[rows]),
            (self._cabins, np.tile(palette.GLASS, (len(rows), 1))),
        ):
            changes += [
                (node, "batched_positions", at.astype(np.float32)),
                (node, "batched_wxyzs", turned),
                (node, "batched_scales", size.astype(np.float32)),
                (node, "batched_colors", tone.lit(paint)),
                (node, "visible", True),
            ]
        return [
            *changes,
            *segments(self._lines, outlines(at, heading, size), INK),
        ]


def outlines(at: np.ndarray, heading: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Outlines (K, 2, 3) of cars at (N, 3) that look along unit vectors (N, 2), with lengths,
    widths and heights (N, 3)."""
    x, y, z = np.moveaxis(OUTLINE[None] * size[:, None, None, :], -1, 0)
    (ahead_x, ahead_y) = (heading[:, axis, None, None] for axis in (0, 1))
    turned = np.stack([x * ahead_x - y * ahead_y, x * ahead_y + y * ahead_x, z], axis=-1)
    return (turned + at[:, None, None, :]).reshape(-1, 2, 3)
