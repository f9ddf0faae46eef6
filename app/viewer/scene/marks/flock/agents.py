"""The agents: darts, in space birds, cars, or points when there are very many."""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.coarse import places, turned
from app.viewer.scene.draw.drawn_frame import FEW_LEADERS, POINTS_BEYOND, Changes, Picture
from app.viewer.scene.draw.shapes import dart
from app.viewer.scene.marks.flock.birds import Birds
from app.viewer.scene.marks.flock.fleet import Fleet
from app.viewer.scene.marks.flock.flock_motion import FlockMotion
from app.viewer.scene.marks.flock.ghosts import Ghosts
from app.viewer.scene.shown import tone
from app.viewer.scene.shown.drawing_style import SHADOWS_UP_TO

POINT_SIZE = {2: 0.6, 3: 0.28}
"""Size of a point as a multiple of the length of a dart, by dimension."""


class Agents:
    """The flock's own nodes in the scene."""

    def __init__(self, scene: SceneApi, root: str, flight: FlockMotion) -> None:
        self._birds = Birds(scene, root, flight)
        self._fleet = Fleet(scene, root)
        self._ghosts = Ghosts(scene, root)
        nowhere, level = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
        self._darts = scene.add_batched_meshes_simple(
            f"{root}/flock/darts",
            *dart(),
            batched_wxyzs=level,
            batched_positions=nowhere,
            batched_scales=np.ones(1),
            batched_colors=np.zeros((1, 3), dtype=np.uint8),
            flat_shading=True,
            lod="off",
            receive_shadow=False,
            visible=False,
        )
        self._points = scene.add_point_cloud(
            f"{root}/flock/points",
            nowhere,
            np.zeros((1, 3), dtype=np.uint8),
            point_shape="circle",
            point_shading="flat",
            visible=False,
        )

    def draw(self, picture: Picture) -> Changes:
        count = len(picture.at)
        as_points = count > POINTS_BEYOND
        rows, nobody = as_darts(picture), slice(0, 0)
        return [
            *self._draw_darts(picture, nobody if picture.as_birds or picture.as_cars else rows),
            *self._birds.draw(picture, rows if picture.as_birds else nobody),
            *self._fleet.draw(picture, rows if picture.as_cars else nobody),
            *self._ghosts.draw(picture),
            *(self._draw_points(picture) if as_points else []),
            (self._points, "visible", as_points),
        ]

    def _draw_darts(self, picture: Picture, rows: np.ndarray | slice) -> Changes:
        at = picture.at[rows]
        if not len(at):
            return [(self._darts, "visible", False)]
        shadows = picture.look.shadows and len(at) <= SHADOWS_UP_TO
        return [
            (self._darts, "batched_positions", places(at, picture.length)),
            (self._darts, "batched_wxyzs", turned(picture.wxyz[rows])),
            (self._darts, "batched_scales", picture.size[rows] * np.float32(picture.length)),
            (self._darts, "batched_colors", tone.lit(picture.colour[rows])),
            (self._darts, "cast_shadow", shadows),
            (self._darts, "visible", True),
        ]

    def _draw_points(self, picture: Picture) -> Changes:
        return [
            (self._points, "points", places(picture.at, picture.length)),
            (self._points, "colors", (255.0 * picture.colour + 0.5).astype(np.uint8)),
            (self._points, "point_size", POINT_SIZE[picture.stage.dim] * picture.length),
        ]


def as_darts(picture: Picture) -> np.ndarray | slice:
    """Rows drawn as darts: all, or among points the few agents that matter."""
    if len(picture.at) <= POINTS_BEYOND:
        return slice(None)
    informed = np.flatnonzero(picture.frame.informed)
    inspected = picture.inspected
    return np.union1d(informed[:FEW_LEADERS], [] if inspected is None else [inspected]).astype(int)
