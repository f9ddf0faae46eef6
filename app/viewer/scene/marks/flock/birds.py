"""The agents as birds: a body and a pair of wings each, both meshes with an instance for a bird."""

from __future__ import annotations

import numpy as np
from viser import BatchedMeshHandle, SceneApi

from app.viewer.scene.draw.bird import SHOULDER, beaten, body, wings
from app.viewer.scene.draw.coarse import places, turned
from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.shapes import Mesh
from app.viewer.scene.marks.flock.flock_motion import FlockMotion
from app.viewer.scene.shown import tone
from app.viewer.scene.shown.drawing_style import SHADOWS_UP_TO

SCALE = 1.15
"""Length of a bird as a multiple of a dart's, which is stouter."""
SHADE = 0.72
"""Brightness of the body as a multiple of the wings'."""


class Birds:
    """What flies in space."""

    def __init__(self, scene: SceneApi, root: str, flight: FlockMotion) -> None:
        self._flight = flight
        self._bodies = _add(scene, f"{root}/flock/birds/bodies", body())
        self._wings = _add(scene, f"{root}/flock/birds/wings", wings())

    def draw(self, picture: Picture, rows: np.ndarray | slice) -> Changes:
        """Draw the agents of some rows as birds."""
        at = picture.at[rows]
        if not len(at):
            return self.hide()
        poses = self._flight.poses
        wxyz = poses.wxyz[rows]
        size = (SCALE * picture.length * picture.size[rows]).astype(np.float32)
        over = SHOULDER * size[:, None] * upwards(wxyz)
        shadows = picture.look.shadows and len(at) <= SHADOWS_UP_TO
        colour = picture.colour[rows]
        changes: Changes = []
        for node, place, scale, shade in (
            (self._bodies, at, np.repeat(size[:, None], 3, axis=1), SHADE),
            (self._wings, at + over, size[:, None] * beaten(poses.beat[rows]), 1.0),
        ):
            changes += [
                (node, "batched_positions", places(place, picture.length)),
                (node, "batched_wxyzs", turned(wxyz)),
                (node, "batched_scales", scale.astype(np.float32)),
                (node, "batched_colors", tone.lit(shade * colour)),
                (node, "cast_shadow", shadows),
                (node, "visible", True),
            ]
        return changes

    def hide(self) -> Changes:
        """Draw nobody."""
        return [(self._bodies, "visible", False), (self._wings, "visible", False)]


def upwards(wxyz: np.ndarray) -> np.ndarray:
    """The direction over the back, (N, 3), of birds of attitudes (N, 4)."""
    w, x, y, z = wxyz.T
    return np.column_stack(
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]
    )


def leftwards(wxyz: np.ndarray) -> np.ndarray:
    """The direction of the left wing, (N, 3), of birds of attitudes (N, 4)."""
    w, x, y, z = wxyz.T
    return np.column_stack(
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)]
    )


def _add(scene: SceneApi, name: str, mesh: Mesh) -> BatchedMeshHandle:
    return scene.add_batched_meshes_simple(
        name,
        *mesh,
        batched_wxyzs=np.array([[1.0, 0.0, 0.0, 0.0]]),
        batched_positions=np.zeros((1, 3)),
        batched_scales=np.ones((1, 3)),
        batched_colors=np.zeros((1, 3), dtype=np.uint8),
        flat_shading=True,
        side="double",
        lod="off",
        receive_shadow=False,
        visible=False,
    )
