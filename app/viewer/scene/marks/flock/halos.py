"""What sets the information agents apart: a golden ring, and in space a bubble around them."""

from __future__ import annotations

import numpy as np
from viser import BatchedMeshHandle, SceneApi

from app.viewer.scene.draw.coarse import places, turned
from app.viewer.scene.draw.drawn_frame import FEW_LEADERS, Changes, Picture
from app.viewer.scene.draw.shapes import Mesh, ball, ring, torus
from app.viewer.scene.shown import palette, tone


class Halos:
    """A flat ring is crisp from above but vanishes edge-on; a torus and a bubble do not."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._flat = _add(scene, f"{root}/flock/halos/flat", ring(0.86), 1.5, opacity=None)
        self._round = _add(scene, f"{root}/flock/halos/round", torus(), tone.LIGHT, opacity=None)
        self._bubble = _add(scene, f"{root}/flock/halos/bubble", ball(), 1.0, opacity=0.22)

    def draw(self, picture: Picture) -> Changes:
        rows = np.flatnonzero(picture.frame.informed)
        worn = 0 < len(rows) <= FEW_LEADERS
        flat = picture.stage.dim == 2
        changes: Changes = []
        for halo, shown in ((self._flat, flat), (self._round, not flat), (self._bubble, not flat)):
            if worn and shown:
                changes += _around(picture, rows, halo)
            changes.append((halo, "visible", worn and shown))
        return changes


def _around(picture: Picture, rows: np.ndarray, halo: BatchedMeshHandle) -> Changes:
    radius = 0.85 * picture.length * picture.size[rows]
    return [
        (halo, "batched_positions", places(picture.at[rows], picture.length)),
        (halo, "batched_wxyzs", turned(picture.wxyz[rows])),
        (halo, "batched_scales", radius.astype(np.float32)),
    ]


def _add(
    scene: SceneApi, name: str, mesh: Mesh, light: float, opacity: float | None
) -> BatchedMeshHandle:
    return scene.add_batched_meshes_simple(
        name,
        *mesh,
        batched_wxyzs=np.array([[1.0, 0.0, 0.0, 0.0]]),
        batched_positions=np.zeros((1, 3)),
        batched_scales=np.ones(1),
        batched_colors=tone.lit(palette.HALO, light),
        opacity=opacity,
        side="double" if opacity is None else "front",
        lod="off",
        cast_shadow=False,
        receive_shadow=False,
        visible=False,
    )
