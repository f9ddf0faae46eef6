"""The boundary points of what is solid, as small dots."""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.marks.world.obstacle_marks import drawn_height
from app.viewer.scene.shown import palette, tone

DIAMETER = 0.0024
"""Of a dot, as a multiple of the longest side; less where they would run into each other."""


class BoundaryPointMarks:
    """Sent when they are switched on or the world changes."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._dots = scene.add_point_cloud(
            f"{root}/world/points",
            np.zeros((1, 3), dtype=np.float32),
            tone.single(palette.POINT),
            point_shape="circle",
            point_shading="flat",
            precision="float32",
            visible=False,
        )
        self._drawn: np.ndarray | None = None

    def draw(self, picture: Picture) -> Changes:
        """Draw the points, on top of the obstacles' rims."""
        points = picture.frame.points if picture.look.points else None
        if points is self._drawn:
            return []
        self._drawn = points
        if points is None or not len(points):
            return [(self._dots, "visible", False)]
        stage, world = picture.stage, picture.frame.world
        size = min(DIAMETER * stage.side, 0.3 * world.boundary_spacing * stage.scale)
        return [
            (self._dots, "points", on_rims(picture, points, drawn_height(world))),
            (self._dots, "point_size", size),
            (self._dots, "visible", True),
        ]


def on_rims(picture: Picture, points: np.ndarray, height: float) -> np.ndarray:
    """Boundary points (M, 2) on the display, just above what stands `height` tall; (M, 3)."""
    shown = picture.stage.shown(points)
    shown[:, 2] = height * picture.stage.scale + 0.01
    return shown.astype(np.float32)
